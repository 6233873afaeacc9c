// Every command gives the same result for a recording and a scan folder of the same frames.
#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/app/program.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::interchange_program_test {
namespace fs = std::filesystem;

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  for (std::size_t at = text.find(what); at != std::string::npos;
       at = text.find(what, at + by.size())) {
    text.replace(at, what.size(), by);
  }
  return text;
}

/// Removes fields that differ from run to run.
void drop_times(nlohmann::json& document) {
  if (document.is_object()) {
    for (const char* key : {"seconds", "latency_ms", "screen_latency_ms", "stages",
                            "clouds_per_second", "frames_per_second"}) {
      document.erase(key);
    }
  }
  if (!document.is_structured()) return;
  for (nlohmann::json& part : document) drop_times(part);
}

/// The JSON document and output file of one run.
struct Given {
  std::string document, file;
};

class InterchangeProgram : public testing::TestWithParam<std::vector<std::string>> {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<TemporaryFolder>();
    for (const std::string name : {"scan", "scan.slip", "other", "other.slip"}) {
      const std::string seed = name.starts_with("scan") ? "1" : "2";
      const ProgramRun run =
          run_program({"simulate", path(name), "--camera", "160x120", "--strategy", "pmp",
                       "--steps", "6", "--scene", "board", "--virtual-noise", "1", "--alpha-p",
                       "200", "--beta-p", "30", "--seed", seed});
      ASSERT_EQ(run.exit_code, 0) << run.err;
    }
    fs::remove_all(path("scan/truth"));  // recordings do not store it
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static std::string path(const std::string& name) { return folder_->path() / name; }

  /// In the arguments, IN is the scan, OTHER another scan of the same kind and scene, and OUT the
  /// output file.
  static Given given(std::vector<std::string> arguments, const std::string& in) {
    const std::string out = path("out"),
                      other = path(in.ends_with(".slip") ? "other.slip" : "other");
    for (std::string& argument : arguments) {
      argument = replaced(replaced(replaced(argument, "IN", in), "OUT", out), "OTHER", other);
    }
    arguments.emplace_back("--json");
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    nlohmann::json document =
        nlohmann::json::parse(replaced(replaced(run.out, in, "INPUT"), out, "OUTPUT"));
    drop_times(document);
    Given given{document.dump(1), {}};
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_->path())) {
      if (!entry.path().filename().string().starts_with("out")) continue;
      given.file = contents(entry.path());
      fs::remove(entry.path());
      break;
    }
    return given;
  }

  static inline std::unique_ptr<TemporaryFolder> folder_;
};

TEST_P(InterchangeProgram, GivesTheSame) {
  const Given of_folder = given(GetParam(), path("scan")),
              of_recording = given(GetParam(), path("scan.slip"));
  EXPECT_EQ(of_folder.document, of_recording.document);
  const bool has_times = of_folder.file.starts_with("SLIPFRMS");  // of the recording run
  EXPECT_TRUE(has_times || of_folder.file == of_recording.file);
  const bool writes = std::any_of(GetParam().begin(), GetParam().end(),
                                  [](const auto& word) { return word.starts_with("OUT"); });
  EXPECT_EQ(of_folder.file.empty(), !writes);
}

INSTANTIATE_TEST_SUITE_P(
    Commands, InterchangeProgram,
    testing::ValuesIn(std::vector<std::vector<std::string>>{
        {"check", "IN"},
        {"check", "IN", "--order", "0,1,2,3,4,5"},
        {"reconstruct", "IN", "-o", "OUT.ply"},
        {"reconstruct", "IN", "--gamma", "blind", "--depth", "OUT.tiff"},
        {"calibrate", "gamma", "IN", "-o", "OUT.yaml"},
        {"calibrate", "noise", "IN", "OTHER", "-o", "OUT.yaml"},
        {"calibrate", "ambient", "IN", "-o", "OUT.yaml"},
        {"view", "IN", "--snapshot", "OUT.png", "--size", "200x150"},
        {"live", "--source", "replay:IN", "--rate", "0", "--headless", "-o", "OUT.ply"},
        {"live", "--source", "replay:IN", "--rate", "0", "--headless", "--loop", "--frames", "40"},
        {"record", "--source", "replay:IN", "--rate", "0", "-o", "OUT.slip"},
    }));

}  // namespace slipstream::interchange_program_test
