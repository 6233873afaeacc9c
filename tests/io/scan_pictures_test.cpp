// White, black and repeated pictures beside those of the patterns.
#include <algorithm>
#include <numeric>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "io/file.h"
#include "io/image_file.h"
#include "slipstream/named_scenes.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/scan_files.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"
#include "tests/io/expect_error.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::scan_pictures_test {
namespace fs = std::filesystem;

const Scanner scanner = example_scanner({96, 72});

FrameSet frames_of(const Strategy& strategy, Axis axis = Axis::x) {
  const Sequence sequence{.strategy = strategy, .axis = axis, .projector = scanner.projector.size};
  return take_scan(scanner, scene_named("statue", scanner), pattern_set(sequence),
                   {.ambient = 5, .noise_variance = 1.6})
      .frames;
}

/// The white and the black picture of the same scene.
FrameSet white_and_black() {
  const FrameSet code = frames_of(make_strategy("gray", {}));
  std::vector<std::pair<double, int>> sums;
  for (int n = 0; n < code.count(); ++n) {
    std::vector<double> one(static_cast<std::size_t>(n) + 1);
    one.back() = 1;
    const Image<double> picture = weighted_sum(code, one);
    sums.emplace_back(std::accumulate(picture.begin(), picture.end(), 0.), n);
  }
  const auto [black, white] = std::minmax_element(sums.begin(), sums.end());
  std::vector<int> order(static_cast<std::size_t>(code.count()));
  std::iota(order.begin(), order.end(), 0);
  std::swap(order[0], order[static_cast<std::size_t>(white->second)]);
  std::iter_swap(order.begin() + 1, std::find(order.begin(), order.end(), black->second));
  return parts_of(reordered(code, order), {2}).front();
}

class ScanPictures : public testing::Test {
 protected:
  [[nodiscard]] const fs::path& folder() const { return folder_.path(); }

  /// Writes further pictures, as frame_000.png and so on.
  void add(const FrameSet& frames) {
    std::vector<fs::path> files;
    for (int n = 0; n < frames.count(); ++n) {
      files.push_back(folder() / fmt::format("frame_{:03}.png", pictures_++));
    }
    write_frames(files, frames);
  }
  Scan load(const std::string& strategy, const std::string& order = "") const {
    return load_scan(folder(), {.sequence = {.strategy = strategy}, .order = order});
  }

 private:
  TemporaryFolder folder_;
  int pictures_ = 0;
};

void expect_same(const FrameSet& a, const FrameSet& b) {
  ASSERT_EQ(a.count(), b.count());
  const std::vector<double> weights{1, 10, 100, 1000, 1e4, 1e5};
  const Image<double> of_a = weighted_sum(a, weights), of_b = weighted_sum(b, weights);
  EXPECT_TRUE(std::equal(of_a.begin(), of_a.end(), of_b.begin()));
}

TEST_F(ScanPictures, WhiteAndBlackAfterThePatternsAreNamedAndLeftOut) {
  const FrameSet patterns = frames_of(DualFrequency{});
  add(patterns);
  add(white_and_black());
  expect_error([&] { load("dual-frequency"); },
               {"8 frames", "has 6", "2 too many", "frames 6 (white), 7 (black)",
                "try `order 0,1,2,3,4,5`"});
  const Scan scan = load("dual-frequency", "0,1,2,3,4,5");
  expect_same(scan.frames, patterns);
  expect_same(load("dual-frequency", "2,0,1,3,4,5").frames,
              reordered(patterns, {2, 0, 1, 3, 4, 5}));
}

TEST_F(ScanPictures, WhiteAloneBeforeThePatternsIsToo) {
  const FrameSet patterns = frames_of(PhaseMeasuring{.steps = 4});
  add(parts_of(white_and_black(), {1}).front());
  add(patterns);
  expect_error([&] { load("pmp"); }, {"has 3", "2 too many", "leave them out"});
  const ScanChanges four{.sequence = {.strategy = "pmp", .settings = {{"steps", "4"}}}};
  expect_error([&] { load_scan(folder(), four); },
               {"1 too many, likely frame 0 (white); try `order 1,2,3,4`"});
}

