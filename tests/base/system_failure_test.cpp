#include "base/system_failure.h"

#include <string>

#include <gtest/gtest.h>

#include "slipstream/error.h"
#include "tests/io/small_disk.h"

namespace slipstream::system_failure_test {

TEST(SystemFailure, RequireDescriptorsNamesTheWorkAndHowManyAreLeft) {
  EXPECT_NO_THROW(require_descriptors(16, "a camera"));

  const FewDescriptors none(0);
  try {
    require_descriptors(16, "a camera");
    FAIL() << "no error";
  } catch (const WorldError& error) {
    EXPECT_EQ(std::string(error.what()).find("a camera: needs 16 file descriptors, but only 0"), 0U)
        << error.what();
  }
}

TEST(SystemFailure, RequireDescriptorsLeavesAllOfThemFree) {
  for (int turn = 0; turn < 100; ++turn) require_descriptors(64, "a camera");
}

}  // namespace slipstream::system_failure_test
