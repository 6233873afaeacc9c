#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "codes/guard_sequence.h"
#include "frames/colour_channels.h"
#include "io/depth_truth.h"
#include "io/image_file.h"
#include "io/scan_folder.h"
#include "slipstream/engine.h"
#include "slipstream/named_scenes.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/recording.h"
#include "slipstream/scan_files.h"
#include "slipstream/scanner_file.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"
#include "tests/io/expect_error.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::saved_scan_test {
namespace fs = std::filesystem;

const Scanner scanner = example_scanner({48, 36});
const Sequence sequence{.strategy = PhaseMeasuring{.steps = 4},
                        .light = {.alpha_p = 200, .beta_p = 30},
                        .projector = scanner.projector.size};

Cloud cloud_of(const Scan& scan) {
  Cloud cloud;
  Engine(setup_for(scan)).cloud(scan.frames, cloud);
  return cloud;
}

VirtualScan some_scan(std::optional<int> bits = 8) {
  return take_scan(scanner, scene_named("sphere", scanner), pattern_set(sequence), {.bits = bits});
}

void expect_same_frames(const FrameSet& a, const FrameSet& b) {
  ASSERT_EQ(a.count(), b.count());
  ASSERT_EQ(a.bits(), b.bits());
  const std::vector<double> whole{1, 10, 100, 1000};
  const Image<double> of_a = weighted_sum(a, whole), of_b = weighted_sum(b, whole);
  for (std::size_t i = 0; i < of_a.pixel_count(); ++i) {
    ASSERT_NEAR(of_a.begin()[i], of_b.begin()[i], 1e-2);
  }
}

TEST(SavedScan, KeepsTheTemperaturesOfTheCamera) {
  const TemporaryFolder folder;
  const Temperatures measured{{"Mainboard", 38}, {"Sensor", 41.5}};
  for (const char* const name : {"scan", "scan.slip"}) {
    const fs::path path = folder.path() / name;
    save_scan(path, some_scan().frames, sequence, {.temperatures = measured});
    EXPECT_EQ(scan_files_in(path).temperatures, measured) << name;
  }

  for (const std::string wrong : {"warm", "{Sensor: .nan}", "{Sensor: .inf}", "{\"\": 41}"}) {
    const std::string file = "{slipstream: 1, strategy: {name: pmp}, temperature: " + wrong + "}";
    expect_error([&] { (void)scan_files_from(file, "scan.yaml", {}); },
                 {"temperature", "Sensor: 41.5"});
  }
}

// Pixel 0 of the binned pictures joins pixels 0 and 1, whose middle is 0.5.
TEST(SavedScan, OfACameraThatJoinsPixelsSinceTheCalibrationHasItsLens) {
  const TemporaryFolder folder;
  Scanner calibrated = scanner;
  calibrated.camera.size = {96, 72};
  calibrated.camera.intrinsic.topRows<2>() *= 2;
  calibrated.camera.intrinsic(0, 2) += 0.5;
  calibrated.camera.intrinsic(1, 2) += 0.5;
  calibrated.camera.residual = {
      .centre = {47.5, 35.5}, .half = {48, 36}, .terms = {{0.1, -0.2}, {0.3, 0.1}, {-0.2, 0.4}}};

  save_scan(folder.path() / "scan", some_scan().frames, sequence);
  const fs::path file = folder.path() / "larger.yaml";
  write_scanner(file, calibrated);

  ScanChanges changes{.scanner = file};
  expect_error([&] { load_scan(folder.path() / "scan", changes); },
               {"96x72", "48x36", "`camera_region 96x72+0+0`"});

  changes.camera_region = Rectangle{0, 0, {96, 72}};
  const Scan read = load_scan(folder.path() / "scan", changes);
  ASSERT_TRUE(read.scanner);
  EXPECT_TRUE(read.scanner->camera.intrinsic.isApprox(scanner.camera.intrinsic, 1e-9));
  EXPECT_EQ(read.scanner->camera.size, scanner.camera.size);

  const Eigen::Vector2d binned = shift_at(read.scanner->camera.residual, {10, 8});
  EXPECT_LT((2 * binned - shift_at(calibrated.camera.residual, {20.5, 16.5})).norm(), 1e-9);
}

