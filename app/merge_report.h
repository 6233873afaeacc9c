#pragma once

#include <string>
#include <vector>

#include "merge/fused_model.h"
#include "merge/joint_alignment.h"

namespace slipstream::app {

/// Writes a page about a merged model: views, overlaps, distances of each pair, loop error, and
/// pictures of the model coloured by how far the views disagree.
void write_merge_report(const std::string& path, const std::vector<std::string>& names,
                        const JointAlignment& joint, const FusedModel& model);

}  // namespace slipstream::app
