#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <CLI/App.hpp>
#include <Eigen/Core>

#include "slipstream/devices/named_source.h"

namespace slipstream::app {

/// The flags that say what the virtual scanner is and sees.
struct VirtualFlags {
  std::string scene = "statue";
  std::optional<std::string> mesh;
  double mesh_size = 0;
  std::optional<double> reflectivity;
  std::vector<double> shift;                              ///< empty, or X Y Z, as the next
  std::vector<double> motion;                             ///< empty, or X Y Z
  Eigen::Vector3d idle_motion = Eigen::Vector3d::Zero();  ///< where no flag says how it moves
  double turn = 0;                                        ///< degrees
  std::vector<double> vibration;  ///< empty, or amplitude and period, as the next
  std::vector<double> breathing;
  std::optional<std::filesystem::path> scanner;  ///< file; its flag is the subcommand's own
  std::optional<Size> camera;
  std::string world = "bench";
  // What is other than in that world.
  std::optional<double> ambient, noise_variance;
  std::optional<Response> response;
  std::optional<int> rays;
  int bits = 8;
  std::uint64_t seed = 1;
};

/// Adds --scene, --mesh, --mesh-size, --reflectivity, --shift, --move, --turn, --vibrate,
/// --breathe, --camera, --world, --camera-bits, --seed, --rays, and --virtual-ambient,
/// --virtual-gamma and --virtual-noise: what is simulated, where --ambient, --gamma and
/// --noise-variance are what is reckoned with.
void add_virtual_flags(CLI::App& command, VirtualFlags& flags);

/// Of the scanner that --scanner names, else the example with a camera of that size, with the
/// scene, the light and the camera that the flags say.
VirtualWorld world_from(const VirtualFlags& flags);

/// The sequence for the scanner's projector, with those changes. Throws Error for a projector of
/// another size.
Sequence sequence_for(const SequenceChanges& changes, const Scanner& scanner);

/// Adds --exposure, --gain, --region, --pixel-format, --trigger and --packet-size.
void add_camera_flags(CLI::App& command, CameraSettings& settings);

/// Where frames come from and what they show, with the world that `virtual` is.
struct SourceFlags {
  SourceRequest request;
  VirtualFlags world;
};

/// What the flags ask for, with the virtual world where the source is that. Throws Error for a
/// camera's pixel format where the source is none.
SourceRequest request_from(const SourceFlags& flags);

}  // namespace slipstream::app
