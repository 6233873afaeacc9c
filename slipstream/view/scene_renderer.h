#pragma once

#include "slipstream/view/cloud_extent.h"
#include "slipstream/view/line_renderer.h"
#include "slipstream/view/point_renderer.h"
#include "slipstream/view/view_settings.h"

namespace slipstream::view {

/// The intensities that look black and white: reflectivity 0, and that of `range.high` over the
/// brightness. Liu 2010, Eq. (3.3): reflectivity 0 has a mean of `ambient`, beta, grey levels of
/// 255.
Range grey_range(PointColour colour, const Range& range, double ambient, float brightness);

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
  /// What the colours of depth span, mm: a little more than the extent, so that its ends have
  /// colours apart.
  [[nodiscard]] Range depths() const;

  /// Whether points have the colours of their depth: asked for, or nothing else is known of them,
  /// as of a mesh without a picture.
  [[nodiscard]] bool shows_depths(PointColour asked) const {
    return asked == PointColour::depth || values_.high <= 0;
  }

  /// Into a pane of the bound framebuffer, which is cleared. `ambient`: the light in the cloud's
  /// intensities that is not the projector's, see grey_range. `pixel_ratio`: by how much lines are
  /// wider than a pixel, on a HiDPI screen.
  void draw(const ViewSettings& settings, double ambient, const Pane& pane,
            float pixel_ratio = 1) const;

 private:
  PointRenderer points_;
  LineRenderer lines_;
  CloudExtent extent_;
  Range values_;
};

}  // namespace slipstream::view
