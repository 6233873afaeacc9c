#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/scan_flags.h"
#include "app/simulate_boards.h"
#include "slipstream/error/error.h"
#include "slipstream/io/file.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/mesh_file.h"
#include "slipstream/io/photometric_file.h"
#include "slipstream/io/scan_folder.h"
#include "slipstream/io/scanner_file.h"
#include "slipstream/noise/phase_noise.h"
#include "slipstream/simulate/named_scenes.h"
#include "slipstream/simulate/second_camera.h"
#include "slipstream/simulate/virtual_scanner.h"

namespace slipstream::app {
namespace fs = std::filesystem;
namespace {

struct SimulateFlags {
  std::string folder;
  std::string scene = "statue";
  std::optional<std::string> mesh;
  double mesh_size = 0;
  std::optional<double> reflectivity;
  std::vector<double> motion;
  std::optional<std::string> scanner;
  std::optional<std::string> camera;
  ScanFlags scan;
  SimulateBoardsFlags boards;
  Photometry photometry{.ambient = 5, .gamma = 1, .noise_variance = 1.55, .bits = 8, .seed = 1};
  int bits = 8;
  bool unquantised = false;
  bool second_camera = false;
};

Scanner scanner_from(const SimulateFlags& flags) {
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

Scene scene_from(const SimulateFlags& flags, const Scanner& scanner) {
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

void write_truth(const fs::path& folder, const VirtualScan& virtual_scan) {
  make_folder(folder);
  write_map(folder / "depth.tiff", virtual_scan.depth);
  write_map(folder / "coordinate.tiff", virtual_scan.coordinate);
  write_map(folder / "reflectivity.tiff", virtual_scan.reflectivity);
}

/// What a calibration of light and sensor would find, rounding included.
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

void write_scan(const fs::path& folder, ScanDescription scan, const Scanner& scanner,
                const VirtualScan& virtual_scan, const PhotometricCalibration& photometry) {
  make_folder(folder);
  scan.frames = frame_names(folder, virtual_scan.frames);
  scan.scanner = folder / "scanner.yaml";
  if (virtual_scan.frames.quantised()) scan.bits = virtual_scan.frames.bits();
  write_frames(scan.frames, virtual_scan.frames);
  write_scanner(*scan.scanner, scanner);
  write_photometric_calibration(scan.scanner, *scan.scanner, photometry);
  write_truth(folder / "truth", virtual_scan);
  write_scan_description(folder / "scan.yaml", scan);
}

/// The same scan as a second camera sees it, with noise of its own, in the folder that `scan`
/// names.
void write_second_camera(const SimulateFlags& flags, ScanDescription scan, const Scanner& first,
                         Photometry photometry) {
  const fs::path folder = *scan.second_camera;
  const Scanner second = second_scanner(first);
  const Scene scene = seen_from_second(scene_from(flags, first), first, second);
  photometry.seed = ~photometry.seed;
  scan.second_camera.reset();
  make_folder(folder);
  write_scan(
      folder, scan, second,
      take_scan(second, scene, pattern_set(scan.strategy, scan.axis, scan.light), photometry),
      photometric_truth(photometry));
}

void simulate(const SimulateFlags& flags, Output& output) {
  const Scanner scanner = scanner_from(flags);
  ScanDescription scan;
  scan.strategy = strategy_from(flags.scan, DualFrequency{});
  scan.axis = axis_from(flags.scan, Axis::x);
  scan.light = light_from(flags.scan, {});
  scan.projector = projector_from(flags.scan, scanner.projector.size);
  if (scan.projector != scanner.projector.size) {
    throw Error(fmt::format("--projector {} is not that of the scanner, {}",
                            text_of(scan.projector), text_of(scanner.projector.size)));
  }
  require_resolved(scan.strategy, length_along(scan.axis, scan.projector));
  Photometry photometry = flags.photometry;
  photometry.bits = flags.unquantised ? std::nullopt : std::optional(flags.bits);
  if (flags.boards.count) {
    simulate_boards(flags.folder, flags.boards, scanner, scan, photometry, output);
    return;
  }

  const auto start = std::chrono::steady_clock::now();
  const VirtualScan virtual_scan =
      take_scan(scanner, scene_from(flags, scanner),
                pattern_set(scan.strategy, scan.axis, scan.light), photometry);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;

  const fs::path folder = flags.folder;
  if (flags.second_camera) {
    scan.second_camera = folder / "second";
    write_second_camera(flags, scan, scanner, photometry);
  }
  write_scan(folder, scan, scanner, virtual_scan, photometric_truth(photometry));

  output.say("took {} frames of {} ({}) in {:.2f} s; the scan is in {}",
             virtual_scan.frames.count(), text_of(scanner.camera.size),
             flags.mesh.value_or(flags.scene), seconds.count(), folder.string());
  output.document = {{"scan", folder.string()},
                     {"frames", virtual_scan.frames.count()},
                     {"width", scanner.camera.size.width},
                     {"height", scanner.camera.size.height},
                     {"render_s", seconds.count()}};
}

void add_scene_flags(CLI::App& command, SimulateFlags& flags) {
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

void add_device_flags(CLI::App& command, SimulateFlags& flags) {
  const std::string group = "Devices";
  Photometry& photometry = flags.photometry;
  command
      .add_option("--scanner", flags.scanner, "scanner file to imitate; an example where not given")
      ->group(group);
  command.add_option("--camera", flags.camera, "size of the example's camera, as 640x480")
      ->group(group);
  command.add_option("--ambient", photometry.ambient, "ambient light beta, grey levels of 255")
      ->capture_default_str()
      ->group(group);
  command.add_option("--gamma", photometry.gamma, "response of projector and camera")
      ->capture_default_str()
      ->group(group);
  command.add_option("--noise", photometry.noise_variance, "sigma_w^2, grey levels^2 of 255")
      ->capture_default_str()
      ->group(group);
  command.add_option("--bits", flags.bits, "of the camera, 8 to 16")
      ->capture_default_str()
      ->group(group);
  command
      .add_flag("--unquantised", flags.unquantised,
                "64-bit float frames, neither rounded nor clipped")
      ->group(group);
  command
      .add_flag("--second-camera", flags.second_camera,
                "a second camera beyond the projector sees the scan too, into second/")
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

void add_simulate(CLI::App& program, SharedFlags& shared, Command& chosen) {
  CLI::App* command =
      program.add_subcommand("simulate", "let the virtual scanner take a scan (with ground truth)");
  const auto flags = std::make_shared<SimulateFlags>();
  command->add_option("folder", flags->folder, "where the scan goes")->required();
  add_scene_flags(*command, *flags);
  add_device_flags(*command, *flags);
  add_scan_flags(*command, flags->scan);
  add_simulate_boards_flags(*command, flags->boards);
  add_shared_flags(*command, shared);
  command->footer(
      "Example:\n  slipstream simulate scan --scene statue --strategy dual-frequency --steps 3 "
      "--high 16 --low 1");
  command->callback(
      [flags, &chosen] { chosen = [flags](Output& output) { simulate(*flags, output); }; });
}

}  // namespace slipstream::app
