#include "io/scanner_layouts.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <set>
#include <string>
#include <string_view>

#include "io/file.h"

namespace slipstream {
namespace {

std::array<std::string_view, 10> names_of(const ScannerLayout& layout) {
  const auto& [camera, projector, rotation, translation] = layout;
  return {camera.matrix,    camera.distortion,    camera.width,    camera.height,
          projector.matrix, projector.distortion, projector.width, projector.height,
          rotation,         translation};
}

}  // namespace

constinit const std::array<ScannerLayout, 15> scanner_layouts{{
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
    {{"cam_K", "cam_kc", "cam_size", ""}, {"proj_K", "proj_kc", "pro_size", ""}, "R", "T"},
    // jhdewitt/sltk.
    {{"cam_K", "cam_kc", "cam_size", ""}, {"pro_K", "pro_kc", "pro_size", ""}, "R", "T"},
    // SLMaster.
    {{"M1", "D1", "S", ""}, {"M4", "D4", "", ""}, "Rlp", "Tlp"},
    // OpenCV and MATLAB.
    {{"cameraMatrix1", "distCoeffs1", "", ""}, {"cameraMatrix2", "distCoeffs2", "", ""}, "R", "T"},
    // OpenCV's stereo_calib.
    {{"M1", "D1", "", ""}, {"M2", "D2", "", ""}, "R", "T"},
    // Scripts that call OpenCV's stereoCalibrate.
    {{"K1", "D1", "", ""}, {"K2", "D2", "", ""}, "R", "T"},
    {{"mtx1", "dist1", "", ""}, {"mtx2", "dist2", "", ""}, "R", "T"},
    {{"K1", "dist1", "", ""}, {"K2", "dist2", "", ""}, "R", "t"},
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

bool is_camera_pair(const ScannerLayout& layout, bool if_either) {
  const std::string_view second = layout.projector.matrix;
  const bool is_numbered = second.ends_with('2') || second.starts_with(of_projector);
  return second == scanner_layouts.back().projector.matrix || (if_either && is_numbered);
}

bool has(const StoredEntries& entries, std::string_view name) {
  return !name.empty() && entries.contains(std::string(name));
}

const ScannerLayout& layout_of(const StoredEntries& entries) {
  const auto count = [&](const ScannerLayout& layout) -> std::ptrdiff_t {
    if (!has(entries, layout.camera.matrix) && !has(entries, layout.projector.matrix)) return 0;
    return std::ranges::count_if(names_of(layout), [&](auto name) { return has(entries, name); });
  };

  const ScannerLayout& best = *std::ranges::max_element(scanner_layouts, {}, count);
  if (count(best) > 0) return best;

  std::set<std::string_view> matrices{projection_entries[0]};
  for (const ScannerLayout& layout : scanner_layouts) matrices.insert(layout.camera.matrix);

  // Name what could be one.
  std::string found;
  for (const auto& [name, entry] : entries) {
    if (entry.rows == 3 && entry.columns == 3) found += (found.empty() ? "" : ", ") + name;
  }
  throw Error(fmt::format("no camera matrix{}; expected one of {}",
                          found.empty() ? "" : " among its 3x3 matrices " + found,
                          fmt::join(matrices, ", ")));
}

bool names_geometry(std::string_view entry) {
  const auto is_in = [&](const auto& names) { return std::ranges::count(names, entry) > 0; };
  return is_in(projection_entries) || is_in(residual_entries) ||
         std::ranges::any_of(scanner_layouts,
                             [&](const ScannerLayout& layout) { return is_in(names_of(layout)); });
}

}  // namespace slipstream