TEST_F(ScanPictures, ARepeatedOneIsToo) {
  const FrameSet patterns = frames_of(make_strategy("gray-phase", {}));
  add(patterns);
  add(parts_of(patterns, {1}).front());
  expect_error([&] { load("gray-phase"); }, {"1 too many, likely frame 10 (repeats frame 0)"});
}

TEST_F(ScanPictures, TooFewOrManyTellWhatTheStrategyHasAndWhatWouldFit) {
  add(parts_of(frames_of(GrayCode{}), {10}).front());

  struct Mistake {
    SequenceChanges changes;
    std::string words;
  };
  const SequenceChanges gray{.strategy = "gray"};
  for (const auto& [changes, words] :
       {Mistake{gray,
                "gray has 12 (10 bits + 2 references): likely 2 frames are missing; or try "
                "`bits 8` or `reference mean` or `reference none`"},
        Mistake{{.strategy = "gray", .settings = {{"bits", "9"}, {"reference", "none"}}},
                "gray has 9 (9 bits): 1 too many; leave them out with `order`, or try `bits 10`"},
        Mistake{{.strategy = "xor-gray"},
                "xor-gray has 20 (10 bits + 10 inverses): likely 10 frames are missing; or try "
                "`bits 5` or `reference mean` or `reference none`"},
        Mistake{{.strategy = "gray", .exposures = std::vector{1.0, 4.0}},
                "gray with 2 exposures has 24 (each 10 bits + 2 references): likely 14 frames are "
                "missing; or try `bits 3`"},
        Mistake{{.strategy = "gray", .axes = "both"},
                "gray along both axes has 24 (each 10 bits + 2 references): likely 14 frames are "
                "missing; or try `bits 3`"},
        Mistake{
            {.strategy = "gray", .stripe_pixels = 2, .axes = "both", .projector = Size{640, 480}},
            "gray along both axes has 21: likely 11 frames are missing; or check `strategy`, "
            "`bits`, `reference`"},
        Mistake{{.strategy = "pmp", .motion = 2},
                "pmp has 5 (3 steps + 2 for motion): 5 too many; leave them out with `order`, or "
                "try `steps 8`"},
        Mistake{{.strategy = "gray-phase", .settings = {{"periods", "64"}}},
                "gray-phase has 11 (4 steps + 7 bits): likely a frame is missing; or try `steps 3` "
                "or `no_complementary`"},
        Mistake{{.strategy = "dual-frequency"},
                "dual-frequency has 6 (3 steps + 3 steps): 4 too many; leave them out with "
                "`order`, or try `steps 5` or `low_steps 7`"},
        Mistake{{.strategy = "fast-three-step"}, "or check `strategy`"},
        Mistake{{.strategy = "multi-frequency"},
                "multi-frequency has 9 (3 steps + 3 steps + 3 steps): 1 too many; leave them out "
                "with `order`, or check `strategy`, `steps`, `periods`"},
        Mistake{{.strategy = "micro"},
                "micro has 7 (3 steps + 4 single frames): 3 too many; leave them out with "
                "`order`, or check `strategy`, `periods`"}}) {
    const ScanChanges scan{.sequence = changes};
    expect_error([&] { load_scan(folder(), scan); }, {"10 frames, but ", words});
  }
}

TEST_F(ScanPictures, OfPatternsTakenSeveralTimesAreNamedWithAnOrder) {
  const FrameSet patterns = frames_of(DualFrequency{});
  add(reordered(joined({patterns, patterns, patterns}),
                {0, 6, 12, 1, 7, 13, 2, 8, 14, 3, 9, 15, 4, 10, 16, 5, 11, 17}));
  expect_error([&] { load("dual-frequency"); },
               {"18 frames", "has 6", "12 too many", "each pattern was taken 3 times",
                "`order 0,3,6,9,12,15`"});
  expect_same(load("dual-frequency", "0,3,6,9,12,15").frames, patterns);
}

