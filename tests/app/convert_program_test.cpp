// Runs `slipstream convert` between cloud formats.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/file.h"
#include "io/image_file.h"
#include "slipstream/cloud_file.h"
#include "slipstream/recording.h"
#include "slipstream/scanner_file.h"
#include "tests/app/program.h"
#include "tests/shared_data.h"

namespace slipstream::convert_program_test {
namespace fs = std::filesystem;

class ConvertProgram : public testing::Test {
 protected:
  void SetUp() override {
    run({"record", "--source", "virtual", "--world", "bench", "--camera", "160x120", "--strategy",
         "pmp", "--steps", "4", "--frames", "14", "--rate", "0", "-o", path("scan.slip")});
  }
  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path() / name; }
  static ProgramRun run(const std::vector<std::string>& arguments, int exit_code = 0) {
    ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, exit_code) << run.err;
    return run;
  }

  TemporaryFolder folder_;
};

/// Equal except for the last bit, which conversion to metres and back may change.
bool is_near(float a, float b) {
  return (std::isnan(a) && std::isnan(b)) || std::abs(a - b) <= 2.5e-7F * std::abs(b);
}

void expect_same(const fs::path& path, const fs::path& expected_path) {
  const StoredCloud stored = read_cloud(path), expected = read_cloud(expected_path);
  ASSERT_TRUE(stored.organised && stored.uncertainty && expected.uncertainty);
  ASSERT_EQ(stored.cloud.size(), expected.cloud.size());
  EXPECT_GT(point_count(stored.cloud), 5000U);
  int different = 0;
  for (std::size_t i = 0; i < stored.cloud.z.pixel_count(); ++i) {
    const auto same = [&](const Image<float>& a, const Image<float>& b) {
      return is_near(a.begin()[i], b.begin()[i]);
    };
    different += !same(stored.cloud.x, expected.cloud.x) ||
                 !same(stored.cloud.y, expected.cloud.y) ||
                 !same(stored.cloud.z, expected.cloud.z) ||
                 stored.cloud.intensity.begin()[i] != expected.cloud.intensity.begin()[i] ||
                 !same(stored.uncertainty->coordinate, expected.uncertainty->coordinate) ||
                 !same(stored.uncertainty->x, expected.uncertainty->x) ||
                 !same(stored.uncertainty->z, expected.uncertainty->z);
  }
  EXPECT_EQ(different, 0);
}

TEST_F(ConvertProgram, ARecordingToMcapAndBackToCloudsAsReconstructMakesThem) {
  run({"convert", path("scan.slip"), "-o", path("scan.mcap")});
  run({"convert", path("scan.mcap"), "-o", path("{name}-{window}.pcd")});
  run({"reconstruct", path("scan.slip"), "--windows", ":", "--uncertainty", "-o",
       path("expected-{window}.pcd")});
  for (const std::string window : {"000000", "000001", "000002"}) {
    expect_same(path("scan-" + window + ".pcd"), path("expected-" + window + ".pcd"));
  }
  EXPECT_FALSE(fs::exists(path("scan-000003.pcd")));
  // Several cloud files to one MCAP file and back.
  run({"convert", path("scan-000000.pcd"), path("scan-000002.pcd"), "-o", path("two.mcap")});
  run({"convert", path("two.mcap"), "--topic", "/points", "-o", path("two-{window}.pcd")});
  expect_same(path("two-000001.pcd"), path("expected-000002.pcd"));
}

