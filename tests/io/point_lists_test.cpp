// Points of boards that other programs found, in the forms in which they are saved.
#include "io/point_lists.h"

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "io/file.h"
#include "tests/io/expect_error.h"
#include "tests/io/numpy_files.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::point_lists_test {
namespace fs = std::filesystem;

/// Two poses of the six points of a board.
std::vector<PosePoints> known() {
  std::vector<PosePoints> poses;
  for (const int pose : {1, 2}) {
    PosePoints points{
        .name = fmt::format("pose{}", pose), .board = {}, .camera = {}, .projector = {}};
    for (int i = 0; i < 6; ++i) {
      const double x = 10 * (i % 3), y = 12.5 * (i / 3);
      points.board.emplace_back(x, y, 0);
      points.camera.emplace_back(100.25 * pose + 3 * x, 50 + 4 * y);
      points.projector.emplace_back(200 + 5 * x, 60.5 * pose + 6 * y);
    }
    poses.push_back(points);
  }
  return poses;
}

void expect_known(const PointLists& read) {
  const std::vector<PosePoints> truth = known();
  ASSERT_EQ(read.poses.size(), truth.size()) << read.layout;
  for (std::size_t pose = 0; pose < truth.size(); ++pose) {
    EXPECT_EQ(read.poses[pose].name, truth[pose].name);
    EXPECT_EQ(read.poses[pose].board, truth[pose].board) << read.layout;
    EXPECT_EQ(read.poses[pose].camera, truth[pose].camera) << read.layout;
    EXPECT_EQ(read.poses[pose].projector, truth[pose].projector) << read.layout;
  }
}

/// A table with those columns, after `header`: p pose, x y z board, u v camera, s t projector.
std::string table(const std::string& header, const std::string& columns, const char* between) {
  std::string text = header;
  for (const PosePoints& pose : known()) {
    for (std::size_t i = 0; i < pose.board.size(); ++i) {
      for (std::size_t c = 0; c < columns.size(); ++c) {
        const char column = columns[c];
        if (c > 0) text += between;
        if (column == 'p') text += pose.name.substr(4);
        if (std::string("xyz").find(column) != std::string::npos) {
          text += fmt::format("{}", pose.board[i][column - 'x']);
        }
        if (column == 'u' || column == 'v') text += fmt::format("{}", pose.camera[i][column - 'u']);
        if (column == 's' || column == 't') {
          text += fmt::format("{}", pose.projector[i][column - 's']);
        }
      }
      text += "\n";
    }
  }
  return text;
}

class PointListsInFiles : public testing::Test {
 protected:
  fs::path write(const std::string& name, const std::string& text) {
    write_file(folder_.path() / name, text);
    return folder_.path() / name;
  }

  TemporaryFolder folder_;
};

TEST_F(PointListsInFiles, AreReadAsTheyAreWritten) {
  const fs::path path = folder_.path() / "points.csv";
  write_point_list(path, known());
  expect_known(read_point_lists(path));
}

TEST_F(PointListsInFiles, MayBeTablesWithAndWithoutNames) {
  for (const auto& [header, columns, between] :
       {std::tuple("", "pxyuvst", " "), std::tuple("", "pxyzuvst", ","),
        std::tuple("# circles of May\n", "pxyuvst", "\t"),
        std::tuple("X,Y,Z,u,v,up,vp,pose\n", "xyzuvstp", ","),
        std::tuple("# proj_y proj_x cam_row cam_col board_x board_y view\n", "tsvuxyp", " "),
        std::tuple("pose;point;xw;yw;xc;yc;xp;yp\n", "ppxyuvst", ";")}) {
    SCOPED_TRACE(header + std::string(columns));
    expect_known(read_point_lists(write("points.txt", table(header, columns, between))));
  }
}

TEST_F(PointListsInFiles, MayBeAFileForEachPoseOrKind) {
  // 1. A whole table for each pose.
  std::string text = table("", "xyzuvst", " ");
  const std::size_t half = text.find("200.5");
  const std::size_t second = text.rfind('\n', half) + 1;
  write("pose_01.txt", text.substr(0, second));
  write("pose_02.txt", text.substr(second));
  expect_known(read_point_lists(folder_.path()));
  fs::remove(folder_.path() / "pose_01.txt");
  fs::remove(folder_.path() / "pose_02.txt");

  // 2. A file for each kind; the board is given once.
  const std::string board = table("", "xy", " ");
  write("object_points.txt", board.substr(0, board.size() / 2));
  write("camera_points.txt", table("", "uv", " "));
  write("projector_points.txt", table("", "st", ","));
  expect_known(read_point_lists(folder_.path()));
}

