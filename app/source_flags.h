#pragma once

#include "app/scan_flags.h"
#include "slipstream/devices/named_source.h"

namespace slipstream::app {

/// The flags of the virtual scanner and what it sees.
struct VirtualFlags : WorldSettings {
  std::optional<Eigen::Vector3d> step;                  ///< mm from frame to frame, of --move
  Eigen::Vector3d idle_step = Eigen::Vector3d::Zero();  ///< if no flag says how it moves
  std::optional<fs::path> scanner_file;                 ///< its flag is the subcommand's own
  std::optional<Size> camera_size;
};

/// Adds --scene, --mesh, --mesh-size, --reflectivity, --shift, --move, --turn, --vibrate,
/// --breathe, --camera, --world, --camera-bits, --seed, --rays, and --virtual-ambient,
/// --virtual-gamma and --virtual-noise: what is simulated, where --ambient, --gamma and
/// --noise-variance are what reconstruction assumes.
void add_virtual_flags(CLI::App& command, VirtualFlags& flags);

/// The world of the flags, with the scanner of the file that --scanner names.
VirtualWorld world_from(VirtualFlags flags);

/// The sequence for the scanner's projector, with those changes. Throws Error for a projector of
/// another size.
Sequence sequence_for(const SequenceChanges& changes, const Scanner& scanner);

/// Adds --exposure, --gain, --region, --pixel-format, --trigger and --packet-size.
void add_camera_flags(CLI::App& command, CameraSettings& settings);

/// Where frames come from and what they show; `world` is set by request_from.
struct SourceFlags : SourceRequest {
  VirtualFlags virtual_scanner;
};

/// Adds the flags of camera, patterns, --marker if `with_marker`, and the virtual scanner.
void add_source_flags(CLI::App& command, SourceFlags& flags, bool with_marker);

/// Whether the source is neither virtual nor a replay.
bool is_camera(const SourceRequest& request);

/// What the flags ask for, with the virtual world if the source is that. Throws Error for a
/// camera's pixel format where the source is not a camera.
SourceRequest request_from(const SourceFlags& flags);

/// Opens the source and prints its warning.
NamedSource open(const SourceRequest& request, Output& output);

}  // namespace slipstream::app
