#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "app/scan_flags.h"
#include "io/recorder.h"
#include "slipstream/named_source.h"
#include "slipstream/recording.h"
#include "slipstream/virtual_world.h"

namespace slipstream::app {

/// Flags of the virtual scanner and its scene.
struct VirtualFlags : WorldSettings {
  std::optional<Eigen::Vector3d> step;                  ///< mm per frame, from --move
  Eigen::Vector3d idle_step = Eigen::Vector3d::Zero();  ///< used if no motion flag is given
  std::optional<fs::path> scanner_file;                 ///< its flag belongs to the subcommand
  std::optional<Size> camera_size;
};

/// Adds --scene, --mesh, --mesh-size, --reflectivity, --shift, --move, --turn, --vibrate,
/// --breathe, --camera, --world, --camera-bits, --seed, --rays, and --virtual-ambient, --virtual-
/// gamma and --virtual-noise, which set the simulation (--ambient-light, --gamma and
/// --noise-variance set what reconstruction assumes).
void add_virtual_flags(CLI::App& command, VirtualFlags& flags);

/// The virtual world of the flags, with the scanner file of --scanner.
VirtualWorld world_from(VirtualFlags flags);

/// The changed sequence for the scanner's projector. Throws Error for a projector of another size.
Sequence sequence_for(const SequenceChanges& changes, const Scanner& scanner);

/// Adds --exposure, --gain, --region, --pixel-format, --packet-size, --feature, --trigger and
/// --strobe.
void add_camera_flags(CLI::App& command, CameraSettings& settings);

/// Frame source and patterns; `world` is set by request_from.
struct SourceFlags : SourceRequest {
  VirtualFlags virtual_scanner;
};

/// Adds the flags of camera, patterns, --marker if `with_marker`, and the virtual scanner.
void add_source_flags(CLI::App& command, SourceFlags& flags, bool with_marker);

void add_limit_flag(CLI::App& command, FileLimit& limit);

/// Whether the source is neither virtual nor a replay.
bool is_camera(const SourceRequest& request);

/// Throws Error unless the source is a camera of grey pictures, which can see a monitor.
void require_sees_monitor(const SourceRequest& request, int monitor);

/// The pictures of a sequence, for a projector driven by this program, which needs no marker.
std::vector<Image<std::uint8_t>> pictures_to_show(Sequence sequence);

/// The request, with the virtual world if the source is virtual. Throws Error for a pixel format
/// without a camera.
SourceRequest request_from(const SourceFlags& flags);

/// Opens the source and prints its warning and the camera nodes set.
NamedSource open(SourceRequest request, Output& output);

/// Warns if the source's state has changed since the last call.
std::function<void()> news_of(const FrameSource& source, Output& output);

}  // namespace slipstream::app
