// Lists of poses as programs write them.
#include "io/pose_list.h"

#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "io/file.h"
#include "tests/io/expect_error.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::pose_list_test {

class PoseList : public testing::Test {
 protected:
  std::filesystem::path written(const std::string& text) const {
    const std::filesystem::path path = folder_.path() / "poses.txt";
    write_file(path, text);
    return path;
  }
  [[nodiscard]] std::filesystem::path path(const char* name) const { return folder_.path() / name; }

 private:
  TemporaryFolder folder_;
};

TEST_F(PoseList, IsReadAsItWasWritten) {
  Eigen::Isometry3d pose(Eigen::Translation3d(1, -2, 3.5));
  pose.rotate(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()));
  write_pose_list(path("out.txt"), {{"a.ply", pose}, {"b.ply", pose.inverse()}});

  const auto listed = read_pose_list(path("out.txt"));
  ASSERT_EQ(listed.size(), 2U);
  EXPECT_EQ(listed[0].name, "a.ply");
  EXPECT_TRUE(listed[0].scalar_last.isApprox(pose, 1e-6));
  EXPECT_FALSE(listed[0].scalar_first.isApprox(pose, 1e-2));
  EXPECT_TRUE(listed[1].scalar_last.isApprox(pose.inverse(), 1e-6));
}

TEST_F(PoseList, TakesMatricesAndAnotherUnit) {
  const auto listed =
      read_pose_list(written("# views\nview1, 0 -1 0 0.5, 1 0 0 0.25, 0 0 1 -1, 0 0 0 1\n"), 1000);
  ASSERT_EQ(listed.size(), 1U);
  EXPECT_TRUE(listed[0].is_matrix);
  EXPECT_TRUE(listed[0].scalar_last.translation().isApprox(Eigen::Vector3d(500, 250, -1000)));
  EXPECT_DOUBLE_EQ(listed[0].scalar_last(1, 0), 1);
}

TEST_F(PoseList, IsWrittenInTheUnitThatItIsReadIn) {
  const Eigen::Isometry3d pose(Eigen::Translation3d(1.25, -2000, 3.5));
  write_pose_list(path("out.txt"), {{"a.ply", pose}}, 1000);
  EXPECT_NE(read_text(path("out.txt")).find("x y z (m)"), std::string::npos);
  EXPECT_TRUE(read_pose_list(path("out.txt"), 1000)[0].scalar_last.isApprox(pose, 1e-6));
}

TEST_F(PoseList, KeepsNamesThatNeedQuotes) {
  const Eigen::Isometry3d pose(Eigen::Translation3d(1, 2, 3));
  const std::vector<std::string> names{"my view.ply", "a,b;c",         "#1",
                                       "\"so\"",      "5\" wide, red", "plain\".ply"};
  std::vector<std::pair<std::string, Eigen::Isometry3d>> poses;
  for (const std::string& name : names) poses.emplace_back(name, pose);
  write_pose_list(path("out.txt"), poses);

  const auto listed = read_pose_list(path("out.txt"));
  ASSERT_EQ(listed.size(), names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    EXPECT_EQ(listed[i].name, names[i]);
    EXPECT_TRUE(listed[i].scalar_last.isApprox(pose));
  }
}

TEST_F(PoseList, NamesTheLineThatIsWrong) {
  expect_error([&] { (void)read_pose_list(written("a 0 0 0 0 0 0 1\nb 1 2\n")); }, {"line 2"});
  expect_error([&] { (void)read_pose_list(written("a 2 0 0 0 0 1 0 0 0 0 1 0\n")); },
               {"not a rotation"});
  expect_error([&] { (void)read_pose_list(written("a 0 0 0 0 0 0 0\n")); },
               {"line 1", "norm is 0"});
  expect_error([&] { (void)read_pose_list(written("a 0 0 inf 0 0 0 1\n")); }, {"line 1"});
  expect_error([&] { (void)read_pose_list(written("\"a 0 0 1 0 0 0 1\n")); }, {"closing quote"});
  expect_error([&] { (void)read_pose_list(written("# nothing\n")); }, {"no poses"});
}

}  // namespace slipstream::pose_list_test
