// Settings and calibrations: YAML and XML. Lists and manifests.
#include "app/batch_plan.h"
#include "app/manifest.h"
#include "io/file.h"
#include "io/pose_table_file.h"
#include "io/result_files.h"
#include "io/rig_file.h"
#include "io/scan_folder.h"
#include "simulate/accuracy.h"
#include "slipstream/scan_files.h"
#include "slipstream/scanner.h"
#include "slipstream/scanner_file.h"
#include "tests/every_strategy.h"
#include "tests/fuzz/target.h"

namespace slipstream {
namespace {
namespace fs = std::filesystem;

/// Bytes that yaml-cpp and what follows allocate at most for one of a text.
constexpr std::uint64_t bytes_of_yaml = 20'000;

std::string matrix(const std::string& name, int rows, int columns, const std::string& data) {
  return name + ": !!opencv-matrix\n   rows: " + std::to_string(rows) +
         "\n   cols: " + std::to_string(columns) + "\n   dt: d\n   data: [ " + data + " ]\n";
}

std::vector<Bytes> scanner_files() {
  const std::string head = "%YAML:1.0\n---\n", lens = "900., 0., 320., 0., 901., 240., 0., 0., 1.",
                    bent = "0.1, 0., 0., 0., 0.", turn = "1., 0., 0., 0., 1., 0., 0., 0., 1.";
  Scanner scanner;
  scanner.camera.size = {640, 480};
  scanner.projector.size = {1024, 768};
  scanner.translation = {100, 0, 0};
  scanner.calibrated_depths = {400, 900};
  scanner.measured = "in the cellar";
  return {bytes_of(text_of(scanner)),
          written_file("scanner.xml", [&](const fs::path& path) { write_scanner(path, scanner); }),
          bytes_of(head + matrix("M1", 3, 3, lens) + matrix("D1", 1, 5, bent) +
                   matrix("S", 2, 1, "640., 480.") + matrix("M4", 3, 3, lens) +
                   matrix("Rlp", 3, 3, turn) + matrix("Tlp", 3, 1, "-108., 2., 3.")),
          bytes_of(head + matrix("cam_K", 3, 3, lens) + matrix("cam_kc", 1, 5, bent) +
                   matrix("proj_K", 3, 3, lens) + matrix("proj_kc", 1, 5, bent) +
                   matrix("R", 3, 3, turn) + matrix("T", 3, 1, "100., 2., 3.")),
          bytes_of(head + "frameWidth: 640\nframeHeight: 480\nscreenResX: 800\nscreenResY: 600\n" +
                   matrix("Kc", 3, 3, lens) + matrix("kc", 1, 5, bent) + matrix("Kp", 3, 3, lens) +
                   matrix("kp", 1, 5, bent) + matrix("Rp", 3, 3, turn) +
                   matrix("Tp", 3, 1, "100., 2., 3.")),
          bytes_of(head + "camera_width: 640\ncamera_height: 480\n" +
                   matrix("camera_projection", 3, 4,
                          "900., 0., 320., 0., 0., 901., 240., 0., 0., 0., 1., 0.") +
                   matrix("projector_projection", 3, 4,
                          "-9., 0.1, -4., 900., 0., -9., -3., 2., 0., 0., -0.01, 0.1"))};
}

const bool scanner_known = add_fuzz_target(
    {"scanner", scanner_files,
     [](std::span<const std::uint8_t> input) {
       const Scanner read = scanner_from(text_of_bytes(input), "input");
       const auto unless_said = [](Size said, Size size) { return said == Size{} ? size : said; };
       const Scanner scanner = completed(read, "input", unless_said(read.camera.size, {640, 480}),
                                         unless_said(read.projector.size, {1920, 1080}));
       // What is accepted can be written, and read again as it was but for words on one line.
       Scanner again = completed(scanner_from(text_of(scanner), "again"), "again", {}, {});
       again.measured = scanner.measured;
       if (!(again == scanner)) {
         throw std::logic_error("a scanner that is written reads as another");
       }
     }},
    bytes_of_yaml);

std::vector<Bytes> calibrations_of_light() {
  const std::array values{0.0, 0.25, 0.5, 0.75, 1.0}, light{0.0, 0.1, 0.3, 0.6, 1.0};
  std::vector<Bytes> seeds;
  for (const std::string ending : {".yaml", ".xml"}) {
    seeds.push_back(written_file("light" + ending, [&](const fs::path& path) {
      write_photometric_calibration(
          std::nullopt, path,
          {.ambient = -7,
           .noise_variance = 1.55,
           .noise_gain = 0.01,
           .response = MeasuredResponse{.response = response_curve(values, light), .gamma = 2}});
    }));
  }
  return seeds;
}

const bool photometry_known = add_fuzz_target({"photometry", calibrations_of_light,
                                               [](std::span<const std::uint8_t> input) {
                                                 const fs::path file = file_of(input, "light.yaml");
                                                 (void)read_photometric_calibration(file);
                                                 (void)response_named(file.string(), "--gamma");
                                               }},
                                              bytes_of_yaml);

std::vector<Bytes> scan_yamls() {
  std::vector<Bytes> seeds;
  for (const Strategy& strategy : every_strategy()) {
    ScanFiles scan{.sequence = {.strategy = strategy, .projector = {1824, 1140}},
                   .frames = {"a.png", "b.png"}};
    scan.bits = static_cast<int>(8 + seeds.size() % 2 * 4);
    scan.sequence.axis = seeds.size() % 3 == 0 ? Axis::y : Axis::x;
    seeds.push_back(bytes_of(scan_yaml_of(scan, ".")));
  }
  return seeds;
}

const bool scan_known =
    add_fuzz_target({"scan.yaml", scan_yamls,
                     [](std::span<const std::uint8_t> input) {
                       const ScanFiles scan = scan_files_from(text_of_bytes(input), "input", ".");
                       (void)scan_files_from(scan_yaml_of(scan, "."), "again", ".");
                     }},
                    bytes_of_yaml);

const bool rig_known = add_fuzz_target(
    {"rig",
     [] {
       return std::vector<Bytes>{
           bytes_of(std::string("camera:\n  source: virtual\n  exposure: 8\nscanner: s.yaml\n"
                                "cleaning:\n  low_steps: [1, 2, three]\n"))};
     },
     [](std::span<const std::uint8_t> input) { (void)rig_from(text_of_bytes(input), "input"); }},
    bytes_of_yaml);

std::vector<Bytes> pose_tables() {
  return {bytes_of(std::string("name,x,y,z,a,b,c\np1,1,2,3,4,5,6\np2,1.5,2,3,4,5,6\n")),
          bytes_of(std::string("DECL E6POS XP1={X 100.5,Y -2,Z 3,A 10,B 20,C 30,S 2,T 35}\n")),
          bytes_of(std::string("poses:\n- {name: a, x: 1, y: 2, z: 3, rx: 4, ry: 5, rz: 6}\n"
                               "- {position: [1, 2, 3], rotation: [4, 5, 6]}\n"))};
}

const bool pose_tables_known =
    add_fuzz_target({"poses", pose_tables,
                     [](std::span<const std::uint8_t> input) {
                       (void)pose_table_in_text(text_of_bytes(input),
                                                !input.empty() && input[0] == 'p', "", "input");
                     }},
                    bytes_of_yaml);

const bool artefacts_known = add_fuzz_target(
    {"verify",
     [] {
       return std::vector<Bytes>{
           bytes_of(std::string("diameters: [40.002, 40.001]\ndistance: 100.005\n"
                                "spheres: [bar1, bar2]\nplanes: [plane1]\n"
                                "repeated: [still1, still2]\ndiagonal: 380\n")),
           bytes_of(std::string("planes: &all [plane1, plane2]\nrepeated: *all\n"))};
     },
     [](std::span<const std::uint8_t> input) {
       (void)read_artefacts(file_of(input, "artefacts.yaml"));
     }},
    bytes_of_yaml);

const bool batch_plan_known =
    add_fuzz_target({"batch.plan",
                     [] {
                       const nlohmann::json plan{{"slipstream", 1},
                                                 {"version", SLIPSTREAM_VERSION},
                                                 {"tasks", 8},
                                                 {"scans", 24},
                                                 {"arguments", {"--depth={name}.tiff", "--raw"}}};
                       return std::vector<Bytes>{bytes_of(plan.dump(2) + '\n')};
                     },
                     [](std::span<const std::uint8_t> input) {
                       (void)app::batch_plan_from(text_of_bytes(input), "input");
                     }});

const bool list_known = add_fuzz_target(
    {"list",
     [] {
       return std::vector<Bytes>{
           bytes_of(std::string("a\nb.slip\t:\n\nc.slip\t3:9\t81000\t2\nd\t\t900\n"))};
     },
     [](std::span<const std::uint8_t> input) {
       std::vector<ListedScans> scans = scan_list_from(text_of_bytes(input), "input");
       if (scan_list_from(text_of(scans), "again") != scans) {
         throw std::logic_error("a list that is written reads as another");
       }
       std::uint64_t count = 0;
       for (ListedScans& listed : scans) {
         count += std::min(scan_count(listed, 3), 9999UL);
         listed.cost = std::max(listed.cost, 1UL);
       }
       if (count < 9999) (void)scan_names(cut_into_shards(scans, 3, 7), 3);
     }},
    40'000);  // each of the scans has its path

const bool manifest_known = add_fuzz_target(
    {"manifest",
     [] {
       nlohmann::json entry = app::entry_for({"a.slip", 3}, {"--gamma=none"});
       entry["outputs"] = app::sums_of({"missing.ply"});
       const std::string done = app::line_of(entry);
       entry["error"] = "a.slip: its header is damaged";
       return std::vector<Bytes>{bytes_of(done), bytes_of(done + app::line_of(entry) + "{\"sc")};
     },
     [](std::span<const std::uint8_t> input) {
       const app::Manifest manifest = app::manifest_from(text_of_bytes(input), "input");
       for (const auto& [scan, entry] : manifest.entries) {
         (void)app::why_not_done(manifest, scan, app::entry_for(scan, {"--gamma=none"}), {"x.ply"});
         (void)app::line_of(entry);
       }
     }});

}  // namespace
}  // namespace slipstream
