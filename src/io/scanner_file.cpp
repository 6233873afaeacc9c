#include "slipstream/scanner_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <system_error>
#include <variant>
#include <vector>

#include <Eigen/LU>

#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "frames/colour_channels.h"
#include "io/file.h"
#include "io/opencv_storage.h"
#include "io/unique_keys.h"
#include "response/response_fit.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

constexpr const char* gamma_entry = "gamma";
constexpr const char* error_entry = "gamma_standard_error";
constexpr const char* values_entry = "response_values";
constexpr const char* light_entry = "response_light";
constexpr const char* mixture_entry = "colour_mixture";

std::optional<double> number(const StoredEntries& entries, const char* name) {
  const auto found = entries.find(name);
  if (found == entries.end()) return std::nullopt;

  throw_if(found->second.numbers.size() != 1, "{} is not a number", name);
  return found->second.numbers[0];
}

std::optional<MeasuredResponse> response_of(const StoredEntries& entries) {
  const std::optional<double> gamma = number(entries, gamma_entry);
  MeasuredResponse measured{.gamma = gamma.value_or(1),
                            .standard_error = number(entries, error_entry).value_or(0)};

  // A measured curve has priority over its gamma.
  const bool has_values = entries.contains(values_entry), has_light = entries.contains(light_entry);
  throw_if(has_values != has_light, "{} and {} must both be present", values_entry, light_entry);

  if (has_values) {
    measured.response =
        response_curve(entries.at(values_entry).numbers, entries.at(light_entry).numbers);
    return measured;
  }

  if (!gamma) return std::nullopt;
  measured.response = PowerLaw{*gamma};
  return measured;
}

std::optional<ColourMixture> mixture_of(const StoredEntries& entries) {
  const auto found = entries.find(mixture_entry);
  if (found == entries.end()) return std::nullopt;

  const auto& [rows, columns, numbers, text] = found->second;
  throw_if(rows != 3 || columns != 4, "{} is not a 3x4 matrix", mixture_entry);

  ColourMixture mixture{};
  for (std::size_t i = 0; i < numbers.size(); ++i) mixture[i / 4][i % 4] = numbers[i];
  require_valid(mixture);
  return mixture;
}

StoredMatrix row_of(std::vector<double> numbers) {
  return {1, static_cast<int>(numbers.size()), std::move(numbers)};
}

PhotometricCalibration photometric_calibration_of(const StoredEntries& entries) {
  PhotometricCalibration read{.response = response_of(entries),
                              .colour_mixture = mixture_of(entries)};

  PhotometricCalibration::for_each_setting(read, [&](const Setting& setting, auto& value) {
    if (const auto stored = number(entries, setting.name)) value = *stored;
  });

  require_valid(read);
  return read;
}

StoredEntries entries_of(const PhotometricCalibration& calibration) {
  StoredEntries entries;

  PhotometricCalibration::for_each_setting(
      calibration, [&](const Setting& setting, const std::optional<double>& value) {
        if (value) entries[setting.name] = row_of({*value});
      });

  // The gain describes the noise variance and means nothing without it.
  if (!calibration.noise_variance) entries.erase("noise_gain");

  if (const auto& mixture = calibration.colour_mixture) {
    StoredMatrix& stored = entries[mixture_entry] = {3, 4};
    for (const auto& row : *mixture) {
      stored.numbers.insert(stored.numbers.end(), row.begin(), row.end());
    }
  }

  if (!calibration.response) return entries;
  const auto& [response, gamma, standard_error] = *calibration.response;
  entries[gamma_entry] = row_of({gamma});
  entries[error_entry] = row_of({standard_error});
  // Empty entries are removed.
  entries[values_entry] = entries[light_entry] = {};

  if (const auto* curve = std::get_if<ResponseCurve>(&response)) {
    entries[values_entry] = row_of(curve->values);
    entries[light_entry] = row_of(curve->light);
  }

  return entries;
}

/// The names of a lens's entries; "" if a layout lacks one. Without a height, the width's entry has
/// both; without a width, the height's has both, height first.
struct LensNames {
  std::string_view matrix, distortion, width, height;
};

struct Layout {
  LensNames camera, projector;
  std::string_view rotation, translation;  ///< "": see set_rectified_pose
};

/// Begins the names of the second of two files that use the same names.
constexpr std::string_view of_projector = "the projector's ";

constexpr std::array<Layout, 11> layouts{{
    // slipstream's own, which is also written.
    {{"camera_matrix", "camera_distortion", "camera_width", "camera_height"},
     {"projector_matrix", "projector_distortion", "projector_width", "projector_height"},
     "rotation",
     "translation"},
    // SLStudio.
    {{"Kc", "kc", "frameWidth", "frameHeight"},
     {"Kp", "kp", "screenResX", "screenResY"},
     "Rp",
     "Tp"},
    // ProCamCalib.
    {{"cam_K", "cam_kc", "", ""}, {"proj_K", "proj_kc", "", ""}, "R", "T"},
    // SLMaster.
    {{"M1", "D1", "S", ""}, {"M4", "D4", "", ""}, "Rlp", "Tlp"},
    // OpenCV and MATLAB.
    {{"cameraMatrix1", "distCoeffs1", "", ""}, {"cameraMatrix2", "distCoeffs2", "", ""}, "R", "T"},
    // OpenCV's stereo_calib.
    {{"M1", "D1", "", ""}, {"M2", "D2", "", ""}, "R", "T"},
    // kamino410/procam-calibration.
    {{"cam_int", "cam_dist", "", "img_shape"},
     {"proj_int", "proj_dist", "", ""},
     "roration",  // so spelt by the tool
     "translation"},
    // BingyaoHuang/single-shot-pro-cam-calib.
    {{"camK", "camKc", "camW", "camH"}, {"prjK", "prjKc", "prjW", "prjH"}, "R", "T"},
    // sl_sensor, two files.
    {{"intrinsic_mat", "lens_distortion", "resolution_x", "resolution_y"},
     {"the projector's intrinsic_mat", "the projector's lens_distortion",
      "the projector's resolution_x", "the projector's resolution_y"},
     "extrinsic_rot",
     "extrinsic_trans"},
    // camera_info of ROS, two files.
    {{"camera_matrix", "distortion_coefficients", "image_width", "image_height"},
     {"the projector's camera_matrix", "the projector's distortion_coefficients",
      "the projector's image_width", "the projector's image_height"},
     "",
     ""},
    // slipstream's for two cameras; is_camera_pair expects it last.
    {{"camera_matrix", "camera_distortion", "camera_width", "camera_height"},
     {"second_camera_matrix", "second_camera_distortion", "second_camera_width",
      "second_camera_height"},
     "rotation",
     "translation"},
}};

