// Cameras by name. That names of cameras which are there open them is seen in
// virtual_gige_camera_test.cpp.
#include "slipstream/devices/open_camera.h"

#include <gtest/gtest.h>

#include "slipstream/base/error.h"
#include "tests/io/expect_error.h"

namespace slipstream::open_camera_test {

TEST(OpenCamera, RefusesNamesThatNameNone) {
  expect_error([] { open_camera("tape:1", {}); }, {"tape:1", "aravis:NAME, v4l2:NUMBER"});
  expect_error([] { open_camera("v4l2:x", {}); }, {"v4l2:x", "v4l2:0"});
  expect_error([] { open_camera("v4l2:-1", {}); }, {"v4l2:-1"});
  expect_error([] { open_camera("v4l2", {}); }, {"a number is wanted"});
}

TEST(OpenCamera, SaysWhichCameraDoesNotAnswer) {
  EXPECT_THROW(open_camera("v4l2:4000", {}), WorldError);
}

TEST(OpenCamera, RefusesSettingsBeforeItLooksForTheCamera) {
  EXPECT_THROW(open_camera("v4l2:4000", {.trigger = "Line1"}), Error);
}

TEST(ListCameras, NamesThemAsTheyAreOpened) {
  for (const CameraDescription& camera : list_cameras()) {
    EXPECT_TRUE(camera.name.starts_with("aravis:") || camera.name.starts_with("v4l2:"))
        << camera.name;
  }
}

}  // namespace slipstream::open_camera_test
