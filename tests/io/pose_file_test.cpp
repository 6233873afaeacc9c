#include "io/pose_file.h"

#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "base/numbers.h"
#include "io/file.h"
#include "tests/io/expect_error.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::pose_file_test {

const std::string names = "from: camera\nto: base\nunit: mm\n";
const std::string place = "translation: [10, 20, 500]\n";

FramePose pose_of(const std::string& text) {
  return pose_in_text(text, "pose.yaml");
}

std::vector<PoseNotation> all_notations() {
  std::vector<PoseNotation> all;
  for (const char* name :
       {"matrix", "quaternion xyzw", "quaternion wxyz", "rotation-vector", "euler intrinsic zyx",
        "euler extrinsic xyz", "euler intrinsic zyz", "euler extrinsic yxy"}) {
    for (const bool metres : {false, true}) {
      for (const bool degrees : {false, true}) {
        PoseNotation notation = pose_notation_named(name);
        notation.metres = metres;
        notation.degrees = degrees;
        all.push_back(notation);
      }
    }
  }
  return all;
}

RC_GTEST_PROP(PoseFile, EveryNotationReturnsThePose, ()) {
  const auto any = [] { return *rc::gen::inRange(-32, 33) / 8.0; };
  const Eigen::Vector3d turn(any(), any(), any()), shift(any(), any(), any());
  const FramePose pose{"camera", "base", pose_from(rotation_of_vector(turn), 1000 * shift)};

  for (const PoseNotation& notation : all_notations()) {
    const FramePose again = pose_of(text_of(pose, notation));
    RC_ASSERT(again.from == pose.from && again.to == pose.to);
    const Eigen::Matrix4d off = again.transform.matrix() - pose.transform.matrix();
    RC_ASSERT(off.cwiseAbs().maxCoeff() < 1e-9);
  }
}

TEST(PoseFile, CanonicalFormIsStable) {
  const TemporaryFolder folder;
  const FramePose pose =
      pose_of(names + place + "euler: [30, -20, 10]\norder: intrinsic zyx\n" + "angles: degrees\n");
  write_pose(folder.path() / "a.yaml", pose);
  write_pose(folder.path() / "b.yaml", read_pose(folder.path() / "a.yaml"));
  EXPECT_EQ(read_text(folder.path() / "a.yaml"), read_text(folder.path() / "b.yaml"));
  EXPECT_NE(read_text(folder.path() / "a.yaml").find("matrix:\n  - ["), std::string::npos);
  expect_error([&] { write_pose(folder.path() / "a.txt", pose); }, {"a.txt", ".yaml"});
}

TEST(PoseFile, NotationsOfOneRotationAgree) {
  // A quarter turn about z takes x to y.
  const double half = std::sqrt(0.5);
  const std::string q = fmt::format("{}", half);
  for (const std::string& rotation :
       {"quaternion: [0, 0, " + q + ", " + q + "]\norder: xyzw\n",
        "quaternion: [" + q + ", 0, 0, " + q + "]\norder: wxyz\n",
        std::string("rotation_vector: [0, 0, 1.5707963267948966]\n"),
        std::string("rotation_vector: [0, 0, 90]\nangles: degrees\n"),
        std::string("euler: [90, 0, 0]\norder: intrinsic zyx\nangles: degrees\n"),
        std::string("euler: [0, 0, 90]\norder: extrinsic xyz\nangles: degrees\n"),
        std::string("matrix: [[0, -1, 0], [1, 0, 0], [0, 0, 1]]\n"),
        std::string("matrix: [0, -1, 0, 1, 0, 0, 0, 0, 1]\n")}) {
    const FramePose pose = pose_of(names + place + rotation);
    const Eigen::Vector3d moved = pose.transform * Eigen::Vector3d(100, 0, 0);
    EXPECT_LT((moved - Eigen::Vector3d(10, 120, 500)).norm(), 1e-9) << rotation;
  }
}

TEST(PoseFile, MetresBecomeMillimetres) {
  const FramePose pose = pose_of(
      "{from: tool0, to: base, unit: m, translation: [0.5, 0, -1], rotation_vector: "
      "[0, 0, 0]}");
  EXPECT_EQ(pose.transform.translation(), Eigen::Vector3d(500, 0, -1000));
  EXPECT_EQ(pose.from, "tool0");
}

TEST(PoseFile, TranslationMayBeTheMatrixsColumn) {
  const FramePose pose = pose_of(names +
                                 "matrix:\n  - [1, 0, 0, 7]\n  - [0, 1, 0, 8]\n  - [0, 0, 1, 9]\n"
                                 "  - [0, 0, 0, 1]\n");
  EXPECT_EQ(pose.transform.translation(), Eigen::Vector3d(7, 8, 9));
}