TEST_F(ConvertProgram, AFolderOfManyFramesIsARecording) {
  const RecordingReader recorded(path("scan.slip"));
  const std::string folder = path("frames"), scanner = path("scanner.yaml");
  fs::create_directory(folder);
  for (std::uint64_t n = 0; n < recorded.count(); ++n) {
    Frame frame;
    ASSERT_TRUE(recorded.read(n, frame));
    write_image(folder + "/" + std::to_string(n) + ".png", std::get<0>(frame.pixels));
  }
  write_scanner(scanner, *recorded.header().scanner);
  const auto with_flags = [&](std::vector<std::string> arguments) {
    for (const char* word : {"--strategy", "pmp", "--steps", "4", "--scanner"}) {
      arguments.emplace_back(word);
    }
    arguments.push_back(scanner);
    return arguments;
  };
  for (const std::string motion : {"0", "2"}) {
    for (const std::string& scan : {folder, path("scan.slip")}) {
      run(with_flags({"reconstruct", scan, "--windows", ":", "--motion", motion, "-o",
                      path("{name}-{window}.ply")}));
    }
    for (const char* window : {"000000", "000001", "000002"}) {
      const std::string of_folder = path(std::string("frames-") + window + ".ply");
      EXPECT_EQ(contents(of_folder), contents(path(std::string("scan-") + window + ".ply")));
      EXPECT_GT(fs::file_size(of_folder), 10000U);
    }
    EXPECT_FALSE(fs::exists(path("frames-000003.ply")));
  }
  EXPECT_NE(run(with_flags({"reconstruct", folder}), 2).err.find("--windows :"), std::string::npos);
  EXPECT_NE(run(with_flags({"reconstruct", folder, "--windows", "3:"}), 2).err.find("3 windows"),
            std::string::npos);

  run(with_flags({"convert", folder, "-o", path("again.slip")}));
  const RecordingReader again(path("again.slip"));
  ASSERT_EQ(again.count(), recorded.count());
  EXPECT_EQ(again.header().sequence, recorded.header().sequence);
  const ProgramRun live =
      run(with_flags({"live", "--source", "replay:" + folder, "--headless", "--json"}));
  const auto told = nlohmann::json::parse(live.out);
  EXPECT_EQ(told["clouds"], 11);
  EXPECT_EQ(told["findings"], nlohmann::json::array());
}

TEST_F(ConvertProgram, AFolderOfARealMovingHandGivesEveryCloud) {
  const fs::path hand = shared_data() / "bsc-hand";
  if (!fs::exists(hand)) GTEST_SKIP() << hand << " is not there";
  std::string scanner =
      "%YAML:1.0\n---\nprojector_width: 1280\nprojector_height: 800\ncamera_width: 640\n"
      "camera_height: 480\n";
  for (const auto& [entry, file] : {std::pair{"camera_projection", "mCamera1Rectified.txt"},
                                    std::pair{"projector_projection", "mProjector.txt"}}) {
    std::ifstream text(hand / file);
    std::vector<std::string> numbers(12);
    for (std::string& number : numbers) text >> number;
    scanner +=
        fmt::format("{}: !!opencv-matrix\n   rows: 3\n   cols: 4\n   dt: d\n   data: [ {} ]\n",
                    entry, fmt::join(numbers, ", "));
  }
  write_file(path("hand.yaml"), scanner);
  const auto with_flags = [&](std::vector<std::string> arguments) {
    for (const char* word : {"--strategy", "pmp", "--steps", "4", "--frequency", "28.5", "--motion",
                             "2", "--nearest", "440", "--farthest", "460", "--json", "--scanner"}) {
      arguments.emplace_back(word);
    }
    arguments.push_back(path("hand.yaml"));
    return arguments;
  };
  const auto clouds = nlohmann::json::parse(
      run(with_flags({"reconstruct", hand / "cam1", "--windows", ":"})).out)["scans"];
  ASSERT_EQ(clouds.size(), 9U);
  for (const auto& cloud : clouds) EXPECT_GT(cloud["points"], 25000);
  const auto live = nlohmann::json::parse(
      run(with_flags({"live", "--source", "replay:" + (hand / "cam1").string(), "--headless"}))
          .out);
  EXPECT_EQ(live["clouds"].get<int>() + live["windows_lost"].get<int>(), 35);
  EXPECT_GE(live["clouds"], 33);
  for (const auto& finding : live["findings"]) EXPECT_FALSE(finding["refused"]) << finding;
}