// By the light, the green channel would be read.
TEST(SavedScan, HasAGuardOfTheChannelThatIsChosen) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "scan";
  const Sequence guard = guard_sequence(sequence);
  const FrameSet frames =
      take_scan(scanner, scene_named("sphere", scanner), pattern_set(guard), {}).frames;
  ScanFiles files = save_scan(path, some_scan().frames, sequence, {.scanner = scanner});
  save_guard(files, frames, guard);

  int n = 0;
  for (const fs::path& picture : scan_files_in(path / "guard").frames) {
    const std::uint8_t green = n++ % 2 == 0 ? 200 : 40;
    write_image(picture, Image<Colour>(scanner.camera.size, Colour{7, green, 0}));
  }

  const Scan read = load_scan(path, {.channel = GreyChannel::red});
  ASSERT_EQ(read.guard.size(), 1U);
  const Image<double> sum =
      weighted_sum(read.guard.front().frames, std::vector<double>(static_cast<std::size_t>(n), 1));
  EXPECT_NEAR(sum(0, 0), 7 * n, 1e-3);
}

TEST(SavedScan, ComesBackWhole) {
  for (const std::optional<int> bits :
       {std::optional(8), std::optional(12), std::optional<int>()}) {
    const TemporaryFolder folder;
    const FrameSet frames = some_scan(bits).frames;
    save_scan(folder.path() / "scan", frames, sequence, {.scanner = scanner});
    const Scan read = load_scan(folder.path() / "scan");
    EXPECT_EQ(read.sequence, sequence);
    EXPECT_EQ(read.scanner, scanner);
    EXPECT_TRUE(read.further_cameras.empty());
    expect_same_frames(read.frames, frames);
    EXPECT_EQ(point_count(cloud_of(read)),
              point_count(cloud_of({.frames = frames, .sequence = sequence, .scanner = scanner})));
  }
}

/// Records the last two frames of a cycle, then five cycles, without the frame `lost`. The first
/// pixel of each frame is its cycle.
void record_cycles(const fs::path& path, std::optional<int> lost) {
  const FrameSet cycle = some_scan().frames;
  const std::vector<Frame> frames = frames_of(cycle, "cycle");
  RecordingWriter writer(
      path, {.format = frames.front().format(), .sequence = sequence, .scanner = scanner});
  for (int k = 2; k < 24; ++k) {
    if (k == lost) continue;
    Frame frame = frames[static_cast<std::size_t>(k % 4)];
    std::get<Image<std::uint8_t>>(frame.pixels)(0, 0) = static_cast<std::uint8_t>(k / 4);
    frame.stamp.sequence = static_cast<std::uint64_t>(k);
    frame.stamp.pattern_index = k % 4;
    writer.append(frame);
  }
  writer.finish();
}

std::vector<int> cycles_in(const fs::path& path) {
  std::vector<int> cycles;
  const std::uint64_t count = window_count(RecordingReader(path), sequence);
  for (std::uint64_t window = 0; window < count; ++window) {
    const Scan scan = load_scan(path, {.window = window});
    scan.frames.visit([&](const auto& frames) {
      cycles.push_back(static_cast<int>(frames[0](0, 0)));
      for (const auto& frame : frames) EXPECT_EQ(frame(0, 0), cycles.back());
    });
  }
  return cycles;
}

TEST(SavedScan, MayBeAnyWindowOfARecording) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "cycles.slip";
  record_cycles(path, std::nullopt);
  EXPECT_EQ(cycles_in(path), (std::vector{1, 2, 3, 4, 5}));
  expect_error([&] { load_scan(path, {.window = 5}); }, {"cycles.slip", "window 5"});
  record_cycles(path, 10);
  EXPECT_EQ(cycles_in(path), (std::vector{1, 3, 4, 5}));
}

TEST(SavedScan, MayHaveNoScannerButGivesNoCloudThen) {
  const TemporaryFolder folder;
  save_scan(folder.path(), some_scan().frames, sequence);
  const Scan read = load_scan(folder.path());
  EXPECT_FALSE(read.scanner);
  expect_error([&] { (void)cloud_of(read); }, {"scanner"});
}

TEST(SavedScan, IsNotWrittenOfFramesThatWereTakenApart) {
  const TemporaryFolder folder;
  const Sequence read{.strategy = make_strategy("fourier", {}).read_as()};
  expect_error(
      [&] { save_scan(folder.path() / "scan", some_scan().frames, read, {.scanner = scanner}); },
      {"fourier", "as captured"});
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "scan"));
}

