#include "check/scanner_faults.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include <Eigen/Core>
#include <fmt/format.h>

namespace slipstream {
namespace {

/// `up`: how far the axis may lie from the centre of the picture, share of its height.
void look_at_lens(const Lens& lens, FindingKind kind, std::string_view device, double up,
                  std::vector<Finding>& findings) {
  constexpr double across = 0.25;  // of the width
  const double x = lens.intrinsic(0, 2) / lens.size.width;
  const double y = lens.intrinsic(1, 2) / lens.size.height;

  if (std::abs(x - 0.5) <= across && std::abs(y - 0.5) <= up) return;

  findings.push_back(
      {.kind = kind,
       .what = fmt::format("the {}'s optical axis is farther from the centre of its {} picture "
                           "than {:g} % of the width or {:g} % of the height",
                           device, text_of(lens.size), 100 * across, 100 * up),
       .evidence = {{"share of the width", x}, {"share of the height", y}},
       .causes = {{CauseKind::picture_size,
                   fmt::format("a scanner file for {} pictures of another size: halved, cropped or "
                               "of the other device",
                               device)}},
       .remedies = {{fmt::format("use {} pictures of the calibrated size", device)}}});
}

/// The part of the pictures left of and above a border of one level, the same in all frames; the
/// whole along an axis without a border, or where the border begins at the other end.
template <class Views>
Size part_without_border(const Views& views, Size size) {
  const auto level = views.front()(size.width - 1, size.height - 1);
  const auto differs = [&](int column, int row) {
    return std::ranges::any_of(views, [&](const auto& view) { return view(column, row) != level; });
  };

  // Number of pixels of a column, or of a row, that differ from the border; stops at `enough`.
  Size part = size;
  const auto in_column = [&](int column, int enough) {
    int found = 0;
    for (int row = 0; row < part.height && found < enough; ++row) {
      if (differs(column, row)) ++found;
    }
    return found;
  };
  const auto in_row = [&](int row, int enough) {
    int found = 0;
    for (int column = 0; column < part.width && found < enough; ++column) {
      if (differs(column, row)) ++found;
    }
    return found;
  };

  while (part.width > 0 && in_column(part.width - 1, 1) == 0) --part.width;
  while (part.height > 0 && in_row(part.height - 1, 1) == 0) --part.height;
  if (part.width == 0 || part.height == 0) return size;

  // Half of the pixels beside the border must differ from it (real scans, cropped: 0.94). The end
  // of a dark background is not so straight.
  const int half_height = part.height / 2, half_width = part.width / 2;
  const bool is_column =
      in_column(0, 1) > 0 && in_column(part.width - 1, half_height) == half_height;
  const bool is_row = in_row(0, 1) > 0 && in_row(part.height - 1, half_width) == half_width;
  if (!is_column) part.width = size.width;
  if (!is_row) part.height = size.height;
  return part;
}

}  // namespace

std::optional<Finding> padded_pictures(const FrameViews& frames, const Lens& camera) {
  const Size size = frames.size();
  const Size part =
      frames.visit([&](const auto& views) { return part_without_border(views, size); });

  // A camera that always pads its pictures is calibrated with its axis in the part's centre. Lenses
  // are a few hundredths off: the axis must be nearer to the whole's centre by as much.
  const auto is_padded = [](int length, int whole, double axis) {
    constexpr double clearly = 0.025;  // of the width or height
    return std::abs(axis - length / 2.0) - std::abs(axis - whole / 2.0) > clearly * whole;
  };

  if (!is_padded(part.width, size.width, camera.intrinsic(0, 2)) &&
      !is_padded(part.height, size.height, camera.intrinsic(1, 2))) {
    return std::nullopt;
  }

  return Finding{
      .kind = FindingKind::off_centre_camera,
      .what =
          "the pictures end in a border of one grey level, and the camera's optical axis is in "
          "the middle of the whole, not of the rest",
      .evidence = {{"columns without the border", static_cast<double>(part.width)},
                   {"rows without the border", static_cast<double>(part.height)}},
      .causes = {{CauseKind::picture_size,
                  "pictures of a region of the sensor, padded to full size: unless it begins at "
                  "the sensor's corner, no pixel is where it was calibrated"}},
      .remedies = {{"capture whole pictures, or cut off the border and name the region with "
                    "`camera_region`"}}};
}

std::vector<Finding> check_scanner(const Scanner& scanner, bool whole_pictures) {
  std::vector<Finding> findings;

  // mm. No rig is this small, but every rig is if its file is in metres.
  constexpr double least_baseline = 3;
  const double baseline = scanner.translation.norm();
  if (baseline < least_baseline) {
    findings.push_back({.kind = FindingKind::short_baseline,
                        .severity = Severity::wrong,
                        .what = fmt::format("the baseline is below {:g} mm", least_baseline),
                        .evidence = {{"baseline", baseline, "mm", least_baseline}},
                        .causes = {{CauseKind::scanner_file, "a scanner file in metres"}},
                        .remedies = {{fmt::format("write its translation in mm: {:.4g} mm long",
                                                  1000 * baseline)}}});
  }

  // The devices of rectified pictures are apart along one axis only.
  constexpr double least_along = 0.98;
  const Eigen::Vector3d apart = scanner.translation.cwiseAbs() / baseline;
  if (scanner.rotation.isIdentity(1e-9) && apart.maxCoeff() < least_along) {
    findings.push_back(
        {.kind = FindingKind::oblique_baseline,
         .what = "the rotation is the identity, but the baseline is oblique",
         .evidence = {{"baseline's largest component", apart.maxCoeff(), "share", least_along}},
         .causes = {{CauseKind::scanner_file, "a scanner file without its rotation"}},
         .remedies = {{"write the rotation from the camera's frame to the projector's"}}});
  }

  if (whole_pictures)
    look_at_lens(scanner.camera, FindingKind::off_centre_camera, "camera", 0.25, findings);
  // Projectors throw upwards: the axis may lie at the picture's lower edge or below it.
  look_at_lens(scanner.projector, FindingKind::off_centre_projector, "projector", 1.2, findings);

  return findings;
}

}  // namespace slipstream
