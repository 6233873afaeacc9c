#include "slipstream/scanner_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include <Eigen/LU>

#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "geometry/lens_residual.h"
#include "io/file.h"
#include "io/matrix_files.h"
#include "io/opencv_storage.h"
#include "io/photometry_entries.h"
#include "io/scanner_layouts.h"
#include "io/unique_keys.h"
#include "response/response_fit.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

constexpr const char* measured_entry = "measured";
constexpr const char* depths_entry = "calibrated_depths";

/// The RMS reprojection error of both devices: slipstream's name, then those of other tools.
constexpr std::array rms_entries{"calibration_rms", "stereo_rms", "stereo_error"};

/// Throws Error with the likely cause if the entry is missing.
void require_present(const StoredEntries& entries, std::string_view name) {
  if (has(entries, name)) return;

  const bool is_one_file = std::ranges::none_of(
      entries, [](const auto& entry) { return entry.first.starts_with(of_projector); });
  const bool is_in_second = has(entries, fmt::format("{}{}", of_projector, name));

  throw Error(fmt::format("{} is missing{}", name,
                          is_one_file && name.starts_with(of_projector)
                              ? "; name its file too: `scanner CAMERA,PROJECTOR`"
                          : is_in_second ? " in the first file; name the camera's file first"
                                         : ""));
}

/// The numbers of an existing entry.
const std::vector<double>& numbers_of(const StoredEntries& entries, std::string_view name) {
  const StoredMatrix& matrix = entries.at(std::string(name));
  throw_if(matrix.rows == 0, "{} is not a matrix of numbers", name);

  for (const double value : matrix.numbers) {
    throw_if(!std::isfinite(value), "{} contains {}; every number must be finite", name, value);
  }
  return matrix.numbers;
}

/// rows x columns numbers, row by row.
template <int rows, int columns>
Eigen::Matrix<double, rows, columns> matrix_of(const StoredEntries& entries,
                                               std::string_view name) {
  require_present(entries, name);

  const std::vector<double>& values = numbers_of(entries, name);
  throw_if(values.size() != std::size_t{rows * columns}, "{} has {} numbers; expected {}x{}", name,
           values.size(), rows, columns);

  const Eigen::Map<const Eigen::Vector<double, rows * columns>> numbers(values.data());
  return numbers.template reshaped<Eigen::RowMajor>(rows, columns);
}

/// Whole numbers of pixels; 0 if missing.
std::vector<int> pixel_counts(const StoredEntries& entries, std::string_view name,
                              std::size_t count) {
  if (!has(entries, name)) return std::vector<int>(count, 0);

  const std::vector<double>& values = numbers_of(entries, name);
  const auto is_count = [](double value) {
    return value >= 1 && value <= 65536 && value == std::floor(value);
  };

  throw_if(values.size() != count || !std::all_of(values.begin(), values.end(), is_count),
           "{} is not {} of pixels", name, count == 1 ? "a number" : "two numbers");
  return {values.begin(), values.end()};
}

Size size_of(const StoredEntries& entries, const LensNames& names) {
  const bool height_first = names.width.empty();
  if (!height_first && !names.height.empty()) {
    return {pixel_counts(entries, names.width, 1)[0], pixel_counts(entries, names.height, 1)[0]};
  }

  // One entry has both.
  const auto both = pixel_counts(entries, height_first ? names.height : names.width, 2);
  return height_first ? Size{both[1], both[0]} : Size{both[0], both[1]};
}

Lens lens_of(const StoredEntries& entries, const LensNames& names) {
  Lens lens{.intrinsic = matrix_of<3, 3>(entries, names.matrix), .distortion = {}, .size = {}};

  if (has(entries, names.distortion)) {
    const std::vector<double>& coefficients = numbers_of(entries, names.distortion);
    lens.distortion =
        naming(std::string(names.distortion), [&] { return make_distortion(coefficients); });
  }

  lens.size = size_of(entries, names);
  return lens;
}