TEST_F(ConvertProgram, PicturesInColourToARecordingAndBackBitForBit) {
  const std::vector<std::string> pictures{"frame_00.png", "frame_01.png", "white.png"};
  run({"simulate", path("colour"), "--camera", "160x120", "--world", "ideal", "--colour", "--paint",
       "0.5", "--strategy", "dual-frequency", "--steps", "3"});
  run({"convert", path("colour"), "-o", path("colour.slip")});
  run({"convert", path("colour.slip"), "-o", path("again")});
  run({"record", "--source", "replay:" + path("colour.slip"), "-o", path("record.slip")});
  run({"live", "--source", "replay:" + path("record.slip"), "--rate", "0", "--headless", "--record",
       path("live.slip"), "-o", path("live.pcd")});
  run({"capture", "--source", "replay:" + path("live.slip"), "-o", path("captured")});
  const auto check_pictures = [&](const fs::path& folder) {
    for (const std::string& picture : pictures) {
      EXPECT_EQ(read_file(folder / picture), read_file(path("colour/" + picture))) << folder;
    }
  };
  check_pictures(path("again"));
  check_pictures(path("captured"));
  for (const std::string scan : {"colour", "colour.slip", "record.slip", "live.slip", "captured"}) {
    run({"reconstruct", path(scan), "-o", path("cloud.pcd")});
    run({"reconstruct", path("colour"), "-o", path("expected.pcd")});
    EXPECT_EQ(read_file(path("cloud.pcd")), read_file(path("expected.pcd"))) << scan;
  }
  const Cloud live = read_cloud(path("live.pcd")).cloud,
              expected = read_cloud(path("expected.pcd")).cloud;
  EXPECT_GT(point_count(live), 0.9 * static_cast<double>(point_count(expected)));

  const auto expect_refused = [&](const std::vector<std::string>& arguments,
                                  const std::string& named) {
    const ProgramRun refused = run(arguments, 2);
    EXPECT_NE(refused.err.find(named), std::string::npos) << refused.err;
  };
  const std::string recording = path("colour.slip");
  expect_refused({"reconstruct", recording, "--strategy", "fourier", "-o", path("grey.pcd")},
                 "a multiple of 3");
  expect_refused({"live", "--source", "replay:" + recording, "--strategy", "pmp", "--steps", "4",
                  "--headless", "-o", path("grey.pcd")},
                 "a multiple of 3");
  EXPECT_FALSE(fs::exists(path("grey.pcd")));
  expect_refused({"convert", path("colour"), path("colour"), "-o", path("two.slip")},
                 "white picture");
  EXPECT_FALSE(fs::exists(path("two.slip")));
}

TEST_F(ConvertProgram, WhatALiveScanHasPublishedToItsFramesAndThoseToScanFoldersAndBack) {
  const auto reconstruct = [&](const std::string& scan, const std::string& name) {
    run({"reconstruct", path(scan), "--windows", ":", "--uncertainty", "-o",
         path(name + "-{window}.pcd")});
  };
  // Three clouds fit in the queue, so none is dropped even on a busy machine.
  run({"live", "--source", "replay:" + path("scan.slip"), "--motion", "0", "--headless",
       "--publish", "mcap:" + path("live.mcap")});
  run({"convert", path("live.mcap"), "-o", path("live.slip")});
  run({"convert", path("live.mcap"), "-o", path("published-{window}.pcd")});
  EXPECT_EQ(RecordingReader(path("live.slip")).count(), 12U);
  run({"convert", path("live.slip"), "-o", path("folder-{window}")});
  run({"convert", path("folder-000000"), path("folder-000001"), path("folder-000002"), "-o",
       path("joined.slip")});
  reconstruct("scan.slip", "expected");
  reconstruct("live.slip", "live");
  reconstruct("joined.slip", "joined");
  for (const std::string window : {"-000000.pcd", "-000001.pcd", "-000002.pcd"}) {
    for (const std::string name : {"published", "live", "joined"}) {
      expect_same(path(name + window), path("expected" + window));
    }
  }

  // A further input that cannot be read leaves an existing file as it was.
  const auto joined = read_file(path("joined.slip"));
  run({"convert", path("folder-000000"), path("nowhere"), "-o", path("joined.slip")}, 2);
  EXPECT_EQ(read_file(path("joined.slip")), joined);

  EXPECT_NE(run({"convert", path("folder-000000"), "-o", path("a")}, 2).err.find("folder"),
            std::string::npos);
  run({"convert", path("scan.slip"), "-o", path("clouds.mcap")});
  EXPECT_NE(
      run({"convert", path("clouds.mcap"), "-o", path("a.slip")}, 2).err.find("no scan frames"),
      std::string::npos);
  EXPECT_FALSE(fs::exists(path("a.slip")));
}