TEST_F(PointListsInFiles, MayBeArraysOfNumPy) {
  std::vector<double> board, camera, projector, camera_columns;
  for (const PosePoints& pose : known()) {
    for (std::size_t i = 0; i < 6; ++i) {
      board.insert(board.end(), {pose.board[i].x(), pose.board[i].y(), 0});
      camera.insert(camera.end(), {pose.camera[i].x(), pose.camera[i].y()});
      projector.insert(projector.end(), {pose.projector[i].x(), pose.projector[i].y()});
    }
  }

  // 1. As OpenCV's functions give them, beside a matrix of the camera.
  using Files = std::vector<std::pair<std::string, std::string>>;
  const Files files{{"objpoints.npy", npy_of(board, "2, 6, 3")},
                    {"imgpoints.npy", npy_of(camera, "2, 6, 1, 2")},
                    {"projpoints.npy", npy_of(projector, "2, 6, 1, 2")},
                    {"cameraMatrix.npy", npy_of(Eigen::MatrixXd(Eigen::Matrix3d::Identity()))}};
  expect_known(read_point_lists(write("points.npz", zip_of(files, false))));

  // 2. A board for all poses, and arrays of each.
  const auto part = [](const std::vector<double>& of, int pose) {
    const auto half = static_cast<std::ptrdiff_t>(of.size() / 2);
    return std::vector<double>(of.begin() + pose * half, of.begin() + (pose + 1) * half);
  };
  const Files by_pose{{"board.npy", npy_of(part(board, 0), "6, 3")},
                      {"cam_0.npy", npy_of(part(camera, 0), "6, 2")},
                      {"cam_1.npy", npy_of(part(camera, 1), "6, 2")},
                      {"proj_0.npy", npy_of(part(projector, 0), "6, 2")},
                      {"proj_1.npy", npy_of(part(projector, 1), "6, 2")}};
  const PointLists read = read_point_lists(write("points.npz", zip_of(by_pose, true)));
  ASSERT_EQ(read.poses.size(), 2U);
  EXPECT_EQ(read.poses[1].camera, known()[1].camera);
  EXPECT_EQ(read.poses[1].board, known()[1].board);
}

TEST_F(PointListsInFiles, MayLackPixels) {
  const PointLists read = read_point_lists(write(
      "points.csv",
      "pose,x,y,u,v,up,vp\na,0,0,1,2,,\na,1,0,nan,nan,3,4\na,1,1,-1,-1,5,6\na,0,1,7,8,0,0\n"));
  ASSERT_EQ(read.poses.size(), 1U);
  EXPECT_EQ(read.poses[0].name, "a");
  EXPECT_FALSE(read.poses[0].projector[0].allFinite());
  EXPECT_FALSE(read.poses[0].camera[1].allFinite());
  EXPECT_FALSE(read.poses[0].camera[2].allFinite());
  EXPECT_FALSE(read.poses[0].projector[3].allFinite());
  EXPECT_EQ(read.poses[0].projector[1], Eigen::Vector2d(3, 4));
}

TEST_F(PointListsInFiles, MayHaveLinesOfOnlyBracketsOrQuotes) {
  for (const char* const line : {"[\n", "]\n", "\"\"\n", "# []\n"}) {
    SCOPED_TRACE(line);
    const std::string text = table("", "pxyuvst", " ");
    expect_known(read_point_lists(write("points.txt", line + text)));
    expect_known(read_point_lists(write("points.txt", text + line)));
  }
}

TEST_F(PointListsInFiles, KeepLongNumbersOfPosesApart) {
  const PointLists read =
      read_point_lists(write("points.csv",
                             "pose,x,y,u,v,up,vp\n20240101,0,0,1,2,3,4\n20240101,1,0,2,2,4,4\n"
                             "20240102,0,0,1,2,3,4\n20240102,1,0,2,2,4,4\n"));
  ASSERT_EQ(read.poses.size(), 2U);
  EXPECT_EQ(read.poses[0].name, "pose20240101");
  EXPECT_EQ(read.poses[1].name, "pose20240102");
}

TEST_F(PointListsInFiles, MayBeHundredsOfArrays) {
  std::vector<std::pair<std::string, std::string>> files{
      {"board.npy", npy_of(std::vector<double>{0, 0, 10, 0}, "2, 2")}};
  for (int pose = 0; pose < 150; ++pose) {
    files.emplace_back(fmt::format("cam_{}.npy", pose),
                       npy_of(std::vector<double>{1, 2, 3, 4}, "2, 2"));
    files.emplace_back(fmt::format("proj_{}.npy", pose),
                       npy_of(std::vector<double>{5, 6, 7, 8}, "2, 2"));
  }
  EXPECT_EQ(read_point_lists(write("points.npz", zip_of(files, false))).poses.size(), 150U);
}

TEST_F(PointListsInFiles, SayWhatIsMissing) {
  const auto expect_refused = [&](const std::string& text,
                                  std::initializer_list<std::string> parts) {
    const fs::path path = write("points.csv", text);
    expect_error([&] { (void)read_point_lists(path); }, parts);
  };

  expect_refused("1 2 3\n", {"points.csv", "no points among points (3 columns)"});
  expect_refused("1 0 0 1 2 3 4\n1 1 0 1 2 3\n", {"line 2: expected 7 fields"});
  expect_refused("1 0 0 1 2 3 4\n1 1 0 1 2 x 4\n", {"line 2: 'x' is not a number"});
  expect_refused("x,y,u,up,vp\n1,2,3,4,5\n", {"do not give x and y of the camera once"});
  expect_refused("x,y,u,v\n1,2,3,4\n", {"0 of the projector"});
  expect_refused("\n", {"no points"});

  // Lists of different lengths, which only Python can read.
  const fs::path path =
      write("points.npz", zip_of({{"cam.npy", npy_of({}, "2,", false, "|O")}}, false));
  expect_error([&] { (void)read_point_lists(path); }, {"cam holds lists of different lengths"});
}

}  // namespace slipstream::point_lists_test
