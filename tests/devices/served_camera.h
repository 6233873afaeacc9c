#pragma once

#include <memory>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "devices/virtual_gige_camera.h"
#include "slipstream/error.h"

namespace slipstream {

inline constexpr const char* served_address = "127.0.0.1";

/// Serves frames or reels at served_address. Returns null if the address or port is unavailable;
/// REQUIRE_CAMERA then skips the test.
template <class Frames>
std::unique_ptr<VirtualGigeCamera> serve(Frames frames, const std::string& serial = "TEST") {
  try {
    return std::make_unique<VirtualGigeCamera>(std::move(frames), served_address, serial);
  } catch (const WorldError&) {
    return nullptr;
  }
}

}  // namespace slipstream

#define REQUIRE_CAMERA(camera)                                              \
  if (!(camera))                                                            \
  GTEST_SKIP() << "no camera can be served at 127.0.0.1: no such address, " \
                  "or UDP port 3956 is taken"