TEST_F(ScanPictures, OfAPoseOfTheBoardAreToo) {
  const Strategy gray = make_strategy("gray", {{"bits", "10"}, {"reference", "inverse"}});
  add(frames_of(gray));
  add(frames_of(gray, Axis::y));
  add(white_and_black());
  ScanChanges changes{
      .sequence = {.strategy = "gray", .settings = {{"bits", "10"}, {"reference", "inverse"}}}};
  make_folder(folder() / "poses");
  fs::create_directory_symlink(folder(), folder() / "poses" / "pose");
  std::string order;
  expect_error([&] { board_scans(folder() / "poses", changes, Axis::x); },
               {"42 frames", "has 40", "2 too many, likely frames 40 (white), 41 (black)"});
  for (int n = 0; n < 40; ++n) order += fmt::format("{}{}", n == 0 ? "" : ",", n);
  changes.order = order;
  const auto poses = board_scans(folder() / "poses", changes, Axis::x);
  expect_same(poses.front().along(Axis::y).frames, frames_of(gray, Axis::y));
}

TEST_F(ScanPictures, APoseOfTheBoardMayHaveALongerCodeAlongOneAxis) {
  const SequenceChanges patterns{
      .strategy = "gray-phase", .period_pixels = std::vector{18.0}, .projector = Size{1280, 800}};
  const Sequence x = changed(Sequence{}, patterns), y = along(x, Axis::y);
  ASSERT_EQ(frame_count(x), frame_count(y) + 1);
  const FrameSet frames_x = frames_of(x.strategy), frames_y = frames_of(y.strategy, Axis::y);

  // The code comes first.
  for (const FrameSet* const frames : {&frames_x, &frames_y}) {
    std::vector<int> code_first(static_cast<std::size_t>(frames->count()));
    std::iota(code_first.begin(), code_first.end(), 0);
    std::rotate(code_first.begin(), code_first.begin() + x.strategy.layout().code->frames.front(),
                code_first.end());
    add(reordered(*frames, code_first));
  }

  make_folder(folder() / "poses");
  fs::create_directory_symlink(folder(), folder() / "poses" / "pose");
  const auto poses =
      board_scans(folder() / "poses", {.sequence = patterns, .order = "code,sinusoids"}, Axis::x);
  expect_same(poses.front().along(Axis::x).frames, frames_x);
  expect_same(poses.front().along(Axis::y).frames, frames_y);
}

TEST_F(ScanPictures, APoseOfTheBoardMayBeInColour) {
  const Strategy strategy = DualFrequency{};
  for (const Axis axis : {Axis::x, Axis::y}) {
    save_scan(folder() / name_of(axis), frames_of(strategy, axis),
              {.strategy = strategy, .axis = axis, .projector = scanner.projector.size},
              {.in_colour = true});
  }

  const auto poses = board_scans(folder(), {}, Axis::x);
  expect_same(poses.front().along(Axis::x).frames, frames_of(strategy, Axis::x));
  expect_same(poses.front().along(Axis::y).frames, frames_of(strategy, Axis::y));
}

TEST_F(ScanPictures, WrongOrdersAndMissingPicturesAreRefused) {
  add(frames_of(DualFrequency{}));
  for (const char* const order : {"0,1,2,3,4", "0,1,2,3,4,4", "0,1,2,3,4,6"}) {
    expect_error([&] { load("dual-frequency", order); }, {"not an order of its 6 frames"});
  }
  expect_error([&] { load("gray-phase"); }, {"6 frames", "has 10", "missing"});
  add(white_and_black());
  expect_error([&] { load("dual-frequency", "0,1,2,3,4,4"); }, {"list 6 of 0 to 7 once"});
}

}  // namespace slipstream::scan_pictures_test
