// Batches and farms: lists, manifests, --resume, shards.
#include <algorithm>
#include <map>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <signal.h>

#include "app/manifest.h"
#include "io/file.h"
#include "slipstream/error.h"
#include "tests/app/program.h"
#include "tests/io/expect_error.h"

namespace slipstream::batch_program_test {
namespace fs = std::filesystem;

/// A recording with 200 windows of a tiny camera, and a list of it and two scan folders.
class BatchProgram : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(run({"record", "--source", "virtual", "--camera", "96x72", "--strategy", "pmp",
                   "--steps", "3", "--frames", "600", "--rate", "0", "-o", path("a.slip")}),
              0);
    for (const char* name : {"x", "y"}) {
      copy_simulated_scan({"--camera", "96x72", "--strategy", "pmp"}, path(name));
    }
    write_file(path("list.txt"), "a.slip\t:\nx\n\ny\n");
    for (const char* name : {"one", "many"}) make_folder(path(name));
  }

  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path() / name; }

  int run(const std::vector<std::string>& arguments) {
    last_ = run_program(arguments);
    return last_.exit_code;
  }

  /// Arguments to reconstruct the list.
  [[nodiscard]] std::vector<std::string> listed(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"reconstruct", path("list.txt"), "-o",
                                       output("one"), "--manifest",     path("one.jsonl")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  [[nodiscard]] std::string output(const std::string& folder) const {
    return path(folder) + "/{name}-{window}.ply";
  }
  int plan(const std::string& tasks) {
    return run({"batch", "plan", path("list.txt"), "--tasks", tasks, "--plan", path("plan"), "-o",
                output("many")});
  }
  int shard(const std::string& shard) {
    return run({"batch", "run", path("plan"), "--shard", shard});
  }

  [[nodiscard]] std::vector<std::string> lines(const std::string& file) const {
    std::istringstream text(contents(path(file)));
    std::vector<std::string> all;
    for (std::string line; std::getline(text, line);) all.push_back(line);
    return all;
  }
  /// Contents of a folder's files, by name.
  [[nodiscard]] std::map<std::string, std::string> files(const std::string& folder) const {
    std::map<std::string, std::string> all;
    for (const auto& file : fs::directory_iterator(path(folder))) {
      if (file.path().extension() == ".part") continue;  // half-written when killed by SIGKILL
      all[file.path().filename()] = contents(file.path());
    }
    return all;
  }
  void expect_words(const std::string& words) const {
    EXPECT_NE((last_.out + last_.err).find(words), std::string::npos) << last_.out << last_.err;
  }

  TemporaryFolder folder_;
  ProgramRun last_;
};

TEST_F(BatchProgram, AManifestSaysWhatWasDoneAndIsResumed) {
  ASSERT_EQ(run(listed()), 0) << last_.err;
  EXPECT_EQ(lines("one.jsonl").size(), 202U);
  const auto entry = nlohmann::json::parse(lines("one.jsonl").back());
  EXPECT_EQ(entry["scan"], path("y"));
  EXPECT_EQ(entry["outputs"][0]["bytes"],
            fs::file_size(entry["outputs"][0]["path"].get<std::string>()));
  EXPECT_GT(entry["counts"]["valid"], 1000);
  EXPECT_EQ(run(listed()), 2);
  expect_words("use --resume");
  const auto before = files("one");
  EXPECT_EQ(run(listed({"--resume"})), 0);
  expect_words("202 of 202 scans were already done");

  // Redone: a missing output, one with the right size but wrong bytes, a changed input.
  fs::remove(path("one/a-000007.ply"));
  std::string damaged = contents(path("one/a-000100.ply"));
  damaged.back() = static_cast<char>(damaged.back() + 1);
  write_file(path("one/a-000100.ply"), damaged);
  fs::copy(path("x/frame_00.png"), path("x/frame_01.png"), fs::copy_options::overwrite_existing);
  EXPECT_NE(run(listed({"--resume"})), 1);
  EXPECT_EQ(lines("one.jsonl").size(), 205U);
  EXPECT_TRUE(files("one")["a-000007.ply"] == before.at("a-000007.ply"));
  EXPECT_TRUE(files("one")["a-000100.ply"] == before.at("a-000100.ply"));
  write_file(path("list.txt"), "a.slip\t3:5\n");
  EXPECT_EQ(run(listed({"--resume", "--subsample", "2", "--json"})), 0);
  EXPECT_EQ(nlohmann::json::parse(last_.out)["done_before"], 0) << "other settings";
}

TEST_F(BatchProgram, AFailedScanIsToldAndTriedAgain) {
  fs::rename(path("x/frame_01.png"), path("kept.png"));
  EXPECT_EQ(run(listed()), 2);
  EXPECT_NE(nlohmann::json::parse(lines("one.jsonl")[200])["error"].get<std::string>().find("x"),
            std::string::npos);
  fs::rename(path("kept.png"), path("x/frame_01.png"));
  EXPECT_EQ(run(listed({"--resume"})), 0);
  expect_words("201 of 202");
  EXPECT_EQ(lines("one.jsonl").size(), 203U) << "the last of a scan holds";
}

