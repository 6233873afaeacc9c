#include "app/virtual_flags.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "app/scan_flags.h"
#include "slipstream/error/error.h"
#include "slipstream/io/mesh_file.h"
#include "slipstream/io/scanner_file.h"
#include "slipstream/noise/phase_noise.h"
#include "slipstream/simulate/named_scenes.h"

namespace slipstream::app {
namespace {

void add_scene_flags(CLI::App& command, VirtualFlags& flags) {
  const std::string group = "Scene";
  command.add_option("--scene", flags.scene, fmt::format("{}", fmt::join(scene_names(), ", ")))
      ->capture_default_str()
      ->group(group);
  command
      .add_option("--mesh", flags.mesh, "a PLY or OBJ mesh (Y up, facing +Z) instead of a scene")
      ->group(group);
  command
      .add_option("--mesh-size", flags.mesh_size, "its largest side, mm; fills the view where 0")
      ->capture_default_str()
      ->group(group);
  command.add_option("--reflectivity", flags.reflectivity, "alpha of every surface, 0 to 1")
      ->group(group);
  command.add_option("--motion", flags.motion, "motion from frame to frame: X Y Z, mm")
      ->expected(3)
      ->group(group);
}

void add_device_flags(CLI::App& command, VirtualFlags& flags, const std::string& gamma_flag) {
  const std::string group = "Devices";
  Photometry& photometry = flags.photometry;
  command.add_option("--camera", flags.camera, "size of the example's camera, as 640x480")
      ->group(group);
  command.add_option("--ambient", photometry.ambient, "ambient light beta, grey levels of 255")
      ->capture_default_str()
      ->group(group);
  command.add_option(gamma_flag, photometry.gamma, "response of projector and camera")
      ->capture_default_str()
      ->group(group);
  command.add_option("--noise", photometry.noise_variance, "sigma_w^2, grey levels^2 of 255")
      ->capture_default_str()
      ->group(group);
  command.add_option("--bits", flags.bits, "of the camera, 8 to 16")
      ->capture_default_str()
      ->group(group);
  command.add_option("--seed", photometry.seed, "of the noise")
      ->capture_default_str()
      ->group(group);
  command
      .add_option("--rays", photometry.rays,
                  "rays of each pixel, 1 to 256: more put edges truer and take longer")
      ->capture_default_str()
      ->group(group);
}

}  // namespace

void add_virtual_flags(CLI::App& command, VirtualFlags& flags, const std::string& gamma_flag) {
  add_scene_flags(command, flags);
  add_device_flags(command, flags, gamma_flag);
}

Scanner virtual_scanner(const VirtualFlags& flags) {
  if (flags.scanner && flags.camera) {
    throw Error(
        "--scanner and --camera exclude each other; the scanner file says the camera's size");
  }
  if (!flags.scanner) {
    return example_scanner(flags.camera ? size_from(*flags.camera, "--camera") : Size{640, 480});
  }
  Scanner scanner = read_scanner(*flags.scanner);
  require_valid(scanner);
  return scanner;
}

PhotometricCalibration photometric_truth(const Photometry& photometry) {
  double variance = photometry.noise_variance;
  if (photometry.bits) {
    const double step = 255.0 / ((1 << *photometry.bits) - 1);
    variance += quantisation_variance * step * step;
  }
  PhotometricCalibration truth{.ambient = photometry.ambient, .noise_variance = {}};
  if (variance > 0) truth.noise_variance = variance;
  return truth;
}

Scene virtual_scene(const VirtualFlags& flags, const Scanner& scanner) {
  Scene scene = flags.mesh ? scene_with_mesh(read_mesh(*flags.mesh), scanner, flags.mesh_size)
                           : scene_named(flags.scene, scanner);
  if (flags.reflectivity && !(*flags.reflectivity >= 0 && *flags.reflectivity <= 1)) {
    throw Error(fmt::format("--reflectivity {} is out of range; 0 to 1", *flags.reflectivity));
  }
  for (Body& body : scene) {
    if (flags.reflectivity) body.texture = uniform_texture(*flags.reflectivity);
    if (!flags.motion.empty()) body.motion = Eigen::Vector3d(flags.motion.data());
  }
  return scene;
}

}  // namespace slipstream::app
