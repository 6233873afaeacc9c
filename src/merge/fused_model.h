#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "merge/view.h"
#include "slipstream/cloud.h"
#include "slipstream/image.h"
#include "slipstream/surface.h"

namespace slipstream {

/// A point of a model, averaged over the views that saw it; in the model's frame, mm.
struct ModelPoint {
  Eigen::Vector3f position = Eigen::Vector3f::Zero();
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  ///< unit length, outwards
  /// Standard deviation along the normal, mm: of the noise, or of the views' means if these differ
  /// by more than three times their noise.
  float sigma = 0;
  float disagreement = 0;  ///< largest distance between the means of two views, mm; 0 for one view
  float intensity = 0;     ///< grey levels of 255
  Colour colour{};
  std::uint16_t views = 0;  ///< that saw it
};

struct FusedModel {
  std::vector<ModelPoint> points{};
  float spacing = 0;      ///< of the points, mm
  bool coloured = false;  ///< whether all views have colours
  /// As Cloud::frame, of the first joined view's camera; null: the model is in that camera's frame.
  std::shared_ptr<const FramePose> frame{};
};

/// How good a model's points are.
struct ModelQuality {
  double median_sigma = 0;                      ///< mm
  std::optional<double> median_disagreement{};  ///< of points of two or more views, mm
};

ModelQuality quality_of(const FusedModel& model);

/// The points as a cloud of one row, with their normals; in the model's frame.
ModelPoints model_points(const FusedModel& model);

/// Moves a model, which is in its camera's frame, into another.
void move_to_frame(FusedModel& model, const FramePose& pose);

/// Averages the points of all views, each weighted by 1 / sigma^2, one point about every `spacing`
/// mm; 0: the median spacing of the views. The points of a view that lie off those of the others by
/// more than most stay out. `poses`: of each view in the model's frame; nullopt: left out.
FusedModel fuse(const std::vector<const View*>& views,
                const std::vector<std::optional<Eigen::Isometry3d>>& poses, float spacing = 0);

}  // namespace slipstream
