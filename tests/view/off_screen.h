// Tests that draw without a window.
#pragma once

#include <optional>

#include <gtest/gtest.h>

#include "slipstream/error.h"
#include "view/opengl.h"

namespace slipstream::view {

/// Skips tests where OpenGL cannot draw.
class OffScreen : public testing::Test {
 protected:
  void SetUp() override {
    try {
      context_.emplace();
    } catch (const WorldError& error) {
      GTEST_SKIP() << error.what();
    }
  }

 private:
  std::optional<opengl::OffScreenContext> context_;
};

}  // namespace slipstream::view