/// No residual without the entry.
LensResidual residual_of(const StoredEntries& entries, std::string_view name) {
  if (!has(entries, name)) return {};

  const StoredMatrix& matrix = entries.at(std::string(name));
  const std::vector<double>& values = numbers_of(entries, name);
  throw_if(matrix.rows != 2 || matrix.columns < 3,
           "{} has {} rows and {} columns; expected two rows of centre, half size and terms", name,
           matrix.rows, matrix.columns);

  const auto column = [&](int i) { return Eigen::Vector2d(values[i], values[matrix.columns + i]); };
  LensResidual residual{.centre = column(0), .half = column(1)};
  for (int i = 2; i < matrix.columns; ++i) residual.terms.push_back(column(i));
  require_valid(residual, name);
  return residual;
}

StoredEntries entries_of(const Scanner& scanner) {
  StoredEntries entries = entries_of(scanner.photometry);

  const auto put = [&](std::string_view name, const auto& matrix) {
    const auto numbers = matrix.template reshaped<Eigen::RowMajor>();
    entries[std::string(name)] = {static_cast<int>(matrix.rows()),
                                  static_cast<int>(matrix.cols()),
                                  {numbers.begin(), numbers.end()}};
  };

  const auto put_lens = [&](const LensNames& names, const Lens& lens) {
    const auto& k = lens.distortion.coefficients;
    put(names.matrix, lens.intrinsic);
    put(names.distortion, Eigen::Map<const Eigen::RowVectorXd>(k.data(), k.size()));
    put(names.width, Eigen::Matrix<double, 1, 1>(lens.size.width));
    put(names.height, Eigen::Matrix<double, 1, 1>(lens.size.height));
  };

  const auto put_residual = [&](std::string_view name, const LensResidual& residual) {
    if (residual.terms.empty()) return;
    Eigen::Matrix2Xd columns(2, residual.terms.size() + 2);
    columns << residual.centre, residual.half,
        Eigen::Map<const Eigen::Matrix2Xd>(residual.terms.front().data(), 2, residual.terms.size());
    put(name, columns);
  };

  // The lenses and the pose, mm.
  const ScannerLayout& names = scanner_layouts.front();
  put_lens(names.camera, scanner.camera);
  put_lens(names.projector, scanner.projector);
  put_residual(residual_entries[0], scanner.camera.residual);
  put_residual(residual_entries[1], scanner.projector.residual);
  put(names.rotation, scanner.rotation);
  put(names.translation, scanner.translation);

  if (const auto& depths = scanner.calibrated_depths) {
    put(depths_entry, Eigen::RowVector2d(depths->nearest, depths->farthest));
  }

  if (scanner.calibration_rms > 0) {
    put(rms_entries.front(), Eigen::Matrix<double, 1, 1>(scanner.calibration_rms));
  }
  if (!scanner.measured.empty()) entries[measured_entry] = {.text = scanner.measured};
  return entries;
}

/// The text of a file for that path. Throws Error if read_scanner would.
std::string text_of(const fs::path& path, const Scanner& scanner) {
  std::string text = new_storage(entries_of(scanner), lower_case_extension(path) == ".xml");

  // Validates the text by reading it.
  static_cast<void>(scanner_from(text, path.string()));
  return text;
}

/// A file's entries other than geometry; {} without such a file.
StoredEntries other_entries(const fs::path& path) {
  StoredEntries entries;
  if (!fs::exists(path)) return entries;

  try {
    entries = read_opencv_storage(path);
  } catch (const RepeatedKey&) {
    throw;  // rather than lose calibrations in a scanner file
  } catch (const Error&) {
    return {};  // another kind of file; overwritten, as by write_scanner
  }

  std::erase_if(entries, [](const auto& entry) {
    return names_geometry(entry.first) || entry.first == measured_entry ||
           entry.first == depths_entry || std::ranges::count(rms_entries, entry.first) > 0 ||
           entry.second.empty();
  });

  return entries;
}