TEST_F(BatchProgram, AFileThatTheDiskDoesNotGiveEndsNoOtherScan) {
  fs::create_symlink("/proc/self/mem", path("bad.slip"));  // offset 0 is unreadable
  std::vector<std::string> scans{"reconstruct", "-o", path("one/{name}.ply"), path("bad.slip")};
  EXPECT_EQ(run(scans), 1) << "the only one";
  scans.insert(scans.end(), {path("x"), path("y")});
  EXPECT_EQ(run(scans), 2);
  expect_words("cannot read " + path("bad.slip"));
  EXPECT_EQ(files("one").size(), 2U);
}

TEST_F(BatchProgram, WindowsAreThoseOfEachAlone) {
  ASSERT_EQ(run({"reconstruct", path("a.slip"), "--windows", "10:60", "--every", "7", "-o",
                 output("many")}),
            0);
  for (int window = 10; window < 60; window += 7) {
    ASSERT_EQ(run({"reconstruct", path("a.slip"), "--windows",
                   std::to_string(window) + ":" + std::to_string(window + 1), "-o", output("one")}),
              0);
  }
  EXPECT_EQ(files("one").size(), 8U);
  EXPECT_TRUE(files("one") == files("many"));
}

TEST_F(BatchProgram, ALongRunHasTheMemoryOfAShortOne) {
  const auto memory_of = [&](const std::string& windows) {
    RunningProgram program(
        {"reconstruct", path("a.slip"), "--windows", windows, "-o", output("many")});
    EXPECT_EQ(program.wait(), 0);
    return static_cast<double>(program.memory());
  };
  // How many scans are held at once depends on the moment.
  const double of_short = std::max({memory_of(":20"), memory_of(":20"), memory_of(":20")});
  EXPECT_LT(std::min(memory_of(":"), memory_of(":")), 1.1 * of_short);
}

TEST_F(BatchProgram, AKilledRunIsResumedWithOneLineAScan) {
  {
    RunningProgram program(listed());
    ASSERT_TRUE(wait_until([&] { return lines("one.jsonl").size() > 20; }));
    program.send(SIGKILL);
    EXPECT_NE(program.wait(), 2);
  }
  const std::size_t done = lines("one.jsonl").size();
  write_file(path("one.jsonl"), contents(path("one.jsonl")) + "{\"scan\": \"torn");
  EXPECT_EQ(run(listed({"--resume"})), 0);
  expect_words(std::to_string(done) + " of 202 scans were already done");
  EXPECT_EQ(lines("one.jsonl").size(), 202U);
  EXPECT_EQ(contents(path("one.jsonl")).find("torn"), std::string::npos);
  const auto resumed = files("one");
  fs::remove_all(path("one"));
  make_folder(path("one"));
  fs::remove(path("one.jsonl"));
  EXPECT_EQ(run(listed()), 0);
  EXPECT_TRUE(files("one") == resumed);
}

TEST_F(BatchProgram, ASecondRunWaitsForTheFirstAndFindsAllDone) {
  RunningProgram first(listed());
  ASSERT_TRUE(wait_until([&] { return fs::exists(path("one.jsonl")); }));
  EXPECT_EQ(run(listed({"--resume"})), 0);
  EXPECT_EQ(first.wait(), 0);
  EXPECT_EQ(lines("one.jsonl").size(), 202U);
}

TEST_F(BatchProgram, ShardsAreOneRunAndMergeSaysWhatLacks) {
  ASSERT_EQ(run(listed()), 0);
  ASSERT_EQ(plan("8"), 0) << last_.err;
  EXPECT_EQ(plan("8"), 2);
  expect_words("already holds a batch");
  for (const char* one : {"1/8", "2", "3/8", "4/8", "5/8", "6/8", "8/8"}) EXPECT_EQ(shard(one), 0);
  EXPECT_EQ(run({"batch", "merge", path("plan"), "--json"}), 2);
  const auto merged = nlohmann::json::parse(last_.out);
  const std::int64_t missing = std::count(last_.err.begin(), last_.err.end(), '\n') - 1;
  EXPECT_EQ(merged["whole"], 202 - missing);
  EXPECT_GT(missing, 20);
  expect_words("not done yet");
  EXPECT_EQ(shard("7/8"), 0);
  EXPECT_EQ(shard("7/8"), 0);
  expect_words("scans were already done");
  EXPECT_EQ(run({"batch", "merge", path("plan")}), 0) << last_.err;
  expect_words("202 of 202 scans complete");
  EXPECT_EQ(lines("plan/manifest.jsonl").size(), 202U);
  EXPECT_TRUE(files("many") == files("one"));
  fs::resize_file(path("many/a-000031.ply"), 100);
  EXPECT_EQ(run({"batch", "merge", path("plan")}), 2);
  expect_words("window 31: its outputs were changed since");
}

