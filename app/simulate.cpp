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
#include "app/virtual_flags.h"
#include "slipstream/error/error.h"
#include "slipstream/io/file.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/photometric_file.h"
#include "slipstream/io/scan_folder.h"
#include "slipstream/io/scanner_file.h"
#include "slipstream/simulate/second_camera.h"
#include "slipstream/simulate/virtual_scanner.h"

namespace slipstream::app {
namespace fs = std::filesystem;
namespace {

struct SimulateFlags {
  std::string folder;
  VirtualFlags devices;
  ScanFlags scan;
  SimulateBoardsFlags boards;
  bool unquantised = false;
  bool second_camera = false;
};

void write_truth(const fs::path& folder, const VirtualScan& virtual_scan) {
  make_folder(folder);
  write_map(folder / "depth.tiff", virtual_scan.depth);
  write_map(folder / "coordinate.tiff", virtual_scan.coordinate);
  write_map(folder / "reflectivity.tiff", virtual_scan.reflectivity);
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
  const Scene scene = seen_from_second(virtual_scene(flags.devices, first), first, second);
  photometry.seed = ~photometry.seed;
  scan.second_camera.reset();
  make_folder(folder);
  write_scan(
      folder, scan, second,
      take_scan(second, scene, pattern_set(scan.strategy, scan.axis, scan.light), photometry),
      photometric_truth(photometry));
}

void simulate(const SimulateFlags& flags, Output& output) {
  const Scanner scanner = virtual_scanner(flags.devices);
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
  Photometry photometry = flags.devices.photometry;
  photometry.bits = flags.unquantised ? std::nullopt : std::optional(flags.devices.bits);
  if (flags.boards.count) {
    if (flags.second_camera) throw Error("--second-camera is of a scene; --boards takes none");
    simulate_boards(flags.folder, flags.boards, scanner, scan, photometry, output);
    return;
  }

  const auto start = std::chrono::steady_clock::now();
  const VirtualScan virtual_scan =
      take_scan(scanner, virtual_scene(flags.devices, scanner),
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
             flags.devices.mesh.value_or(flags.devices.scene), seconds.count(), folder.string());
  output.document = {{"scan", folder.string()},
                     {"frames", virtual_scan.frames.count()},
                     {"width", scanner.camera.size.width},
                     {"height", scanner.camera.size.height},
                     {"render_s", seconds.count()}};
}

void add_simulate_flags(CLI::App& command, SimulateFlags& flags) {
  const std::string group = "Devices";
  command
      .add_option("--scanner", flags.devices.scanner,
                  "scanner file to imitate; an example where not given")
      ->group(group);
  command
      .add_flag("--unquantised", flags.unquantised,
                "64-bit float frames, neither rounded nor clipped")
      ->group(group);
  command
      .add_flag("--second-camera", flags.second_camera,
                "a second camera beyond the projector sees the scan too, into second/")
      ->group(group);
}

}  // namespace

void add_simulate(CLI::App& program, SharedFlags& shared, Command& chosen) {
  CLI::App* command =
      program.add_subcommand("simulate", "let the virtual scanner take a scan (with ground truth)");
  const auto flags = std::make_shared<SimulateFlags>();
  command->add_option("folder", flags->folder, "where the scan goes")->required();
  add_virtual_flags(*command, flags->devices);
  add_simulate_flags(*command, *flags);
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
