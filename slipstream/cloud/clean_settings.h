#pragma once

#include <array>
#include <limits>
#include <optional>
#include <vector>

namespace slipstream {

/// A box along the axes of the camera's frame, mm.
struct PointBox {
  std::array<double, 3> least{};
  std::array<double, 3> largest{};

  friend bool operator==(const PointBox&, const PointBox&) = default;
};

/// A place in the camera's picture, pixels; pixel centres are at integers.
struct PictureCorner {
  double column = 0;
  double row = 0;

  friend bool operator==(const PictureCorner&, const PictureCorner&) = default;
};

/// Which points of a cloud are left out because their neighbours or the noise speak against them,
/// and what else is done to it on request. By default every filter of the first part is on; none of
/// them moves a point or adds one.
struct CleanSettings {
  /// Of depth, one standard deviation as the noise predicts it, mm: a point with more is
  /// `low_trust`. By default three hundredths of its depth; infinity for no limit.
  std::optional<double> largest_sigma{};
  bool drop_mixed = true;     ///< points at the end of a surface and off it
  bool drop_outliers = true;  ///< points off the surface that their neighbours agree on
  /// Pixels: a point in a component of fewer is `small_component`. Points are connected in rows and
  /// columns, but not across a depth edge. 0 keeps all.
  int smallest_component = 200;

  std::optional<PointBox> box{};  ///< points outside are `outside_region`
  /// Pixels outside are likewise: of a rectangle by two opposite corners, both inside, or of a
  /// polygon by three and more, even-odd. Empty for the whole picture.
  std::vector<PictureCorner> outline{};
  /// Pixels: gaps as wide in a row or a column, between points of one surface, get points. 0: none.
  int widest_gap = 0;
  /// Half the width of the window, pixels, over which points are moved along their rays to the mean
  /// of their surface; edges and creases stay. 0: none.
  int smoothing = 0;

  /// Every filter off.
  static CleanSettings none() {
    return {.largest_sigma = std::numeric_limits<double>::infinity(),
            .drop_mixed = false,
            .drop_outliers = false,
            .smallest_component = 0};
  }

  friend bool operator==(const CleanSettings&, const CleanSettings&) = default;
};

/// Throws Error for a setting out of its range.
void require_valid(const CleanSettings& settings);

}  // namespace slipstream