/// Sets the pose of two devices calibrated as a stereo pair of ROS: rectification_matrix turns a
/// device's frame into the rectified one, in which projection_matrix is K [I | t], t in metres.
void set_rectified_pose(const StoredEntries& entries, Scanner& scanner) {
  const auto rectified = [&](std::string_view device) {
    const auto name = [&](const char* part) { return fmt::format("{}{}", device, part); };

    // A fisheye model has other coefficients.
    if (const auto model = entries.find(name("distortion_model")); model != entries.end()) {
      const std::string& text = model->second.text;
      throw_if(text != "plumb_bob" && text != "rational_polynomial",
               "{} is {}; expected plumb_bob or rational_polynomial", model->first, text);
    }

    const auto projection = matrix_of<3, 4>(entries, name("projection_matrix"));
    const Eigen::Vector3d t = projection.leftCols<3>().inverse() * projection.col(3);

    return std::pair(matrix_of<3, 3>(entries, name("rectification_matrix")), t);
  };

  constexpr double mm_per_metre = 1000;
  const auto [to_rectified, camera] = rectified("");
  const auto [projector_to_rectified, projector] = rectified(of_projector);

  // From the camera's frame over the rectified one to the projector's.
  const Eigen::Matrix3d from_rectified = projector_to_rectified.transpose();
  scanner.rotation = from_rectified * to_rectified;
  scanner.translation = mm_per_metre * from_rectified * (projector - camera);

  throw_if(scanner.translation.isZero(0),
           "the projection matrices have no baseline; calibrate both devices as a stereo pair");
}

/// The lenses and pose of a camera and a projector or, as a `pair`, a second camera.
Scanner geometry_of(const StoredEntries& entries, bool pair) {
  // 1. Projection matrices: the lenses and the pose are factors of them.
  if (has(entries, projection_entries[0]) || has(entries, projection_entries[1])) {
    const Size projector_size = size_of(entries, scanner_layouts.front().projector);
    const auto projector = matrix_of<3, 4>(entries, projection_entries[1]);
    const Size camera_size = size_of(entries, scanner_layouts.front().camera);
    const auto camera = matrix_of<3, 4>(entries, projection_entries[0]);
    return scanner_of(camera, camera_size, projector, projector_size);
  }

  // 2. Lenses and pose as entries.
  const ScannerLayout& names = layout_of(entries);
  throw_if(pair != is_camera_pair(names, pair), "{}",
           pair ? "calibrates a projector, not a second camera"
                : "calibrates two cameras and no projector; only `reconstruct()` reads it, "
                  "for scans of both cameras");

  Scanner scanner;
  scanner.camera = lens_of(entries, names.camera);
  scanner.projector = lens_of(entries, names.projector);

  if (names.rotation.empty()) {
    set_rectified_pose(entries, scanner);
    return scanner;
  }

  scanner.rotation = matrix_of<3, 3>(entries, names.rotation);
  scanner.translation = matrix_of<3, 1>(entries, names.translation);

  return scanner;
}

Scanner scanner_of(const StoredEntries& entries, const std::string& name, bool pair = false) {
  return naming(name, [&] {
    Scanner scanner = geometry_of(entries, pair);
    scanner.camera.residual = residual_of(entries, residual_entries[0]);
    scanner.projector.residual = residual_of(entries, residual_entries[1]);
    scanner.photometry = photometric_calibration_of(entries);

    if (has(entries, depths_entry)) {
      const auto depths = matrix_of<1, 2>(entries, depths_entry);
      scanner.calibrated_depths = {depths[0], depths[1]};
    }

    const auto rms =
        std::ranges::find_if(rms_entries, [&](const char* entry) { return has(entries, entry); });
    if (rms != rms_entries.end()) scanner.calibration_rms = matrix_of<1, 1>(entries, *rms)[0];

    if (has(entries, measured_entry)) scanner.measured = entries.at(measured_entry).text;
    return scanner;
  });
}

