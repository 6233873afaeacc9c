#pragma once

#include <span>
#include <string>
#include <vector>

#include "merge/fused_model.h"
#include "slipstream/scan_job.h"

// Several cameras around one projector: their points as one cloud.
namespace slipstream {

/// checked_job of one camera, or of cameras that are matched.
CheckedJob checked_camera(Scan scan, const ScanJobSettings& settings, const std::string& name);

/// The scans of a scan's cameras, each by itself; the first camera's comes first.
std::vector<Scan> scans_of_cameras(Scan scan);

/// The settings for a further camera: a box stays in the frame that it has for the first camera,
/// and an outline, which is in the first camera's picture, does not apply.
ReconstructSettings settings_for(const Scanner& camera, const Scanner& first,
                                 ReconstructSettings settings);

/// Throws Error for settings that matched cameras lack.
void require_matchable(const ReconstructSettings& settings);

/// The points that each of two cameras measures with the projector where the frames of one leave
/// the fringe order open: each camera resolves the other's, see PhaseMatcher. `matched`: the job's
/// result. With uncertainty and maps. Throws Error as PhaseMatcher does.
std::vector<ScanResult> points_by_each_other(const CheckedJob& job, const ScanResult& matched);

/// The points of cameras with the same projector as one cloud, in the first camera's frame: see
/// fuse. A camera's noise comes from its result's uncertainty.
/// Matches between cameras are not added: they come from the same phases, and would count them
/// twice. `findings`: receives one if two cameras' points lie apart; null: not looked for. Throws
/// Error if the projectors differ, or for fewer than 100 points of a camera.
FusedModel fused_cameras(std::span<const ScanResult> cameras,
                         std::vector<Finding>* findings = nullptr);

}  // namespace slipstream