/// A file with a mistake, and what its one line says.
using Broken = std::pair<std::string, std::vector<std::string>>;

TEST(PoseFile, EachMistakeGetsOneLine) {
  const std::string identity = "matrix: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n";
  const std::string euler = "euler: [1, 2, 3]\n";
  const std::vector<Broken> all{
      {"", {"expected the entries of a pose"}},
      {"- 1\n- 2\n", {"expected the entries of a pose"}},
      {"from: [camera\n", {"line", "not YAML"}},
      {"to: base\nunit: mm\n" + place + identity, {"from is missing"}},
      {"from: camera\nunit: mm\n" + place + identity, {"to is missing"}},
      {"from: camera\nto: base\n" + place + identity, {"unit is missing"}},
      {"from: camera\nto: camera\nunit: mm\n" + place + identity, {"line 2", "both camera"}},
      {"from: the camera\nto: base\nunit: mm\n" + place + identity, {"line 1", "name a frame"}},
      {"from: camera\nto: base\nunit: cm\n" + place + identity, {"line 3", "cm", "mm nor m"}},
      {names + identity, {"translation is missing"}},
      {names + place, {"no rotation", "quaternion"}},
      {names + place + identity + "rotation_vector: [0, 0, 0]\n", {"matrix and rotation_vector"}},
      {names + "translation: [1, 2]\n" + identity, {"line 4", "expected 3 numbers, got 2"}},
      {names + "translation: 5\n" + identity, {"line 4", "list of numbers"}},
      {names + "translation: [1, two, 3]\n" + identity, {"'two' is not a number"}},
      {names + "translation: [1, nan, 3]\n" + identity, {"nan is not finite"}},
      {names + place + "matrix: [[1, 0, 0], [0, 1, 0], [0, 0, 2]]\n", {"line 5", "not a rotation"}},
      {names + place + "matrix: [[1, 0, 0], [0, 1, 0], [0, 0, -1]]\n", {"line 5", "mirrors"}},
      {names + place + "matrix: [1, 2, 3, 4]\n", {"3 rows of 3"}},
      {names + "matrix: [1,0,0,0, 0,1,0,0, 0,0,1,0, 7,8,9,1]\n", {"transposed"}},
      {names + place + "matrix: [1,0,0,0, 0,1,0,0, 0,0,1,0]\n", {"line 4", "translation"}},
      {names + place + "quaternion: [0, 0, 0, 1]\n", {"order is missing"}},
      {names + place + "quaternion: [0, 0, 0, 1]\norder: wzyx\n", {"line 6", "xyzw or wxyz"}},
      {names + place + "quaternion: [0, 0, 0.5, 1]\norder: xyzw\n", {"line 5", "norm is 1.118"}},
      {names + place + "quaternion: [0, 0, 1]\norder: xyzw\n", {"expected 4 numbers"}},
      {names + place + euler + "angles: degrees\n", {"order is missing"}},
      {names + place + euler + "order: zyx\nangles: degrees\n", {"line 6", "intrinsic"}},
      {names + place + euler + "order: intrinsic zyx\n", {"angles is missing"}},
      {names + place + euler + "order: intrinsic zyx\nangles: deg\n", {"line 7", "deg"}},
      {names + place + identity + "order: xyzw\n", {"line 6", "a matrix has none"}},
      {names + place + identity + "scale: 2\n", {"line 6", "no entry 'scale'"}},
      {names + place + "quaternoin: [0, 0, 0, 1]\n", {"did you mean quaternion"}},
      {names + place + identity + identity, {"set twice"}},
      {names + place + identity + "---\nfrom: x\n", {"second YAML document"}}};

  for (const auto& [text, words] : all) {
    try {
      pose_of(text);
      ADD_FAILURE() << "accepted:\n" << text;
    } catch (const Error& error) {
      const std::string message = error.what();
      EXPECT_TRUE(message.starts_with("pose.yaml: ")) << message;
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
      for (const std::string& word : words) {
        EXPECT_NE(message.find(word), std::string::npos) << message << "\nlacks: " << word;
      }
    }
  }
}

TEST(PoseFile, NotationsAreNamed) {
  EXPECT_EQ(pose_notation_named("euler extrinsic xyz").euler_order, (EulerOrder{{0, 1, 2}, false}));
  for (const char* text : {"", "euler", "euler zyx", "quaternion", "rpy", "matrix 4"}) {
    EXPECT_THROW(pose_notation_named(text), Error) << text;
  }
}

}  // namespace slipstream::pose_file_test
