#pragma once

#include <memory>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "slipstream/base/error.h"
#include "slipstream/devices/virtual_gige_camera.h"

namespace slipstream {

inline constexpr const char* served_address = "127.0.0.1";

/// A camera of those frames or reels at served_address; null where its port is taken or there is no
/// such address: the test is skipped then.
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