TEST_F(BatchProgram, PlansWithoutOpeningWhatAListSaysAll) {
  std::string list;
  for (int i = 0; i < 20000; ++i) {
    list += "day" + std::to_string(i) + "\t\t" + std::to_string(1000 + i % 7) + "\n";
  }
  write_file(path("list.txt"), list);
  ASSERT_EQ(plan("1000"), 0) << last_.err;
  EXPECT_EQ(lines("plan/scans.txt").size(), 20000U);
  EXPECT_EQ(lines("plan/scans.txt").back(), path("day19999") + "\t\t1000\t1000");
}

TEST_F(BatchProgram, WhatCannotBePlannedIsOneLine) {
  const auto expect_refused = [&](const std::string& list, const std::string& words) {
    write_file(path("list.txt"), list);
    EXPECT_EQ(plan("2"), 2);
    EXPECT_EQ(std::count(last_.err.begin(), last_.err.end(), '\n'), 1) << last_.err;
    expect_words(words);
    EXPECT_FALSE(fs::exists(path("plan")));
  };
  expect_refused("", "no scans listed");
  expect_refused("a.slip\t5:5\n", "list.txt: line 1: '5:5': expected a range");
  expect_refused("x\ny\tfirst\n", "line 2: 'first': expected a range");
  expect_refused("x\t\tmuch\n", "line 1: expected PATH");
  expect_refused("a.slip\t200:\n", "200 windows; none in the range 200:");
  expect_refused("x\t3:\n", "1 windows; none in the range 3:");
  expect_refused("x\nx\n", "two scans would be written to this file");
  expect_refused("a.slip\t0:9\na.slip\t8:12\n", "window 8");
  write_file(path("list.txt"), "x\n");
  EXPECT_EQ(run({"batch", "plan", path("x"), "--tasks", "2", "--plan", path("plan"), "-o",
                 output("many"), "--subsample", "3"}),
            2);
  expect_words("--subsample 3");
  EXPECT_EQ(run({"batch", "plan", path("x"), "--tasks", "1", "--plan", path("plan"), "-o", "-"}),
            2);
  expect_words("-o -: a batch writes files");
  EXPECT_EQ(plan("0"), 2);
  expect_words("--tasks 0 is out of range");
  ASSERT_EQ(plan("2"), 0);
  for (const char* none : {"0/2", "3/2", "1/3", "one", ""}) {
    EXPECT_EQ(shard(none), 2) << none;
    expect_words("is not in this batch");
  }
  write_file(path("plan/batch.json"), "{\"version\": \"0\", \"tasks\": 2}");
  EXPECT_EQ(shard("1/2"), 2);
  expect_words("plan again");
  write_file(path("plan/batch.json"), "nonsense");
  EXPECT_EQ(run({"batch", "merge", path("plan")}), 2);
  expect_words("not a plan");
  write_file(path("one.jsonl"), "my notes");
  EXPECT_EQ(run(listed({"--resume"})), 2);
  expect_words("not a manifest");
  EXPECT_EQ(contents(path("one.jsonl")), "my notes");
}

TEST_F(BatchProgram, AScanThatIsGoneEndsNoPlan) {
  write_file(path("list.txt"), "x\ngone\ny\n");
  EXPECT_EQ(plan("1"), 0);
  expect_words("gone: no such folder or file");
  EXPECT_EQ(shard("1"), 2);
  EXPECT_EQ(run({"batch", "merge", path("plan")}), 2);
  expect_words("2 of 3 scans complete");
}

TEST(BatchProgramManifest, TornAtAnyByteItIsItsWholeLines) {
  std::string text;
  for (std::uint64_t window = 0; window < 4; ++window) {
    auto entry = app::entry_for({"a \"b\"\n.slip", window}, {"--gamma=none"});
    entry["outputs"] = nlohmann::json::array();
    text += app::line_of(entry);
  }
  for (std::size_t size = 0; size <= text.size(); ++size) {
    const std::string torn = text.substr(0, size);
    const app::Manifest manifest = app::manifest_from(torn, "torn");
    EXPECT_EQ(manifest.lines, std::count(torn.begin(), torn.end(), '\n'));
    EXPECT_EQ(manifest.entries.size(), manifest.lines);
    EXPECT_EQ(manifest.whole_bytes, torn.rfind('\n') + 1);
    // Lines torn mid-file, by writers without locks, are skipped too.
    if (size > 1) EXPECT_GE(app::manifest_from(torn + "\n" + text, "torn").entries.size(), 3U);
  }
  expect_error([] { (void)app::manifest_from("ply\nformat\n", "cloud.ply"); },
               {"cloud.ply", "not a manifest"});
}

}  // namespace slipstream::batch_program_test
