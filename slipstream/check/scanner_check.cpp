#include <cmath>

#include <fmt/format.h>

#include "slipstream/check/scan_check.h"

namespace slipstream {
namespace {

/// Projectors throw their picture upwards: the axis may lie at its lower edge and past it.
struct Middle {
  double across = 0.3, up = 0.3;  ///< how far from the middle of the picture, shares of its sides
};

void look_at_lens(const Lens& lens, std::string_view device, const Middle& allowed,
                  std::vector<Finding>& findings) {
  const double x = lens.intrinsic(0, 2) / lens.size.width;
  const double y = lens.intrinsic(1, 2) / lens.size.height;
  if (std::abs(x - 0.5) <= allowed.across && std::abs(y - 0.5) <= allowed.up) return;
  findings.push_back(
      {.what = fmt::format("the {}'s optical axis is far from the middle of its {} picture", device,
                           text_of(lens.size)),
       .evidence = {{"share of the width", x}, {"share of the height", y}},
       .likely = fmt::format("a scanner file for {} pictures of another size: halved, cropped or "
                             "of the other device",
                             device),
       .advice = fmt::format("use the {} pictures that the scanner was calibrated with", device)});
}

}  // namespace

std::vector<Finding> check_scanner(const Scanner& scanner, bool whole_pictures) {
  std::vector<Finding> findings;
  // No camera and projector stand so near to each other; in metres all do.
  constexpr double least_baseline = 3;
  const double baseline = scanner.translation.norm();
  if (baseline < least_baseline) {
    findings.push_back({.gravity = Gravity::wrong,
                        .what = "camera and projector stand in nearly one place",
                        .evidence = {{"baseline, mm", baseline}},
                        .likely = "a scanner file in metres",
                        .advice = fmt::format("give its translation in mm: it would be {:.4g} mm",
                                              1000 * baseline)});
  }
  if (whole_pictures)
    look_at_lens(scanner.camera, "camera", {.across = 0.25, .up = 0.25}, findings);
  look_at_lens(scanner.projector, "projector", {.across = 0.25, .up = 1.2}, findings);
  return findings;
}

}  // namespace slipstream
