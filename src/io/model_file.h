#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "merge/fused_model.h"
#include "merge/model_surface.h"
#include "slipstream/surface.h"

namespace slipstream {

/// Throws Error unless write_model supports the file's ending or it is standard_output.
void require_model_ending(const std::filesystem::path& path);

/// Writes the points of a model, in its frame, which the file names, mm, by the file's ending:
///   .ply  binary little-endian PLY, also to standard_output: x y z nx ny nz intensity sigma
///         disagreement views red green blue; sigma and disagreement in mm, see ModelPoint;
///   .pcd, .xyz  as write_cloud: x y z intensity and the normals.
/// `remarks`: further comments, one line each; not in .xyz, which has no header.
/// Throws Error for another ending, WorldError if it cannot be written; never leaves a partial
/// file.
void write_model(const std::filesystem::path& path, const FusedModel& model,
                 const std::vector<std::string>& remarks = {});

/// A mesh for write_surface, with the grey levels of its vertices as texture.
Surface surface_of(const ModelMesh& mesh);

}  // namespace slipstream