/// Whether a layout's second device is a camera or, with `if_either`, only numbered as the second.
bool is_camera_pair(const Layout& layout, bool if_either) {
  const std::string_view second = layout.projector.matrix;
  const bool is_numbered = second.ends_with('2') || second.starts_with(of_projector);
  return second == layouts.back().projector.matrix || (if_either && is_numbered);
}

std::array<std::string_view, 10> names_of(const Layout& layout) {
  const auto& [camera, projector, rotation, translation] = layout;
  return {camera.matrix,    camera.distortion,    camera.width,    camera.height,
          projector.matrix, projector.distortion, projector.width, projector.height,
          rotation,         translation};
}

// The layout with projection matrices; its sizes have slipstream's names.
constexpr std::array<std::string_view, 2> projections{"camera_projection", "projector_projection"};

constexpr const char* measured_entry = "measured";
constexpr const char* depths_entry = "calibrated_depths";

bool has(const StoredEntries& entries, std::string_view name) {
  return !name.empty() && entries.contains(std::string(name));
}

/// The layout that has most of its names in the file.
const Layout& layout_of(const StoredEntries& entries) {
  const auto count = [&](const Layout& layout) -> std::ptrdiff_t {
    if (!has(entries, layout.camera.matrix) && !has(entries, layout.projector.matrix)) return 0;
    return std::ranges::count_if(names_of(layout), [&](auto name) { return has(entries, name); });
  };

  const Layout& best = *std::ranges::max_element(layouts, {}, count);
  if (count(best) > 0) return best;

  std::set<std::string_view> matrices{projections[0]};
  for (const Layout& layout : layouts) matrices.insert(layout.camera.matrix);
  throw Error(fmt::format("no camera matrix; expected one of {}", fmt::join(matrices, ", ")));
}

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

  // The lenses and the pose, mm.
  const Layout& names = layouts.front();
  put_lens(names.camera, scanner.camera);
  put_lens(names.projector, scanner.projector);
  put(names.rotation, scanner.rotation);
  put(names.translation, scanner.translation);

  if (const auto& depths = scanner.calibrated_depths) {
    put(depths_entry, Eigen::RowVector2d(depths->nearest, depths->farthest));
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

bool names_geometry(std::string_view entry) {
  const auto is_in = [&](const auto& names) { return std::ranges::count(names, entry) > 0; };
  return is_in(projections) || std::ranges::any_of(layouts, [&](const Layout& layout) {
           return is_in(names_of(layout));
         });
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
           entry.first == depths_entry || entry.second.empty();
  });

  return entries;
}

/// Sets the pose of two devices calibrated as a stereo pair of ROS: rectification_matrix turns a
/// device's frame into the rectified one, in which projection_matrix is K [I | t], t in metres.
void set_rectified_pose(const StoredEntries& entries, Scanner& scanner) {
  const auto rectified = [&](std::string_view device) {
    const auto name = [&](const char* of) { return fmt::format("{}{}", device, of); };

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
  if (has(entries, projections[0]) || has(entries, projections[1])) {
    const Size projector_size = size_of(entries, layouts.front().projector);
    const auto projector = matrix_of<3, 4>(entries, projections[1]);
    const Size camera_size = size_of(entries, layouts.front().camera);
    const auto camera = matrix_of<3, 4>(entries, projections[0]);
    return scanner_of(camera, camera_size, projector, projector_size);
  }

  // 2. Lenses and pose as entries.
  const Layout& names = layout_of(entries);
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
    scanner.photometry = photometric_calibration_of(entries);

    if (has(entries, depths_entry)) {
      const auto depths = matrix_of<1, 2>(entries, depths_entry);
      scanner.calibrated_depths = {depths[0], depths[1]};
    }

    if (has(entries, measured_entry)) scanner.measured = entries.at(measured_entry).text;
    return scanner;
  });
}

/// The entries of two files. If both name their geometry alike, the second is the projector's.
StoredEntries joined(StoredEntries first, const StoredEntries& second) {
  const bool are_alike = std::ranges::any_of(second, [&](const auto& entry) {
    return names_geometry(entry.first) && has(first, entry.first);
  });
  const bool is_complete = std::ranges::any_of(
      layouts, [&](const Layout& layout) { return has(first, layout.projector.matrix); });

  throw_if(are_alike && is_complete, "the first is a complete scanner file; name it alone");

  for (const auto& [name, entry] : second) {
    first.emplace((are_alike ? std::string(of_projector) : "") + name, entry);
  }
  return first;
}

StoredEntries entries_in(const fs::path& path) {
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
  return !has(entries, projections[0]) &&
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
