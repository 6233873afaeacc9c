// Pose guidance on virtual pictures, and a whole guided calibration without devices.
#include "calibrate/pose_guide.h"

#include <algorithm>
#include <string>

#include <gtest/gtest.h>

#include "calibrate/board_corners.h"
#include "frames/scan_camera.h"
#include "slipstream/board_capture.h"
#include "slipstream/named_scenes.h"
#include "slipstream/scan_files.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"
#include "tests/io/expect_error.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::pose_guide_test {
namespace fs = std::filesystem;

const CalibrationBoard board{.columns = 7, .rows = 5, .spacing = 22};
const Scanner truth = example_scanner({320, 240});

Body sheet_at(int pose) {
  constexpr int pixels = 100;
  Body sheet = printed_sheet(draw_board(board, pixels), board.spacing / pixels, truth);
  const auto& [width, height] = std::get<Board>(sheet.shape);
  sheet.pose = board_poses(truth, pose + 1, width, height).back();
  return sheet;
}

/// The board under uniform light of `light` grey levels.
FrameSet lit(int pose, double light, double ambient = 5) {
  const PatternSet plain{.count = 1,
                         .axis = Axis::x,
                         .light = {.alpha_p = light, .beta_p = 0},
                         .shape = [](int, double) { return 1.0; }};
  return take_scan(truth, {sheet_at(pose)}, plain, {.ambient = ambient, .noise_variance = 1})
      .frames;
}

FringeFreePictures pictures_of(const FrameSet& frames) {
  return fringe_free_pictures(frames, frames);
}

BoardView view_of(int pose) {
  const std::optional<BoardCorners> found = find_board(board, pictures_of(lit(pose, 200)));
  EXPECT_TRUE(found);
  return {.name = "board01",
          .places = found->places,
          .camera = found->pixels,
          .projector = found->pixels};
}

PoseState state_of(const FrameSet& frames, bool still = true,
                   const std::vector<BoardView>& taken = {}) {
  const PoseVerdict verdict = judge_pose(pictures_of(frames), still, board, taken);
  EXPECT_FALSE(verdict.words.empty());
  return verdict.state;
}

TEST(PoseGuide, TellsWhatSpeaksAgainstAPose) {
  EXPECT_EQ(state_of(lit(0, 200)), PoseState::good);
  EXPECT_EQ(state_of(lit(0, 200), false), PoseState::moving);
  EXPECT_EQ(state_of(lit(0, 200), true, {view_of(0)}), PoseState::known);
  EXPECT_EQ(state_of(lit(1, 200), true, {view_of(0)}), PoseState::good);
  EXPECT_EQ(state_of(lit(0, 400)), PoseState::overexposed);
  EXPECT_EQ(state_of(lit(0, 25)), PoseState::dark);
  EXPECT_EQ(state_of(FrameSet(std::vector{Image<std::uint8_t>({320, 240}, 100)})),
            PoseState::unseen);
}

TEST(PoseGuide, ABlurredBoardIsToFocusOn) {
  FringeFreePictures pictures = pictures_of(lit(0, 200));
  Image<float> blurred = pictures.mean;
  constexpr int reach = 3;
  for (int row = reach; row + reach < blurred.height(); ++row) {
    for (int column = reach; column + reach < blurred.width(); ++column) {
      float sum = 0;
      for (int y = -reach; y <= reach; ++y) {
        for (int x = -reach; x <= reach; ++x) sum += pictures.mean(column + x, row + y);
      }
      blurred(column, row) = sum / ((2 * reach + 1) * (2 * reach + 1));
    }
  }
  const PoseVerdict verdict = judge_pose({blurred, blurred}, true, board, {});
  EXPECT_EQ(verdict.state, PoseState::blurred) << verdict.words;
}

