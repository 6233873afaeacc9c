// Small text files that people edit: as editors of other systems save them.
#include <filesystem>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "io/file.h"
#include "slipstream/scanner_file.h"
#include "tests/app/program.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::text_files_program_test {
namespace fs = std::filesystem;

/// A file, and a command that reads it; % is the folder of all files.
struct TextReader {
  std::string file;
  std::string text;  ///< empty: already there
  std::vector<std::string> command;
  std::string told;  ///< by the command if it has read the whole file
};

void PrintTo(const TextReader& reader, std::ostream* stream) {
  *stream << reader.file;
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  for (std::size_t at = 0; (at = text.find(what, at)) != text.npos; at += by.size()) {
    text.replace(at, what.size(), by);
  }
  return text;
}

class TextFilesProgram : public testing::TestWithParam<TextReader> {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<TemporaryFolder>();
    copy_simulated_scan({"--camera", "96x72"}, path("scan"));
    ASSERT_EQ(run_program({"calibrate", "virtual-robot", path("robot")}).exit_code, 0);
    ASSERT_EQ(run_program({"reconstruct", path("scan"), "-o", path("a.pcd")}).exit_code, 0);
    fs::copy(path("a.pcd"), path("b.pcd"));

    const Scanner scanner = read_scanner(path("scan/scanner.yaml"));
    write_scanner(path("scanner.xml"), scanner);
    for (const char* name : {"matrices", "batch"}) make_folder(path(name));
    const Eigen::IOFormat exact(Eigen::FullPrecision, Eigen::DontAlignCols);
    for (const auto& [name, matrix] : std::vector<std::pair<std::string, Eigen::MatrixXd>>{
             {"camera_matrix", scanner.camera.intrinsic},
             {"projector_matrix", scanner.projector.intrinsic},
             {"R", scanner.rotation},
             {"T", scanner.translation}}) {
      std::ostringstream text;
      text << matrix.format(exact) << '\n';
      write_file(path("matrices/" + name + ".txt"), text.str());
    }
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static std::string path(const std::string& name) { return folder_->path() / name; }

  /// What the command says if the file has this text.
  static std::string said(const std::string& text) {
    write_file(path(GetParam().file), text);
    std::vector<std::string> words;
    for (const std::string& word : GetParam().command) {
      words.push_back(replaced(word, "%", folder_->path()));
    }
    const ProgramRun run = run_program(words);
    return run.out + run.err;
  }

  static inline std::unique_ptr<TemporaryFolder> folder_;
};

TEST_P(TextFilesProgram, MayHaveAByteOrderMarkAndLinesEndingInCrLf) {
  const std::string text =
      GetParam().text.empty() ? read_text(path(GetParam().file)) : GetParam().text;
  ASSERT_GT(text.find('\n'), 0U);
  const std::string plain = said(text), lines = replaced(text, "\n", "\r\n");
  EXPECT_NE(plain.find(GetParam().told), std::string::npos) << plain;

  for (const std::string& other : {"\xEF\xBB\xBF" + text, lines, "\xEF\xBB\xBF" + lines}) {
    EXPECT_EQ(said(other), plain);
  }
  write_file(path(GetParam().file), text);
}

const std::vector<std::string> check_scan{"check", "%/scan"};

INSTANTIATE_TEST_SUITE_P(
    Of, TextFilesProgram,
    testing::Values(
        TextReader{"pairs.csv",
                   "0,0,0,1,2,3\n100,0,0,101,2,3\n0,100,0,1,102,3\n0,0,100,1,2,103\n",
                   {"frame", "points", "--pairs", "%/pairs.csv"},
                   "4 points"},
        TextReader{"pose.yaml",
                   "from: camera\nto: base\nunit: mm\ntranslation: [1, 2, 3]\nrotation_vector: [0, "
                   "0, 1]\n",
                   {"frame", "convert", "%/pose.yaml"},
                   "to: base"},
        TextReader{"points.csv",
                   "pose,board_x,board_y,camera_u,camera_v,projector_u,projector_v\n"
                   "a,0,0,1,2,3,4\na,1,0,1,2,3,4\na,0,1,1,2,3\n",
                   {"calibrate", "points", "%/points.csv", "--camera", "9x9", "--projector", "9x9",
                    "-o", "%/new.yaml"},
                   "line 4"},
        TextReader{"scan/scan.yaml", "", check_scan, "no problems"},
        TextReader{"scan/scanner.yaml", "", check_scan, "baseline"},
        TextReader{
            "scanner.xml", "", {"check", "%/scan", "--scanner", "%/scanner.xml"}, "baseline"},
        TextReader{
            "matrices/R.txt", "", {"check", "%/scan", "--scanner", "%/matrices"}, "baseline"},
        TextReader{"robot/robot.csv",
                   "",
                   {"calibrate", "hand-eye", "%/robot/robot.csv", "%/robot/boards.csv", "--eye",
                    "in-hand", "-o", "%/camera.yaml"},
                   "camera.yaml"},
        TextReader{"robot/boards.csv",
                   "",
                   {"calibrate", "hand-eye", "%/robot/robot.csv", "%/robot/boards.csv", "--eye",
                    "in-hand", "-o", "%/camera.yaml"},
                   "camera.yaml"},
        TextReader{"poses.yaml",
                   "- {x: 1, y: 2, z: 3, rx: 0, ry: 0, rz: 0}\n- {x: 1}\n",
                   {"calibrate", "hand-eye", "%/poses.yaml", "%/robot/boards.csv", "--eye",
                    "in-hand", "-o", "%/camera.yaml"},
                   "line 2"},
        TextReader{"start.txt",
                   "a.pcd 0 0 0 0 0 0 1\nb.pcd 1 2\n",
                   {"merge", "%/a.pcd", "%/b.pcd", "--start", "%/start.txt", "-o", "%/c.ply"},
                   "line 2"},
        TextReader{"artefacts.yaml",
                   "spheres: [a.pcd]\nplane: 3\n",
                   {"verify", "%/artefacts.yaml", "-o", "%/report"},
                   "line 2"},
        TextReader{"rig.yaml",
                   "minimum-modulation: 20\nstratgy: pmp\n",
                   {"check", "%/scan", "--rig", "%/rig.yaml"},
                   "line 2"},
        TextReader{"batch/batch.json",
                   "{\n\"version\": \"0\"\n}\n",
                   {"batch", "run", "%/batch", "--shard", "1/1"},
                   "planned by version"},
        TextReader{"list.txt", "scan\n\nscan\tall\n", {"reconstruct", "%/list.txt"}, "line 3"}),
    [](const auto& info) { return replaced(replaced(info.param.file, "/", "_"), ".", "_"); });

}  // namespace slipstream::text_files_program_test