TEST_F(ConvertProgram, NamesWhatItLeavesOutAndConvertsTheRest) {
  const auto whole = read_file(path("scan.slip"));

  // Not even one frame, and one damaged frame in the second of three cycles.
  write_file(path("begun.slip"), std::span(whole).first(15'000));
  auto damaged = whole;
  damaged[whole.size() * 2 / 5] ^= 1;
  write_file(path("damaged.slip"), std::span(damaged));

  const auto expect_left_out = [&](const std::string& input, const std::string& output,
                                   const std::string& named) {
    const ProgramRun told = run(
        {"convert", path(input), path("scan.slip"), "-o", path(output), "--anyway", "--json"}, 2);
    EXPECT_NE(told.err.find("left out: " + path(input)), std::string::npos) << told.err;
    EXPECT_NE(told.err.find(named), std::string::npos) << told.err;
    EXPECT_EQ(nlohmann::json::parse(told.out)["left_out"].size(), 1U);
  };

  expect_left_out("begun.slip", "begun.mcap", "no complete cycle of 4 frames; it has 0");
  expect_left_out("begun.slip", "{name}-{window}", "no complete cycle");
  expect_left_out("damaged.slip", "damaged.mcap", "window 1");
  expect_left_out("damaged.slip", "joined.slip", "1 damaged frames");
  EXPECT_EQ(RecordingReader(path("joined.slip")).count(), 27U);
}

TEST_F(ConvertProgram, NamesThePartsOfAFolderThatARecordingDoesNotHold) {
  const std::vector<std::string> simulate{"simulate", "--camera", "80x60", path("folder")};
  for (const std::string flag : {"--guard", "--second-camera"}) {
    fs::remove_all(path("folder"));
    std::vector<std::string> with_part = simulate;
    with_part.push_back(flag);
    run(with_part);
    const std::string said = run({"convert", path("folder"), "-o", path("one.slip")}).err;
    EXPECT_NE(said.find(flag == "--guard" ? "no guard" : "one camera"), std::string::npos) << said;
  }
}

TEST_F(ConvertProgram, RefusesInOneLineAndLeavesNothingHalfDone) {
  run({"convert", path("scan.slip"), "-o", path("scan.mcap")});
  const auto refused = [&](const std::vector<std::string>& arguments, const std::string& why) {
    std::vector<std::string> all{"convert"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    const ProgramRun refusal = run(all, 2);
    EXPECT_NE(refusal.err.find(why), std::string::npos) << refusal.err;
  };
  refused({path("scan.mcap"), path("scan.mcap"), "-o", path("one.ply")}, "two clouds");
  EXPECT_FALSE(fs::exists(path("one.ply")));
  refused({path("scan.mcap"), "-o", path("scan.mcap")}, "overwritten");
  refused({path("scan.mcap"), "-o", path("a.las")}, "ending");
  refused({path("scan.mcap"), "-o", path("a.stl")}, "--mesh " + path("a.stl"));
  refused({path("scan.mcap"), "--topic", "/image", "-o", path("a.ply")}, "/image (no cloud)");
  write_file(path("other.mcap"), std::string_view("no such file"));
  refused({path("other.mcap"), "-o", path("a.mcap")}, "not an MCAP file");
  EXPECT_FALSE(fs::exists(path("a.mcap")));

  const auto bytes = read_file(path("scan.mcap"));
  write_file(path("cut.mcap"), std::span(bytes).first(bytes.size() - 20));
  EXPECT_EQ(run({"convert", path("cut.mcap"), "-o", path("cut-{window}.ply")}).err, "")
      << "the footer is cut, not the end of the data";
  write_file(path("cut.mcap"), std::span(bytes).first(bytes.size() / 2));
  refused({path("cut.mcap"), "-o", path("b-{window}.ply")}, "truncated");
  auto damaged = bytes;
  damaged[bytes.size() / 2] ^= 1;
  write_file(path("damaged.mcap"), std::span(damaged));
  refused({path("damaged.mcap"), "-o", path("b-{window}.ply")}, "damaged");
  EXPECT_FALSE(fs::exists(path("b-000000.ply")));
}

}  // namespace slipstream::convert_program_test