TEST(PoseGuide, SaysWhatIsMissing) {
  const PoseNeeds none = pose_needs({}, board, truth.camera.size, 0);
  EXPECT_FALSE(none.enough);
  EXPECT_EQ(none.covered, 0);
  EXPECT_EQ(std::count(none.tilted.begin(), none.tilted.end(), true), 0);
  EXPECT_NE(none.advice.find("left edge"), std::string::npos) << none.advice;
  EXPECT_NE(none.advice.find("top left"), std::string::npos) << none.advice;

  std::vector<BoardView> taken;
  for (int pose = 0; pose < 12; ++pose) taken.push_back(view_of(pose));
  const PoseNeeds many = pose_needs(taken, board, truth.camera.size, 0);
  EXPECT_EQ(std::count(many.tilted.begin(), many.tilted.end(), true), 4);
  EXPECT_GT(many.covered, 0.4);
  EXPECT_TRUE(pose_needs(taken, board, truth.camera.size, 12).enough);
  EXPECT_FALSE(pose_needs(taken, board, truth.camera.size, 13).enough);
  std::vector<BoardView> again = taken;
  again.insert(again.end(), taken.begin(), taken.end());
  EXPECT_TRUE(pose_needs(again, board, truth.camera.size, 0).enough);
}

/// Ten views of a board that fills the picture, tilted about these axes in turn, either way.
std::vector<BoardView> filling(const std::vector<Eigen::Vector3d>& axes) {
  const std::vector<Eigen::Vector3d> places = printed_places(board);
  const Eigen::Vector3d middle = places.back() / 2;
  const double depth = truth.camera.intrinsic(0, 0) * places.back().x() / (0.9 * 320);

  std::vector<BoardView> views(10);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const double angle = i / axes.size() % 2 == 0 ? 0.35 : -0.35;
    const Eigen::AngleAxisd turn(angle, axes[i % axes.size()]);
    for (std::size_t k = 0; k < places.size(); ++k) {
      const Eigen::Vector3d point = turn * (places[k] - middle) + Eigen::Vector3d(0, 0, depth);
      views[i].places.push_back(static_cast<int>(k));
      views[i].camera.push_back(project(truth.camera, point));
    }
    views[i].projector = views[i].camera;
  }
  return views;
}

TEST(PoseGuide, TenPosesAreEnoughIfTheyAreTiltedInAllWays) {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY();
  EXPECT_FALSE(pose_needs(filling({x}), board, truth.camera.size, 0).enough);
  EXPECT_TRUE(pose_needs(filling({x, y}), board, truth.camera.size, 0).enough);
}

/// The guide must name the edge that is truly nearer.
TEST(PoseGuide, KnowsWhichEdgeIsNearer) {
  for (int pose = 0; pose < 6; ++pose) {
    const Eigen::Matrix3d turn = sheet_at(pose).pose.linear();
    const PoseNeeds needs = pose_needs({view_of(pose)}, board, truth.camera.size, 0);
    for (const auto& [edge, farther] : {std::pair(0, turn(2, 0)), std::pair(1, -turn(2, 0)),
                                        std::pair(2, turn(2, 1)), std::pair(3, -turn(2, 1))}) {
      if (std::abs(std::abs(farther) - 0.2) < 0.1) continue;  // too close to the limit
      EXPECT_EQ(needs.tilted[static_cast<std::size_t>(edge)], farther > 0.2)
          << pose << " " << edge << " " << farther;
    }
  }
}

TEST(PoseGuide, DrawsAllOfIt) {
  const FringeFreePictures pictures = pictures_of(lit(1, 200));
  const std::vector<BoardView> taken{view_of(0)};
  const PoseVerdict verdict = judge_pose(pictures, true, board, taken);
  const PoseNeeds needs = pose_needs(taken, board, truth.camera.size, 0);
  const Image<Colour> drawn = drawn_guide(pictures.mean, verdict, needs, taken);
  EXPECT_EQ(drawn.size(), (Size{1600, 1200}));
  const auto has = [&](Colour colour) {
    return std::find(drawn.begin(), drawn.end(), colour) != drawn.end();
  };
  EXPECT_TRUE(has(colour_of(PoseState::good)));
  EXPECT_NE(colour_of(PoseState::good), colour_of(PoseState::unseen));
}

