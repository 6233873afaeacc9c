#include "check/scanner_faults.h"

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

}  // namespace

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
