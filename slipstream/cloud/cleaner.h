#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "slipstream/base/setting.h"
#include "slipstream/cloud/cloud.h"
#include "slipstream/cloud/depth_rows.h"

namespace slipstream {

/// A box along the axes of the camera's frame, mm.
struct PointBox {
  std::array<double, 3> least{}, largest{};

  friend bool operator==(const PointBox&, const PointBox&) = default;
};

/// A place in the camera's picture, pixels; pixel centres are at integers.
struct PictureCorner {
  double column = 0, row = 0;

  friend bool operator==(const PictureCorner&, const PictureCorner&) = default;
};

/// Which points of a cloud are left out because neighbours or noise speak against them, and what
/// else is done on request. By default the filters of the first part are on; they only remove
/// points.
struct CleanSettings {
  /// Standard deviation of depth, as the noise predicts it, mm: a point with more is `low_trust`.
  /// By default three hundredths of the depth; infinity for no limit.
  std::optional<double> largest_sigma{};
  bool drop_mixed = true;     ///< points at the end of a surface and off it
  bool drop_outliers = true;  ///< points off the surface that their neighbours agree on
  /// Pixels: a point in a component of fewer is `small_component`. Rows and columns connect points,
  /// but not across a depth edge. 0 keeps all.
  int smallest_component = 200;

  std::optional<PointBox> box{};  ///< points outside are `outside_region`
  /// Pixels outside are `outside_region` too: of a rectangle by two opposite corners, both inside,
  /// or of an even-odd polygon by three and more. Empty for the whole picture.
  std::vector<PictureCorner> outline{};
  /// Pixels: gaps as wide in a row or a column, between points of one surface, get points. 0: none.
  int widest_gap = 0;
  /// Half the window, pixels, over which points move along their rays to the mean of their surface;
  /// edges and creases stay. 0: none.
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
           .unit = "mm",
           .least = 0,
           .above_least = true,
           .flag = "--max-sigma",
           .help = "largest standard deviation of depth, as the noise predicts it, mm; three "
                   "hundredths of the depth where not given"},
          self.largest_sigma);
    visit({.name = "drop_mixed"}, self.drop_mixed);
    visit({.name = "drop_outliers"}, self.drop_outliers);
    visit({.name = "smallest_component",
           .unit = "pixels",
           .least = 0,
           .flag = "--min-component",
           .help = "fewest pixels of a connected piece; 200 where not given",
           .live = {"fewest pixels of a connected piece", "pixels", 0, 1e6}},
          self.smallest_component);
    visit({.name = "box",
           .flag = "--box",
           .help = "only points in it, mm: least x,y,z and largest x,y,z"},
          self.box);
    visit(
        {.name = "outline",
         .flag = "--outline",
         .help = "only camera pixels in it, as x,y,x,y: two corners of a rectangle, or a polygon"},
        self.outline);
    visit({.name = "widest_gap",
           .unit = "pixels",
           .least = 0,
           .flag = "--fill",
           .help = "widest gap of a surface that gets points, pixels"},
          self.widest_gap);
    visit({.name = "smoothing",
           .unit = "pixels",
           .least = 0,
           .most = 10,
           .flag = "--smooth",
           .help = "half the window over which points move to their surface, edges kept, pixels"},
          self.smoothing);
  }

  friend bool operator==(const CleanSettings&, const CleanSettings&) = default;
};

/// Throws Error for a setting out of its range.
void require_valid(const CleanSettings& settings);

/// Leaves out points of organised clouds, see CleanSettings, each with its reason as Validity: low
/// trust first, then mixed pixels and outliers together, small components, and what is outside the
/// region; fills gaps and smooths after that. Where the modulation is known, its dip shows mixed
/// pixels at edges between surfaces far apart. Limits for depth edges and outliers follow the
/// cloud's own noise, measured from it, and the distance between pixels.
///
/// The result does not depend on the number of threads. Keeps its memory: from the second cloud of
/// a size on nothing is allocated. One thread uses it at a time.
class Cleaner {
 public:
  /// Throws Error as require_valid.
  explicit Cleaner(const CleanSettings& settings = {});
  ~Cleaner();

  /// Returns how many points each reason took, and at `valid` how many gaps got one. The cloud's Z
  /// is NaN where it has no point, and positive elsewhere. `modulation`: of the cloud's pixels,
  /// grey levels of the frames; without it all points are trusted.
  ValidityCounts operator()(Cloud& cloud, const Image<float>* modulation = nullptr,
                            const DepthNoise& noise = {});

  [[nodiscard]] const CleanSettings& settings() const { return settings_; }
  /// Whether trust by noise is asked for.
  [[nodiscard]] bool wants_modulation() const;

 private:
  struct Memory;
  struct Pass;

  CleanSettings settings_;
  std::unique_ptr<Memory> memory_;
};

}  // namespace slipstream
