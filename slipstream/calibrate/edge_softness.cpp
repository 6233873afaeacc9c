#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "slipstream/base/robust.h"
#include "slipstream/calibrate/capture_signs.h"

namespace slipstream {
namespace {

/// The picture between its pixels; none outside.
std::optional<double> grey_at(const Image<float>& picture, const Eigen::Vector2d& at) {
  const int left = static_cast<int>(std::floor(at.x())), top = static_cast<int>(std::floor(at.y()));
  if (left < 0 || top < 0 || left + 1 >= picture.width() || top + 1 >= picture.height()) {
    return std::nullopt;
  }
  const double x = at.x() - left, y = at.y() - top;
  return std::lerp(std::lerp(picture(left, top), picture(left + 1, top), x),
                   std::lerp(picture(left, top + 1), picture(left + 1, top + 1), x), y);
}

/// Standard deviation, pixels, of the Gaussian edge with that height and slope somewhere on the way
/// from one place to another; none where there is no edge to speak of.
std::optional<double> softness(const Image<float>& picture, const Eigen::Vector2d& from,
                               const Eigen::Vector2d& to) {
  constexpr double step = 0.25;       // pixels
  constexpr int across = 4;           // steps over which the slope is taken: a pixel
  constexpr double least_height = 8;  // grey levels
  const double length = (to - from).norm();
  std::vector<double> profile;
  const int steps = static_cast<int>(length / step);
  for (int i = 0; i <= steps; ++i) {
    const auto grey = grey_at(picture, from + (to - from) * (i * step / length));
    if (!grey) return std::nullopt;
    profile.push_back(*grey);
  }
  double steepest = 0;
  for (std::size_t i = across; i < profile.size(); ++i) {
    steepest = std::max(steepest, std::abs(profile[i] - profile[i - across]) / (across * step));
  }
  const auto [low, high] = std::minmax_element(profile.begin(), profile.end());
  if (profile.size() <= across || *high - *low < least_height) return std::nullopt;
  return (*high - *low) / (steepest * std::sqrt(2 * std::numbers::pi));
}

}  // namespace

bool is_soft(const EdgeSoftness& edges) {
  return edges.pixels > 1.5 && edges.spacings > 0.125;
}

EdgeSoftness edge_softness(const Image<float>& picture, const CalibrationBoard& board,
                           const std::vector<int>& places,
                           const std::vector<Eigen::Vector2d>& corners) {
  std::map<int, Eigen::Vector2d> seen;
  for (std::size_t i = 0; i < places.size(); ++i) seen.emplace(places[i], corners[i]);
  std::vector<double> widths, spacings;
  for (const auto& [place, corner] : seen) {
    const auto right = seen.find(place + 1), below = seen.find(place + board.columns);
    if (place % board.columns + 1 == board.columns) continue;
    if (right == seen.end() || below == seen.end()) continue;
    const Eigen::Vector2d along = right->second - corner, down = below->second - corner;
    std::optional<double> width;
    if (board.kind == BoardKind::circles) {
      // Out of the middle of a circle, of half a place in the row, to where paper is white.
      width = softness(picture, corner, corner + 0.4 * along);
      spacings.push_back(along.norm() / 2);
    } else {
      const Eigen::Vector2d edge = corner + along / 2;
      width = softness(picture, edge - 0.35 * down, edge + 0.35 * down);
      spacings.push_back(down.norm());
    }
    if (width) widths.push_back(*width);
  }
  if (widths.empty()) return {};
  const double width = median(std::move(widths));
  return {width, width / median(std::move(spacings))};
}

}  // namespace slipstream