/// The entries of two files. If both name their geometry alike, the second is the projector's.
StoredEntries joined(StoredEntries first, const StoredEntries& second) {
  const bool are_alike = std::ranges::any_of(second, [&](const auto& entry) {
    return names_geometry(entry.first) && has(first, entry.first);
  });
  const bool is_complete = std::ranges::any_of(scanner_layouts, [&](const ScannerLayout& layout) {
    return has(first, layout.projector.matrix);
  });

  throw_if(are_alike && is_complete, "the first is a complete scanner file; name it alone");

  for (const auto& [name, entry] : second) {
    first.emplace((are_alike ? std::string(of_projector) : "") + name, entry);
  }
  return first;
}

StoredEntries entries_in(const fs::path& path) {
  if (has_matrices(path)) return read_matrices(path);

  const std::vector<fs::path> files = scanner_files(path);
  const StoredEntries first = read_opencv_storage(files[0]);
  if (files.size() == 1) return first;

  const StoredEntries second = read_opencv_storage(files[1]);
  return naming(path.string(), [&] { return joined(first, second); });
}

}  // namespace

std::vector<fs::path> scanner_files(const fs::path& path) {
  const std::string text = path.string();
  const std::size_t comma = text.find(',');
  std::error_code unknown;

  // A file whose name has a comma is one file.
  if (comma == text.npos || fs::exists(path, unknown)) return {path};

  return {text.substr(0, comma), text.substr(comma + 1)};
}

fs::path scanner_in(const fs::path& folder, const fs::path& path) {
  const std::vector<fs::path> files = scanner_files(folder / path);
  if (files.size() == 1) return files[0];
  return fmt::format("{},{}", files[0].string(), (folder / files[1]).string());
}

Scanner read_scanner(const fs::path& path) {
  return scanner_of(entries_in(path), path.string());
}

Scanner read_camera_pair(const fs::path& path) {
  return scanner_of(entries_in(path), path.string(), true);
}

bool is_camera_pair(const fs::path& path, bool if_either) {
  const StoredEntries entries = entries_in(path);
  return !has(entries, projection_entries[0]) &&
         naming(path.string(), [&] { return is_camera_pair(layout_of(entries), if_either); });
}

Scanner scanner_from(const std::string& text, const std::string& name) {
  return scanner_of(opencv_entries(text, name), name);
}

std::string text_of(const Scanner& scanner) {
  return text_of(".yaml", scanner);
}

void write_scanner(const fs::path& path, const Scanner& scanner) {
  write_file(path, text_of(path, scanner));
}

std::vector<std::string> replace_geometry(const fs::path& path, const Scanner& scanner) {
  const StoredEntries kept = other_entries(path);
  write_file(path, with_entries(text_of(path, scanner), kept, path.string()));

  std::vector<std::string> names;
  for (const auto& [name, numbers] : kept) names.push_back(name);
  return names;
}

PhotometricCalibration read_photometric_calibration(const fs::path& scanner_file) {
  const StoredEntries entries = read_opencv_storage(scanner_file);
  return naming(scanner_file.string(), [&] { return photometric_calibration_of(entries); });
}

void write_photometric_calibration(const std::optional<fs::path>& from, const fs::path& to,
                                   const PhotometricCalibration& calibration) {
  write_entries(from, to, entries_of(calibration));
}

Response response_named(const std::string& text, const std::string& name) {
  if (const auto gamma = number_in<double>(text)) {
    require_gamma(*gamma, name);
    return PowerLaw{*gamma};
  }

  if (auto curve = curve_named(text)) return *std::move(curve);

  const auto measured = read_photometric_calibration(text).response;
  throw_if(!measured, "{}: has no gamma; add it with `calibrate_gamma()`", text);

  return measured->response;
}

}  // namespace slipstream
