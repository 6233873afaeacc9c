#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <CLI/App.hpp>
#include <Eigen/Core>

#include "app/scan_flags.h"
#include "slipstream/geometry/scanner.h"
#include "slipstream/simulate/virtual_world.h"

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
  std::optional<std::string> scanner;  ///< file; its flag is the subcommand's own
  std::optional<std::string> camera;   ///< "640x480"
  std::string world = "bench";
  // What is other than in that world.
  std::optional<double> ambient, noise_variance;
  std::optional<std::string> response;  ///< as response_named has it
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

/// What the flags say that the scanner's projector shows. Throws Error for one of another size.
Sequence sequence_for(const ScanFlags& flags, const Scanner& scanner);

}  // namespace slipstream::app
