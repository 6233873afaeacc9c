#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "merge/fused_model.h"

namespace slipstream {

/// A triangle mesh of a model: corners with the values of the points around them.
struct ModelMesh {
  std::vector<ModelPoint> vertices{};  ///< each is a corner of a triangle
  /// Indices of the corners, counter-clockwise as seen from outside.
  std::vector<std::array<std::uint32_t, 3>> triangles{};
  bool coloured = false;                     ///< whether the vertices have colours
  std::shared_ptr<const FramePose> frame{};  ///< of the model
};

/// The surface where the signed distance from the model's points, along their normals, is zero
/// (surface nets on a grid of the model's spacing). Stays open at places that no view saw.
ModelMesh mesh_of(const FusedModel& model);

}  // namespace slipstream
