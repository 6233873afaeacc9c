#pragma once

#include <memory>

#include <nlohmann/json_fwd.hpp>

#include "slipstream/cloud.h"

// The frame of a mesh in glTF.
namespace slipstream {

/// The node of mesh 0, with the name of its frame; null: the camera's. The camera's frame is turned
/// vertex by vertex; any other keeps its axes, and the node turns z up, as robots and maps have it.
nlohmann::json gltf_node_of(const FramePose* frame);

/// The frame that gltf_node_of has written; null for the camera's and for files of other programs.
/// Throws Error or an exception of the JSON library if it is malformed.
std::shared_ptr<const FramePose> gltf_frame_in(const nlohmann::json& document);

}  // namespace slipstream
