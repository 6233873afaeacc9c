// Tests that draw without a window.
#pragma once

#include <gtest/gtest.h>

#include "view/opengl.h"

namespace slipstream::view {

class OffScreen : public testing::Test {
  const opengl::OffScreenContext context_;
};

}  // namespace slipstream::view
