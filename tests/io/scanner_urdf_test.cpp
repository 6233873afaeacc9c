#include "io/scanner_urdf.h"

#include <numbers>
#include <random>
#include <regex>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "base/numbers.h"
#include "slipstream/error.h"
#include "slipstream/named_scenes.h"

namespace slipstream::scanner_urdf_test {

/// The transform of a joint from its child to its parent, by the rules of URDF.
Eigen::Isometry3d joint_of(const std::string& text, const std::string& name) {
  const std::regex origin("<joint name=\"" + name +
                          "\"[\\s\\S]*?<origin xyz=\"(.*?)\" rpy=\"(.*?)\"/>");
  std::smatch found;
  EXPECT_TRUE(std::regex_search(text, found, origin)) << text;
  const std::vector<double> xyz = numbers_in<double>(found[1].str(), ' '),
                            rpy = numbers_in<double>(found[2].str(), ' ');
  EXPECT_EQ(xyz.size(), 3U);
  EXPECT_EQ(rpy.size(), 3U);

  // About the fixed axes x, y and z, one after the other.
  const Eigen::AngleAxisd roll(rpy[0], Eigen::Vector3d::UnitX()),
      pitch(rpy[1], Eigen::Vector3d::UnitY()), yaw(rpy[2], Eigen::Vector3d::UnitZ());
  return Eigen::Translation3d(xyz[0], xyz[1], xyz[2]) * (yaw * pitch * roll);
}

void expect_projector_where_it_is(const Scanner& scanner) {
  const Eigen::Isometry3d joint = joint_of(urdf_of(scanner), "projector_joint");
  for (const Eigen::Vector3d& point :
       {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(30, -70, 600), Eigen::Vector3d(-200, 5, 90)}) {
    const Eigen::Vector3d in_projector = in_projector_frame(scanner, point) / 1000;
    EXPECT_LT((joint * in_projector - point / 1000).norm(), 1e-8);
  }
}

TEST(ScannerUrdf, HasTheProjectorWhereItIsInMetres) {
  Scanner scanner = example_scanner({64, 48});
  expect_projector_where_it_is(scanner);

  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int i = 0; i < 50; ++i) {
    scanner.rotation = Eigen::Quaterniond(any(random), any(random), any(random), any(random))
                           .normalized()
                           .toRotationMatrix();
    scanner.translation = 300 * Eigen::Vector3d(any(random), any(random), any(random));
    expect_projector_where_it_is(scanner);
  }

  // Where roll and yaw are the same turn.
  for (const double pitch : {std::numbers::pi / 2, -std::numbers::pi / 2}) {
    scanner.rotation = (Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()) *
                        Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()))
                           .toRotationMatrix();
    expect_projector_where_it_is(scanner);
  }
}

TEST(ScannerUrdf, HasTheAxesOfRep103) {
  const Eigen::Isometry3d joint =
      joint_of(urdf_of(example_scanner({64, 48})), "camera_optical_joint");
  EXPECT_LT((joint * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitX()).norm(), 1e-12)
      << "forward";
  EXPECT_LT((joint * Eigen::Vector3d::UnitX() + Eigen::Vector3d::UnitY()).norm(), 1e-12)
      << "right is minus left";
  EXPECT_LT((joint * Eigen::Vector3d::UnitY() + Eigen::Vector3d::UnitZ()).norm(), 1e-12)
      << "down is minus up";
}

TEST(ScannerUrdf, AsAMacroHasAPrefixAndAParent) {
  const std::string text = xacro_of(example_scanner({64, 48}));
  EXPECT_NE(text.find("params=\"prefix:='' parent *origin\""), std::string::npos);
  EXPECT_NE(text.find("<link name=\"${prefix}camera_optical\"/>"), std::string::npos);
  EXPECT_NE(text.find("<parent link=\"${parent}\"/>"), std::string::npos);
}

TEST(ScannerUrdf, NeedsGeometry) {
  EXPECT_THROW(urdf_of(without_geometry({64, 48}, {10, 10})), Error);
}

}  // namespace slipstream::scanner_urdf_test