/// A camera that sees a board in successive poses, each twice: moving, then still.
class HeldBoard : public ScanCamera {
 public:
  explicit HeldBoard(const Sequence& sequence) : sequence_(sequence) {}

  std::optional<Glimpse> look(std::chrono::milliseconds) override {
    const bool still = looks_ % 2 == 1;
    if (!still) frames_ = scans_of(looks_ / 2);
    ++looks_;
    return Glimpse{frames_, still};
  }
  std::optional<std::vector<FrameSet>> take() override {
    ++takes_;
    if (takes_ == 2) return std::nullopt;  // it moved
    return frames_;
  }

 private:
  [[nodiscard]] std::vector<FrameSet> scans_of(int pose) const {
    std::vector<FrameSet> scans;
    for (const PatternSet& set : along_both_axes(sequence_)) {
      scans.push_back(
          take_scan(truth, {sheet_at(pose)}, set, {.ambient = 5, .noise_variance = 1, .seed = 3})
              .frames);
    }
    return scans;
  }

  Sequence sequence_;
  std::vector<FrameSet> frames_;
  int looks_ = 0, takes_ = 0;
};

const Sequence sequence{.strategy = DualFrequency{.steps = 3, .high = 8, .low = 1},
                        .projector = truth.projector.size};

TEST(PoseGuide, GuidedPosesTakesGoodOnesAndWritesWhatCalibrateReads) {
  const TemporaryFolder folder;
  const fs::path poses = folder.path() / "poses";
  HeldBoard camera(sequence);
  GuidedPosesSettings settings;
  settings.wanted = 3;
  settings.save = [](const fs::path& path, const Scan& scan) {
    save_scan(path, scan.frames, scan.sequence);
  };
  std::vector<PoseState> told;
  settings.on_progress = [&](const PoseProgress& progress) {
    told.push_back(progress.verdict.state);
  };
  const std::vector<BoardView> taken = take_guided_poses(camera, poses, board, sequence, settings);
  ASSERT_EQ(taken.size(), 3U);
  EXPECT_EQ(std::count(told.begin(), told.end(), PoseState::taken), 3);
  EXPECT_EQ(std::count(told.begin(), told.end(), PoseState::good), 4) << "one of them moved";

  const auto scans = board_scans(poses, {}, Axis::x);
  const PoseCaptures captures =
      capture_poses(poses, scans, {}, board, {}, [](const std::string&) {});
  ASSERT_EQ(captures.views.size(), 3U);
  EXPECT_EQ(captures.views[1].camera, taken[1].camera);
  EXPECT_EQ(captures.views[1].name, "board02");
}

TEST(PoseGuide, GuidedPosesRefusesAnUnlitBoardOnceUntilItMoves) {
  const TemporaryFolder folder;
  Sequence dim = sequence;
  dim.light = {.alpha_p = 6, .beta_p = 200};  // bright, but fringes too weak
  HeldBoard camera(dim);
  GuidedPosesSettings settings;
  int looks = 0, refusals = 0;
  std::string words;
  settings.ends = [&] { return ++looks > 4; };
  settings.on_progress = [&](const PoseProgress& progress) {
    if (progress.verdict.state != PoseState::refused) return;
    ++refusals;
    words = progress.verdict.words;
  };
  EXPECT_TRUE(take_guided_poses(camera, folder.path() / "poses", board, dim, settings).empty());
  EXPECT_GE(refusals, 1);
  EXPECT_NE(words.find("refused: "), std::string::npos) << words;
}

TEST(PoseGuide, GuidedPosesLeavesAFolderAloneThatHoldsSomething) {
  const TemporaryFolder folder;
  fs::create_directories(folder.path() / "poses" / "board01");
  HeldBoard camera(sequence);
  expect_error([&] { take_guided_poses(camera, folder.path() / "poses", board, sequence, {}); },
               {"poses", "not empty"});
}

}  // namespace slipstream::pose_guide_test
