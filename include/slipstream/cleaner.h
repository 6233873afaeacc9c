#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "slipstream/cloud.h"
#include "slipstream/setting.h"

namespace slipstream {

/// A box along the axes of a frame, mm: see CleanSettings::box_frame.
struct PointBox {
  std::array<double, 3> least{}, largest{};

  /// Whether a place in the box's frame, mm, is inside; faces are.
  [[nodiscard]] bool contains(const Eigen::Vector3d& place) const;

  friend bool operator==(const PointBox&, const PointBox&) = default;
};

/// A position in the camera's picture, pixels; pixel centres are at integers.
struct PictureCorner {
  double column = 0, row = 0;

  friend bool operator==(const PictureCorner&, const PictureCorner&) = default;
};

/// Which points of a cloud are removed, by their neighbours or noise, and optional further steps.
/// By default the filters of the first part are on; they only remove points.
struct CleanSettings {
  /// Maximum standard deviation of depth predicted from the noise, mm; above it a point is
  /// `low_trust`. Default: 3 % of the depth; infinity: no limit.
  std::optional<double> largest_sigma{};
  bool drop_mixed = true;     ///< points off the end of a surface
  bool drop_outliers = true;  ///< points off the surface of their neighbours
  /// Minimum pixels of a component; points in smaller ones are `small_component`. Neighbours in
  /// rows and columns are connected, but not across a depth edge. 0 keeps all.
  int smallest_component = 200;

  /// Largest error of a point's coordinate that light from other surfaces, or within its own, may
  /// cause, in standard deviations by noise; above it the point is `reflected`. 0: off. Only an
  /// Engine finds such points, by patterns with a coarse and a fine band. `reflection` judges by
  /// the picture around a pixel, and removes thin things before a surface that is lit so;
  /// `local_reflection` judges by the pixel's own surface, and keeps thin wires.
  double reflection = 0, local_reflection = 0;

  std::optional<PointBox> box{};  ///< points outside are `outside_region`
  /// Pose between the camera's frame and the box's, in either direction; null: the camera's.
  std::shared_ptr<const FramePose> box_frame{};
  /// Pixels outside are `outside_region` too: a rectangle by two opposite corners (inclusive), or
  /// an even-odd polygon by three or more. Empty: the whole picture.
  std::vector<PictureCorner> outline{};
  /// Widest gap, pixels, in a row or column between points of one surface that is filled. 0: off.
  int widest_gap = 0;
  /// Half the smoothing window, pixels: points move along their rays to the mean of their surface;
  /// edges and creases are preserved. 0: off.
  int smoothing = 0;

  /// Every filter off.
  static CleanSettings none() {
    return {.largest_sigma = std::numeric_limits<double>::infinity(),
            .drop_mixed = false,
            .drop_outliers = false,
            .smallest_component = 0};
  }

  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    visit({.name = "largest_sigma",
           .option = "largest-sigma",
           .help = "maximum standard deviation of depth predicted from the noise, mm; default: 3 % "
                   "of the depth",
           .unit = "mm",
           .least = 0,
           .above_least = true},
          self.largest_sigma);

    visit({.name = "drop_mixed", .help = "reject pixels that see two surfaces"}, self.drop_mixed);
    visit({.name = "drop_outliers", .help = "reject points off the surface of their neighbours"},
          self.drop_outliers);

    visit({.name = "smallest_component",
           .option = "smallest-component",
           .help = "minimum pixels of a connected piece; default 200",
           .unit = "pixels",
           .least = 0,
           .live = {"minimum pixels of a connected piece", "pixels", 0, 1e6}},
          self.smallest_component);

    visit({.name = "reflection",
           .option = "reflection",
           .help = "largest error that light from other surfaces may cause, in standard deviations "
                   "by noise, e.g. 5; judged by the picture around a pixel",
           .least = 0},
          self.reflection);
    visit({.name = "local_reflection",
           .option = "local-reflection",
           .help = "the same, judged by the pixel's own surface, which keeps thin wires",
           .least = 0},
          self.local_reflection);

    visit({"box", "box", "keep only points inside, mm: minimum x,y,z and maximum x,y,z"}, self.box);
    visit({"outline", "outline",
           "keep only camera pixels inside x,y,x,y: two corners of a rectangle, or a polygon"},
          self.outline);

    visit({"widest_gap", "widest-gap", "fill gaps in a surface up to this width, pixels", "pixels",
           0},
          self.widest_gap);
    visit({"smoothing", "smoothing", "half the window of edge-preserving smoothing, pixels",
           "pixels", 0, 10},
          self.smoothing);
  }

  friend bool operator==(const CleanSettings&, const CleanSettings&) = default;
};

/// Whether they reject points that other surfaces light.
inline bool rejects_reflection(const CleanSettings& settings) {
  return settings.reflection > 0 || settings.local_reflection > 0;
}

/// Throws Error for a setting out of range.
void require_valid(const CleanSettings& settings);

/// Removes points of organised clouds, see CleanSettings, with the reason as Validity: first low
/// trust, then mixed pixels and outliers together, small components, and points outside the region;
/// then fills gaps and smooths. With the modulation, detects mixed pixels by its dip at edges
/// between distant surfaces. Limits for depth edges and outliers adapt to the cloud's measured
/// noise and its distance between pixels.
///
/// The result does not depend on the number of threads. Reuses its memory: allocates nothing from
/// the second cloud of a size on. Not thread-safe.
class Cleaner {
 public:
  /// Throws Error as require_valid.
  explicit Cleaner(const CleanSettings& settings = {});
  ~Cleaner();

  /// Returns the number of points removed for each reason, and at `valid` the number of gaps
  /// filled. The cloud's Z must be NaN without a point, and positive elsewhere. `modulation`: of
  /// the cloud's pixels, grey levels of the frames; if null, all points are trusted.
  ValidityCounts operator()(Cloud& cloud, const Image<float>* modulation = nullptr,
                            const DepthNoise& noise = {});

  [[nodiscard]] const CleanSettings& settings() const { return settings_; }
  /// Whether largest_sigma is finite, so that the modulation is needed.
  [[nodiscard]] bool wants_modulation() const {
    return !settings_.largest_sigma || std::isfinite(*settings_.largest_sigma);
  }

 private:
  struct Memory;
  struct Pass;

  CleanSettings settings_;
  std::unique_ptr<Memory> memory_;
};

}  // namespace slipstream
