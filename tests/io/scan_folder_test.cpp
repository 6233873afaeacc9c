#include "io/scan_folder.h"

#include <string>

#include <gtest/gtest.h>

#include "io/file.h"
#include "io/scan_pictures.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/scan_files.h"
#include "tests/io/expect_error.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::scan_folder_test {

TEST(ScanFolder, ScanFilesComesBackAsItWasWritten) {
  const TemporaryFolder folder;
  const ScanFiles scan{
      .sequence = {.strategy = DualFrequency{.steps = 4, .low_steps = 3, .high = 12, .low = 0.5},
                   .axis = Axis::y,
                   .light = {.alpha_p = 200, .beta_p = 12.5},
                   .projector = {1824, 1140},
                   .marker = true,
                   .exposures = {0.5, 4},
                   .binary = true},
      .bits = 12,
      .frames = {folder.path() / "a.png", folder.path() / "b.png"},
      .scanner = folder.path() / "scanner.yaml",
      .further_cameras = {folder.path() / "second", folder.path() / "third"}};
  write_scan_files(folder.path() / "scan.yaml", scan);

  const ScanFiles read = read_scan_files(folder.path() / "scan.yaml");
  EXPECT_EQ(read.sequence, scan.sequence);
  EXPECT_EQ(read.bits, 12);
  EXPECT_EQ(read.frames, scan.frames);
  EXPECT_EQ(read.scanner, scan.scanner);
  EXPECT_EQ(read.further_cameras, scan.further_cameras);
}

TEST(ScanFolder, ScanFilesHaveOneAxisOrBoth) {
  const TemporaryFolder folder;
  for (const char* const axes : {"x", "y", "both"}) {
    ScanFiles scan{.frames = {folder.path() / "a.png"}};
    set_axes(scan.sequence, axes);
    EXPECT_EQ(axes_of(scan.sequence), axes);
    const std::string text = scan_yaml_of(scan, folder.path());
    EXPECT_EQ(scan_files_from(text, "scan.yaml", folder.path()).sequence, scan.sequence) << text;
  }
  Sequence sequence;
  EXPECT_THROW(set_axes(sequence, "z"), Error);
  const SequenceChanges changes{.strategy = "gray", .stripe_pixels = 2, .axes = "both"};
  const ScanFiles scan{.sequence = default_sequence({640, 480}, changes),
                       .frames = {folder.path() / "a.png"}};
  const std::string text = scan_yaml_of(scan, folder.path());
  EXPECT_EQ(scan_files_from(text, "scan.yaml", folder.path()).sequence, scan.sequence) << text;
}

TEST(ScanFolder, ScanFilesIsAsTheDocumentationHasIt) {
  const TemporaryFolder folder;
  write_file(folder.path() / "scan.yaml",
             "slipstream: 1\n"
             "strategy: {name: dual-frequency, steps: 3, high: 16, low: 1, axis: x}\n"
             "projector: {width: 1824, height: 1140}\n"
             "frames: [frame_0.png, frame_1.png]\n"
             "scanner: scanner.yaml\n");
  const ScanFiles scan = read_scan_files(folder.path() / "scan.yaml");
  EXPECT_EQ(scan.sequence.strategy.settings().at("high"), 16);
  EXPECT_EQ(scan.frames.at(1), folder.path() / "frame_1.png");
}

TEST(ScanFolder, ScanFilesBadOnesAreNamed) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "scan.yaml";
  const std::string good_strategy = "strategy: {name: pmp, steps: 3}\n";
  const auto expect_refused = [&](const std::string& text,
                                  std::initializer_list<std::string> parts) {
    write_file(path, text);
    expect_error([&] { read_scan_files(path); }, parts);
  };
  expect_refused("", {"scan.yaml"});
  expect_refused("a: [", {"scan.yaml", "line"});
  expect_refused(good_strategy + "frames: [a.png]\n", {"scan.yaml", "slipstream", "missing"});
  expect_refused("slipstream: 2\n" + good_strategy + "frames: [a.png]\n", {"slipstream 2"});
  expect_refused("slipstream: 1\n" + good_strategy + "frames: [a.png]\nframe: 3\n",
                 {"scan.yaml", "'frame'", "frames"});
  expect_refused("slipstream: 1\nstrategy: {name: pmp, stesp: 3}\nframes: [a.png]\n",
                 {"scan.yaml", "stesp", "steps"});
  expect_refused("slipstream: 1\nstrategy: {name: pmp, steps: 2}\nframes: [a.png]\n",
                 {"scan.yaml", "2 steps"});
  expect_refused("slipstream: 1\nstrategy: {name: pmp, steps: many}\nframes: [a.png]\n",
                 {"steps", "number"});
  expect_refused("slipstream: 1\nstrategy: {name: pmp, axis: z}\nframes: [a.png]\n",
                 {"axis", "'z'"});
  expect_refused("slipstream: 1\nstrategy: pmp\nframes: [a.png]\n", {"strategy"});
  expect_refused("slipstream: 1\n" + good_strategy + "frames: []\n", {"frames"});
  expect_refused("slipstream: 1\n" + good_strategy + "frames: [a.png]\nbits: 7\n", {"bits 7", "8"});
  expect_refused(
      "slipstream: 1\n" + good_strategy + "frames: [a.png]\nprojector: {width: 0, height: 3}\n",
      {"width 0"});
  const std::string good = "slipstream: 1\n" + good_strategy + "frames: [a.png]\n";
  expect_refused(good + "frames: [b.png]\n", {"scan.yaml", "line 4", "frames is set twice"});
  expect_refused("slipstream: 1\nstrategy:\n  name: pmp\n  steps: 3\n  'steps': 4\n",
                 {"scan.yaml", "line 5", "steps is set twice"});
  expect_refused(good + "---\n" + good, {"scan.yaml", "line 5", "second YAML document"});
  expect_refused(good + "a: &a [1]\nb: {c: *a, d: [{e: 1, f: 2, e: 3}]}\n", {"line 5", "e is"});
  write_file(path, good + "...\n---\n");
  EXPECT_NO_THROW(read_scan_files(path));
}

TEST(ScanFolder, ImagesInFolderAreInTheOrderOfTheirNumbers) {
  const TemporaryFolder folder;
  for (const char* name :
       {"f_10.png", "f_2.png", "f_1.PNG", "notes.txt", "f_02b.png", ".DS_Store", "._f_2.png"}) {
    write_file(folder.path() / name, "x");
  }
  std::string names;
  for (const auto& path : images_in_folder(folder.path())) names += path.filename().string() + " ";
  EXPECT_EQ(names, "f_1.PNG f_2.png f_02b.png f_10.png ");
  expect_error([&] { images_in_folder(folder.path() / "none"); }, {"none"});
  make_folder(folder.path() / "empty");
  expect_error([&] { images_in_folder(folder.path() / "empty"); }, {"empty", "PNG"});
  write_file(folder.path() / "empty" / "._f.png", "x");
  expect_error([&] { images_in_folder(folder.path() / "empty"); }, {"empty", "no pictures"});
  write_file(folder.path() / "empty" / "f_1.JPG", "x");
  EXPECT_EQ(images_in_folder(folder.path() / "empty").size(), 1U);
  write_file(folder.path() / "empty" / "f.png", "x");  // JPEGs beside other pictures are no frames
  EXPECT_EQ(images_in_folder(folder.path() / "empty").front().filename(), "f.png");
}

}  // namespace slipstream::scan_folder_test
