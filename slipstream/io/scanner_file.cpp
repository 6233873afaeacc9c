#include "slipstream/io/scanner_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/geometry/projection_matrices.h"
#include "slipstream/io/file.h"
#include "slipstream/io/opencv_storage.h"
#include "slipstream/io/photometric_file.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

/// The names of one layout; the sizes are empty where the layout has none. A width without a height
/// is an entry of both.
struct Layout {
  std::string_view camera_matrix, camera_distortion, camera_width, camera_height;
  std::string_view projector_matrix, projector_distortion, projector_width, projector_height;
  std::string_view rotation, translation;
};

constexpr std::array<Layout, 4> layouts{{
    {"camera_matrix", "camera_distortion", "camera_width", "camera_height", "projector_matrix",
     "projector_distortion", "projector_width", "projector_height", "rotation", "translation"},
    {"Kc", "kc", "frameWidth", "frameHeight", "Kp", "kp", "screenResX", "screenResY", "Rp", "Tp"},
    {"cam_K", "cam_kc", "", "", "proj_K", "proj_kc", "", "", "R", "T"},
    {"M1", "D1", "S", "", "M4", "D4", "", "", "Rlp", "Tlp"},
}};

// The layout of projection matrices, whose sizes have slipstream's names.
constexpr std::array<std::string_view, 2> projections{"camera_projection", "projector_projection"};

constexpr const char* measured_entry = "measured";
constexpr const char* depths_entry = "calibrated_depths";

/// The named entries of one scanner file, with errors that name file and entry.
class ScannerFile {
 public:
  ScannerFile(std::string name, std::map<std::string, StoredMatrix> entries)
      : name_(std::move(name)), entries_(std::move(entries)) {}

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::map<std::string, StoredMatrix>& entries() const { return entries_; }

  [[nodiscard]] bool has(std::string_view name) const {
    return !name.empty() && entries_.contains(std::string(name));
  }

  [[nodiscard]] const Layout& layout() const {
    for (const Layout& layout : layouts) {
      if (has(layout.camera_matrix) || has(layout.projector_matrix)) return layout;
    }
    throw Error(
        fmt::format("{}: no camera matrix; it is named camera_matrix, Kc, cam_K, M1 or "
                    "camera_projection in a scanner "
                    "file",
                    name_));
  }

  /// rows x columns numbers, row by row.
  [[nodiscard]] std::vector<double> matrix(std::string_view name, std::size_t rows,
                                           std::size_t columns) const {
    if (!has(name)) throw Error(fmt::format("{}: {} is missing", name_, name));
    std::vector<double> values = numbers(name);
    if (values.size() != rows * columns) {
      throw Error(fmt::format("{}: {} has {} numbers; it is {}x{}", name_, name, values.size(),
                              rows, columns));
    }
    return values;
  }

  [[nodiscard]] Distortion distortion(std::string_view name) const {
    if (!has(name)) return {};
    try {
      return make_distortion(numbers(name));
    } catch (const Error& error) {
      const std::string_view message = error.what();
      if (message.starts_with(name_)) throw;
      throw Error(fmt::format("{}: {}: {}", name_, name, message));
    }
  }

  /// Whole numbers of pixels; 0 where the file does not say.
  [[nodiscard]] Size size(std::string_view width, std::string_view height) const {
    if (!height.empty()) return {pixel_counts(width, 1)[0], pixel_counts(height, 1)[0]};
    const std::vector<int> both = pixel_counts(width, 2);
    return {both[0], both[1]};
  }

 private:
  [[nodiscard]] std::vector<int> pixel_counts(std::string_view name, std::size_t count) const {
    if (!has(name)) return std::vector<int>(count, 0);
    const std::vector<double> values = numbers(name);
    const auto is_count = [](double value) {
      return value >= 1 && value <= 65536 && value == std::floor(value);
    };
    if (values.size() != count || !std::all_of(values.begin(), values.end(), is_count)) {
      throw Error(fmt::format("{}: {} is not {} of pixels", name_, name,
                              count == 1 ? "a number" : "two numbers"));
    }
    return {values.begin(), values.end()};
  }

  [[nodiscard]] std::vector<double> numbers(std::string_view name) const {
    const StoredMatrix& matrix = entries_.at(std::string(name));
    if (matrix.rows == 0) {
      throw Error(fmt::format("{}: {} is not a matrix of numbers", name_, name));
    }
    for (const double value : matrix.numbers) {
      if (!std::isfinite(value)) {
        throw Error(
            fmt::format("{}: {} holds {}; every number must be finite", name_, name, value));
      }
    }
    return matrix.numbers;
  }

  std::string name_;
  std::map<std::string, StoredMatrix> entries_;
};

Eigen::Matrix<double, 3, 4> matrix34(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(values.data());
}

Eigen::Matrix3d matrix3(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(values.data());
}