TEST(SavedScan, HasTheSecondCamerasScanWithIt) {
  const TemporaryFolder folder;
  const FrameSet frames = some_scan().frames;
  ScanFiles files = save_scan(folder.path(), frames, sequence, {.scanner = scanner});
  save_scan(folder.path() / "second", frames, sequence, {.scanner = scanner});
  files.further_cameras = {folder.path() / "second"};
  write_scan_files(folder.path() / "scan.yaml", files);
  const Scan read = load_scan(folder.path());
  ASSERT_EQ(read.further_cameras.size(), 1U);
  EXPECT_EQ(read.further_cameras[0].scanner, scanner);
  expect_same_frames(read.further_cameras[0].frames, frames);

  const Sequence other{.strategy = PhaseMeasuring{.steps = 4, .frequency = 2}};
  save_scan(folder.path() / "second", frames, other, {.scanner = scanner});
  expect_error([&] { (void)load_scan(folder.path()); }, {"second", "sequence differs"});
}

TEST(SavedScan, InColourIsTheSameFromARecording) {
  const TemporaryFolder folder;
  Scanner known = scanner;
  known.photometry.colour_mixture = usual_mixture;
  for (const Strategy& strategy :
       {Strategy(DualFrequency{.steps = 3, .high = 16}), Strategy(DeBruijn{})}) {
    const Sequence shown{.strategy = strategy, .projector = scanner.projector.size};
    const VirtualScan taken =
        take_colour_scan(scanner, scene_named("statue", scanner), pattern_set(shown), {},
                         {.mixture = usual_mixture, .paint = 0.6});
    for (const FrameSet& white : {FrameSet(), taken.white}) {
      std::vector<Scan> read;
      for (const char* const name : {"scan", "scan.slip"}) {
        const fs::path path = folder.path() / name;
        save_scan(path, taken.frames, shown, {.scanner = known, .in_colour = true, .white = white});
        read.push_back(load_scan(path));
        EXPECT_EQ(read.back().warnings.size(), white.count() == 0 ? 1U : 0U);
        const Scan apart{.frames = unmixed(taken.frames, usual_mixture, white), .sequence = shown};
        expect_same_frames(read.back().frames, merged(apart).frames);
      }
      EXPECT_EQ(read[0].scanner, read[1].scanner);
      EXPECT_EQ(read[0].sequence, read[1].sequence);
      fs::remove_all(folder.path() / "scan");
    }
    // Grey patterns are refused, as for the folder.
    ScanChanges grey;
    grey.sequence.strategy = "pmp";
    grey.sequence.settings = {{"steps", "4"}};
    expect_error([&] { load_scan(folder.path() / "scan.slip", grey); },
                 {"scan.slip", "4 frames", "a multiple of 3"});
  }
}

TEST(SavedScan, IsRefusedWhereItDoesNotFitTogether) {
  const TemporaryFolder folder;
  const FrameSet frames = some_scan().frames;
  const ScanFiles files = save_scan(folder.path(), frames, sequence, {.scanner = scanner});
  ScanFiles fewer = files;
  fewer.frames.pop_back();
  expect_error([&] { (void)load_scan(fewer); }, {folder.path().string(), "3 frames", "has 4"});
  ScanFiles larger = files;
  larger.sequence.projector = {64, 48};
  expect_error([&] { (void)load_scan(larger); }, {"scanner.yaml", "64x48"});
  expect_error([&] { (void)load_scan(folder.path() / "nowhere"); }, {"nowhere"});
}

TEST(SavedScan, IsComparedWithTheTruthBesideIt) {
  const TemporaryFolder folder;
  const VirtualScan scan = some_scan(std::nullopt);
  save_scan(folder.path(), scan.frames, sequence, {.scanner = scanner});
  const Cloud cloud = cloud_of(load_scan(folder.path()));
  EXPECT_FALSE(error_against_truth(folder.path(), cloud));
  fs::create_directory(folder.path() / "truth");
  Image<double> depth = scan.depth;
  for (double& z : depth) z += 0.5;
  write_map(folder.path() / "truth/depth.tiff", depth);
  EXPECT_NEAR(error_against_truth(folder.path(), cloud).value(), 0.5, 1e-3);
  write_map(folder.path() / "truth/depth.tiff", Image<double>({3, 2}, 1));
  expect_error([&] { (void)error_against_truth(folder.path(), cloud); }, {"3x2", "48x36"});
}

TEST(SavedScan, PathNamedByTimeIsNoneThatIsThere) {
  const TemporaryFolder folder;
  const fs::path first = path_named_by_time(folder.path(), "scan", ".slip");
  fs::create_directory(first);
  EXPECT_NE(path_named_by_time(folder.path(), "scan", ".slip"), first);
}

}  // namespace slipstream::saved_scan_test
