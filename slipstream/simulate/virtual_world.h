#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "slipstream/simulate/virtual_scanner.h"

namespace slipstream {

/// A scanner, what stands before it, and how light and sensor are.
struct VirtualWorld {
  Scanner scanner{};
  Scene scene{};
  Photometry photometry{};
};

/// The world's scanner with what a calibration of light and sensor would find, rounding included,
/// and the depths that boards cover.
Scanner as_calibrated(const VirtualWorld& world);

/// "ideal", "bench", "harsh".
std::vector<std::string_view> world_names();

/// The effects that a world has or has not, by name: "shot-noise", "camera-blur" and so on.
std::vector<std::string_view> effect_names();

/// Light, optics and sensor by name, with changes after commas:
///   ideal   the equations alone, with constant noise;
///   bench   an honest lab: projector and camera of good make, in focus, a matt object;
///   harsh   all that goes wrong in a workshop, at once.
/// An effect's name puts it in as harsh has it, "no-" before it leaves it out: "ideal,shot-noise",
/// "harsh,no-gloss". Throws Error for a name that is none of these.
Photometry photometry_named(std::string_view text);

/// The same projector with a second camera like the first, beyond it and turned to the same place.
Scanner second_scanner(const Scanner& first);

/// A scene in the first camera's frame in that of the second, which shares its projector.
Scene seen_from_second(const Scene& scene, const Scanner& first, const Scanner& second);

/// The world as a second camera of the same light sees it, with noise of its own.
VirtualWorld seen_from_second(const VirtualWorld& first);

/// A virtual world by names and numbers, as flags and keywords say it.
struct WorldSettings {
  std::string scene = "statue";
  std::optional<std::filesystem::path> mesh{};  ///< in place of the scene, see scene_with_mesh
  double mesh_size = 0;
  std::optional<double> reflectivity{};             ///< of every surface
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();  ///< of every body, mm
  Motion motion{};                                  ///< of all that moves, about its own centre
  std::optional<Scanner> scanner{};                 ///< else the example with a camera of that size
  Size camera{640, 480};
  std::string world = "bench";
  // In place of what that world has:
  std::optional<double> ambient{}, noise_variance{};
  std::optional<Response> response{};
  std::optional<int> rays{};
  std::optional<int> bits = 8;
  std::uint64_t seed = 1;
};

/// Throws Error for a name that is not known and a mesh that cannot be read.
VirtualWorld virtual_world(const WorldSettings& settings);

}  // namespace slipstream