std::map<std::string, StoredMatrix> entries_of(const Scanner& scanner) {
  std::map<std::string, StoredMatrix> entries = entries_of(scanner.photometry);
  const auto put = [&](std::string_view name, const auto& matrix) {
    StoredMatrix& entry = entries[std::string(name)];
    entry = {static_cast<int>(matrix.rows()), static_cast<int>(matrix.cols())};
    for (const auto& row : matrix.rowwise()) {
      entry.numbers.insert(entry.numbers.end(), row.begin(), row.end());
    }
  };
  const auto put_lens = [&](const Lens& lens, std::string_view matrix, std::string_view distortion,
                            std::string_view width, std::string_view height) {
    const auto& k = lens.distortion.coefficients;
    put(matrix, lens.intrinsic);
    put(distortion, Eigen::Map<const Eigen::RowVectorXd>(k.data(), k.size()));
    put(width, Eigen::Matrix<double, 1, 1>(lens.size.width));
    put(height, Eigen::Matrix<double, 1, 1>(lens.size.height));
  };
  const Layout& names = layouts.front();
  put_lens(scanner.camera, names.camera_matrix, names.camera_distortion, names.camera_width,
           names.camera_height);
  put_lens(scanner.projector, names.projector_matrix, names.projector_distortion,
           names.projector_width, names.projector_height);
  put(names.rotation, scanner.rotation);
  put(names.translation, scanner.translation);
  if (const auto& depths = scanner.calibrated_depths) {
    put(depths_entry, Eigen::RowVector2d(depths->nearest, depths->farthest));
  }
  if (!scanner.measured.empty()) entries[measured_entry] = {.text = scanner.measured};
  return entries;
}

/// The text of a file of that path. Throws Error where read_scanner would.
std::string text_of(const fs::path& path, const Scanner& scanner) {
  std::string text = new_storage(entries_of(scanner), lower_case_extension(path) == ".xml");
  static_cast<void>(scanner_from(text, path.string()));
  return text;
}

bool names_geometry(std::string_view entry) {
  if (std::find(projections.begin(), projections.end(), entry) != projections.end()) return true;
  return std::any_of(layouts.begin(), layouts.end(), [&](const Layout& layout) {
    const std::array names{layout.camera_matrix,    layout.camera_distortion,
                           layout.camera_width,     layout.camera_height,
                           layout.projector_matrix, layout.projector_distortion,
                           layout.projector_width,  layout.projector_height,
                           layout.rotation,         layout.translation};
    return std::find(names.begin(), names.end(), entry) != names.end();
  });
}

/// What a file holds besides geometry; nothing where there is no such file.
std::map<std::string, StoredMatrix> other_entries(const fs::path& path) {
  std::map<std::string, StoredMatrix> entries;
  if (!fs::exists(path)) return entries;
  try {
    entries = read_opencv_storage(path);
  } catch (const Error&) {
    return {};  // something else, which is written over as by write_scanner
  }
  std::erase_if(entries, [](const auto& entry) {
    return names_geometry(entry.first) || entry.first == measured_entry ||
           entry.first == depths_entry || entry.second.empty();
  });
  return entries;
}

Scanner geometry_of_projections(const ScannerFile& file) {
  const Layout& names = layouts.front();
  const auto [camera, projector] = projections;
  try {
    return scanner_of(matrix34(file.matrix(camera, 3, 4)),
                      file.size(names.camera_width, names.camera_height),
                      matrix34(file.matrix(projector, 3, 4)),
                      file.size(names.projector_width, names.projector_height));
  } catch (const Error& error) {
    const std::string_view message = error.what();
    if (message.starts_with(file.name())) throw;
    throw Error(fmt::format("{}: {}", file.name(), message));
  }
}

/// Lenses and pose.
Scanner geometry_of(const ScannerFile& file) {
  if (file.has(projections[0]) || file.has(projections[1])) return geometry_of_projections(file);
  const Layout& names = file.layout();
  Scanner scanner;
  scanner.camera = {.intrinsic = matrix3(file.matrix(names.camera_matrix, 3, 3)),
                    .distortion = file.distortion(names.camera_distortion),
                    .size = file.size(names.camera_width, names.camera_height)};
  scanner.projector = {.intrinsic = matrix3(file.matrix(names.projector_matrix, 3, 3)),
                       .distortion = file.distortion(names.projector_distortion),
                       .size = file.size(names.projector_width, names.projector_height)};
  scanner.rotation = matrix3(file.matrix(names.rotation, 3, 3));
  scanner.translation = Eigen::Vector3d(file.matrix(names.translation, 3, 1).data());
  return scanner;
}

Scanner scanner_of(const ScannerFile& file) {
  Scanner scanner = geometry_of(file);
  scanner.photometry = photometric_calibration_of(file.entries(), file.name());
  if (file.entries().contains(depths_entry)) {
    const std::vector<double> depths = file.matrix(depths_entry, 1, 2);
    scanner.calibrated_depths = {depths[0], depths[1]};
  }
  const auto measured = file.entries().find(measured_entry);
  if (measured != file.entries().end()) scanner.measured = measured->second.text;
  return scanner;
}

}  // namespace

Scanner read_scanner(const fs::path& path) {
  return scanner_of({path.string(), read_opencv_storage(path)});
}

Scanner scanner_from(const std::string& text, const std::string& name) {
  return scanner_of({name, opencv_entries(text, name)});
}

std::string text_of(const Scanner& scanner) {
  return text_of(".yaml", scanner);
}

void write_scanner(const fs::path& path, const Scanner& scanner) {
  write_file(path, text_of(path, scanner));
}

std::vector<std::string> replace_geometry(const fs::path& path, const Scanner& scanner) {
  const std::map<std::string, StoredMatrix> kept = other_entries(path);
  write_file(path, with_entries(text_of(path, scanner), kept, path.string()));
  std::vector<std::string> names;
  for (const auto& [name, numbers] : kept) names.push_back(name);
  return names;
}

}  // namespace slipstream
