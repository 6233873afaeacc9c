#pragma once

#include "slipstream/pattern/pattern_set.h"
#include "slipstream/view/cloud_extent.h"
#include "slipstream/view/line_renderer.h"
#include "slipstream/view/point_renderer.h"
#include "slipstream/view/view_settings.h"

namespace slipstream::view {

/// The light under which a cloud's intensities were seen, for its reflectivity.
struct SceneLight {
  PatternLight light;
  double ambient = 0;  ///< beta, grey levels of 255
};

/// The intensities that look black and white: reflectivity 0, and that of `range.high` over the
/// brightness. Liu 2010, Eq. (3.3): reflectivity 0 has a mean of beta.
Range grey_range(PointColour colour, const Range& range, const SceneLight& light, float brightness);

/// A part of the framebuffer, in pixels from its lower left corner.
struct Pane {
  int left = 0;
  int bottom = 0;
  Size size;
};

/// The cloud with its floor, its reflection in it and the axes.
class SceneRenderer {
 public:
  /// The cloud that is drawn from here on. `modulation`: B^c of its pixels; null where not known,
  /// and then its intensity stands in.
  void set_cloud(const PointImages& cloud, const Image<float>* modulation, PointColour colour);
  /// The floor, the axes and the colours of depth are placed by this extent.
  void set_extent(const CloudExtent& extent) { extent_ = extent; }
  [[nodiscard]] const CloudExtent& extent() const { return extent_; }

  /// Into a pane of the bound framebuffer, which is cleared. `pixel_ratio`: by how much lines are
  /// wider than a pixel, on a HiDPI screen.
  void draw(const ViewSettings& settings, const SceneLight& light, const Pane& pane,
            float pixel_ratio = 1) const;

 private:
  PointRenderer points_;
  LineRenderer lines_;
  CloudExtent extent_;
  Range values_;
};

}  // namespace slipstream::view
