#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "slipstream/virtual_scanner.h"

namespace slipstream {

/// A scanner, a scene, light and sensor.
struct VirtualWorld {
  Scanner scanner{};
  Scene scene{};
  Photometry photometry{};
};

/// The world's scanner with an ideal calibration of light and sensor, including rounding, and with
/// the depths that boards cover.
Scanner as_calibrated(const VirtualWorld& world);

/// "ideal", "bench", "harsh".
std::vector<std::string_view> world_names();

/// Names of the optional effects: "sensor-noise", "camera-blur" and so on.
std::vector<std::string_view> effect_names();

/// Light, optics and sensor by name, followed by comma-separated changes:
///   ideal   only the equations, with constant noise;
///   bench   a realistic lab: good projector and camera, in focus, a matt object;
///   harsh   all disturbances of a workshop at once.
/// An effect's name adds it as in harsh, the prefix "no-" removes it: "ideal,sensor-noise",
/// "harsh,no-gloss". No world has those of cameras for people: "auto-exposure", "tone-curve"
/// (sRGB), "sharpening" and "jpeg". Throws Error for an unknown name.
Photometry photometry_named(std::string_view text);

/// The same projector with a further camera like the first, beyond it and aimed at the same point.
/// `number`: 2 for the second camera; those after it stand above and below, farther and farther.
Scanner second_scanner(const Scanner& first, int number = 2);

/// Transforms a scene from the first camera's frame to the second's, which shares its projector.
Scene seen_from_second(const Scene& scene, const Scanner& first, const Scanner& second);

/// The world for a further camera under the same light, with its own noise.
VirtualWorld seen_from_second(const VirtualWorld& first, int number = 2);

/// Settings of a virtual world, as in flags and keywords.
struct WorldSettings {
  std::string scene = "statue";
  std::optional<std::filesystem::path> mesh{};  ///< replaces the scene, see scene_with_mesh
  double mesh_size = 0;
  std::optional<double> reflectivity{};             ///< of every surface
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();  ///< of every body, mm
  Motion motion{};                                  ///< of all bodies not fixed, about their centre
  std::optional<Scanner> scanner{};                 ///< default: example_scanner(camera)
  Size camera{640, 480};
  std::string world = "bench";

  // Override the world's values:
  std::optional<double> ambient{}, noise_variance{};
  std::optional<Response> response{};
  std::optional<int> rays{};
  std::optional<int> bits = 8;
  std::uint64_t seed = 1;

  /// The numbers shared by flags and keywords.
  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    visit({"reflectivity", "reflectivity", "reflectivity alpha of every surface, 0 to 1", "", 0, 1},
          self.reflectivity);
    visit({"ambient", "virtual-ambient", "ambient light beta, grey levels of 255"}, self.ambient);
    visit({"noise_variance", "virtual-noise",
           "noise variance sigma_w^2, squared grey levels of 255; default: the world's"},
          self.noise_variance);
    visit({"bits", "camera-bits", "bit depth of the camera, 8 to 16"}, self.bits);
    visit({"seed", "seed", "seed of the noise"}, self.seed);
    visit({"rays", "rays", "rays per pixel at edges, 1 to 256: more are more exact and slower"},
          self.rays);
  }
};

/// Throws Error for an unknown name or an unreadable mesh.
VirtualWorld virtual_world(const WorldSettings& settings);

}  // namespace slipstream
