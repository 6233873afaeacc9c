// Every reader on files with random bytes changed, left out or put in: it reads them or throws
// Error, and does nothing else. Run under the sanitizers, this is where a parser would fail.
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/error/error.h"
#include "slipstream/io/cloud_file.h"
#include "slipstream/io/file.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/mesh_file.h"
#include "slipstream/io/photometric_file.h"
#include "slipstream/io/recording.h"
#include "slipstream/io/scan_folder.h"
#include "slipstream/io/scanner_file.h"
#include "slipstream/io/stored_cloud.h"
#include "slipstream/io/surface_file.h"
#include "slipstream/strategy/dual_frequency.h"
#include "tests/io/recorded_frames.h"
#include "tests/io/sheet_cloud.h"
#include "tests/io/temporary_folder.h"

namespace slipstream {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// The file with one to eight changes. Numbers in these formats are text, so digits and signs are
/// likelier than other bytes.
Bytes damaged(Bytes bytes, std::mt19937& random) {
  static const std::string likely = "0123456789-.:,[]{}\n eE<>/\"";
  const auto below = [&](std::size_t limit) { return limit == 0 ? 0 : random() % limit; };
  for (std::size_t change = 0; change <= below(8); ++change) {
    const auto at = static_cast<std::ptrdiff_t>(below(bytes.size()));
    const std::uint8_t byte = below(2) == 0
                                  ? static_cast<std::uint8_t>(random())
                                  : static_cast<std::uint8_t>(likely[below(likely.size())]);
    switch (below(4)) {
      case 0:
        bytes.insert(bytes.begin() + at, byte);
        break;
      case 1:
        bytes.resize(static_cast<std::size_t>(at));
        break;
      case 2:
        if (!bytes.empty()) bytes.erase(bytes.begin() + at);
        break;
      default:
        if (!bytes.empty()) bytes[static_cast<std::size_t>(at)] = byte;
    }
  }
  return bytes;
}

struct Format {
  std::string name;
  std::function<void(const std::filesystem::path&)> write;
  std::function<void(const std::filesystem::path&)> read;
};

void PrintTo(const Format& format, std::ostream* stream) {
  *stream << format.name;
}

Scanner some_scanner() {
  Scanner scanner;
  scanner.camera.size = {640, 480};
  scanner.projector.size = {1024, 768};
  scanner.translation = {100, 0, 0};
  return scanner;
}

Image<std::uint8_t> some_picture() {
  Image<std::uint8_t> picture({12, 9});
  std::uint8_t value = 0;
  for (std::uint8_t& pixel : picture) pixel = value += 7;
  return picture;
}

const auto write_picture = [](const auto& path) { write_image(path, some_picture()); };
const auto read_picture = [](const auto& path) { read_frames({path}); };

const auto write_curve = [](const auto& path) {
  const std::array values{0.0, 0.25, 0.5, 0.75, 1.0}, light{0.0, 0.1, 0.3, 0.6, 1.0};
  write_photometric_calibration(
      std::nullopt, path,
      {.response = MeasuredResponse{.response = response_curve(values, light), .gamma = 2}});
};
const auto read_light = [](const auto& path) { (void)read_photometric_calibration(path); };

const auto write_some_cloud = [](const auto& path) {
  Cloud cloud({3, 2});
  for (int i = 1; i < 6; ++i) {
    cloud.x.begin()[i] = cloud.y.begin()[i] = static_cast<float>(i);
    cloud.z.begin()[i] = 500;
    cloud.validity.begin()[i] = Validity::valid;
  }
  const Uncertainty sigma(cloud.size());
  write_cloud(path, cloud, {.uncertainty = &sigma});
};
const auto write_some_surface = [](const auto& path) {
  write_surface(path, surface_of(sheet_cloud()));
};
const auto read_any_cloud = [](const auto& path) { (void)read_cloud(path); };

const std::vector<Format> formats{
    {"scan.yaml",
     [](const auto& path) {
       write_scan_files(path, {.sequence = {.strategy = DualFrequency{}, .projector = {1824, 1140}},
                               .frames = {"a.png", "b.png"}});
     },
     [](const auto& path) { read_scan_files(path); }},
    {"scanner.yaml", [](const auto& path) { write_scanner(path, some_scanner()); },
     [](const auto& path) { require_valid(read_scanner(path)); }},
    {"scanner.xml", [](const auto& path) { write_scanner(path, some_scanner()); },
     [](const auto& path) { require_valid(read_scanner(path)); }},
    {"slmaster.yml",
     [](const auto& path) {
       const auto matrix = [](const std::string& name, int rows, int columns,
                              const std::string& data) {
         return name + ": !!opencv-matrix\n   rows: " + std::to_string(rows) +
                "\n   cols: " + std::to_string(columns) + "\n   dt: d\n   data: [ " + data + " ]\n";
       };
       const std::string lens = "900., 0., 320., 0., 901., 240., 0., 0., 1.";
       write_file(path, "%YAML:1.0\n---\n" + matrix("M1", 3, 3, lens) +
                            matrix("D1", 1, 5, "0.1, 0., 0., 0., 0.") +
                            matrix("S", 2, 1, "640., 480.") + matrix("M4", 3, 3, lens) +
                            matrix("Rlp", 3, 3, "1., 0., 0., 0., 1., 0., 0., 0., 1.") +
                            matrix("Tlp", 3, 1, "-108., 2., 3."));
     },
     [](const auto& path) {
       require_valid(completed(read_scanner(path), path, {}, {1920, 1080}));
     }},
    {"response.yaml", write_curve, read_light},
    {"response.xml", write_curve, read_light},
    {"photometry.yaml",
     [](const auto& path) {
       write_photometric_calibration(std::nullopt, path, {.ambient = -7, .noise_variance = 1.55});
     },
     read_light},
    {"frame.png", write_picture, read_picture},
    {"frame.pgm", write_picture, read_picture},
    {"frame.bmp", write_picture, read_picture},
    {"frame.tiff", write_picture, read_picture},
    {"mesh.ply",
     [](const auto& path) {
       write_file(path,
                  "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                  "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
                  "end_header\n0 0 0\n1 0 0\n1 1 0\n3 0 1 2\n");
     },
     [](const auto& path) { read_mesh(path); }},
    {"cloud.ply",
     [](const auto& path) {
       write_file(path,
                  "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                  "property float z\nproperty uchar red\nproperty float intensity\nend_header\n"
                  "0 0 500 3 17\n1 0 501.5 4 18\nnan 1 2 3 4\n");
     },
     [](const auto& path) { (void)read_cloud(path); }},
    {"written.ply", write_some_cloud, read_any_cloud},
    {"cloud.pcd", write_some_cloud, read_any_cloud},
    {"cloud.xyz", write_some_cloud, read_any_cloud},
    {"surface.ply", write_some_surface, read_any_cloud},
    {"surface.stl", write_some_surface, read_any_cloud},
    {"surface.obj", write_some_surface, read_any_cloud},
    {"surface.glb", write_some_surface, read_any_cloud},
    {"frames.recording",
     [](const auto& path) {
       RecordingWriter writer(path, {.format = some_format,
                                     .sequence = Sequence{.strategy = DualFrequency{}},
                                     .scanner = some_scanner()});
       for (int i = 0; i < 3; ++i) writer.append(some_frame(i));
       writer.finish();
     },
     [](const auto& path) {
       const RecordingReader reader(path);
       Frame frame;
       for (std::uint64_t i = 0; i < reader.count(); ++i) (void)reader.read(i, frame);
     }},
    {"mesh.obj", [](const auto& path) { write_file(path, "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n"); },
     [](const auto& path) { read_mesh(path); }},
};

class DamagedFile : public testing::TestWithParam<Format> {};

TEST_P(DamagedFile, IsReadOrRefused) {
  const TemporaryFolder folder;
  const auto path = folder.path() / GetParam().name;
  GetParam().write(path);
  EXPECT_NO_THROW(GetParam().read(path));
  const Bytes whole = read_file(path);
  std::mt19937 random(2010);
  int refused = 0;
  for (int i = 0; i < 2000; ++i) {
    put_bytes(path, damaged(whole, random));
    try {
      GetParam().read(path);
    } catch (const Error& error) {
      ++refused;
      ASSERT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
  }
  EXPECT_GT(refused, 100);
}

INSTANTIATE_TEST_SUITE_P(Format, DamagedFile, testing::ValuesIn(formats), [](const auto& info) {
  std::string name = info.param.name;
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
});

TEST(Png, EveryTruncationIsFound) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "frame.png";
  write_image(path, some_picture());
  const Bytes whole = read_file(path);
  for (std::size_t length = 0; length < whole.size(); ++length) {
    put_bytes(path, std::span(whole).first(length));
    EXPECT_THROW(read_frames({path}), Error) << length;
  }
}

}  // namespace
}  // namespace slipstream
