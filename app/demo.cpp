#include <cerrno>
#include <cstdlib>
#include <string>

#include "app/commands.h"
#include "app/reconstructed_scan.h"
#include "io/result_files.h"
#include "simulate/comparison.h"
#include "simulate/virtual_files.h"
#include "slipstream/engine.h"
#include "slipstream/named_scenes.h"
#include "slipstream/sequence.h"
#include "slipstream/virtual_world.h"

namespace slipstream::app {
namespace {

struct DemoFlags {
  std::string folder = "demo";
};

/// Whether `view` is part of this build and can open a window.
bool can_view() {
#ifdef SLIPSTREAM_VIEW
  return std::getenv("DISPLAY") != nullptr || std::getenv("WAYLAND_DISPLAY") != nullptr;
#else
  return false;
#endif
}

/// Says how to go on, with commands that work here: the program need not be on the path.
void say_what_next(const ResultFiles& files, const fs::path& scan, Output& output) {
  const std::string program = program_invocation_name;

  if (can_view()) {
    output.say("look at it: {} view {}", program, scan.string());
  } else {
    output.say("look at it: {}", files.preview);
  }
  output.say("do it yourself: {} reconstruct {} -o cloud.ply", program, scan.string());
}

void demo(const DemoFlags& flags, Output& output) {
  // 1. A virtual world: the example scanner, a statue, usual noise.
  const fs::path folder = flags.folder, scan = folder / "scan";
  VirtualWorld world{.scanner = example_scanner(), .photometry = photometry_named("bench")};
  world.scene = scene_named("statue", world.scanner);

  const Sequence sequence = default_sequence(world.scanner.projector.size,
                                             {.settings = {{"steps", "4"}, {"high", "32"}}});

  // 2. Scan it.
  tell_replaced(scan, output);
  output.say("the virtual scanner scanned a statue: {}", scan.string());
  const VirtualScan taken =
      take_scan(world.scanner, world.scene, pattern_set(sequence), world.photometry);
  save_virtual_scan(scan, sequence, world, taken);

  // 3. Reconstruct with the scanner as a calibration would have found it.
  Cloud cloud;
  Maps maps;
  Engine engine(as_calibrated(world), sequence);
  engine.cloud_and_maps(taken.frames, cloud, maps);
  const Uncertainty sigma = engine.uncertainty(cloud, maps, taken.frames);

  // 4. Compare with the truth, which only a virtual world knows.
  const CloudErrors errors =
      cloud_errors(cloud, sigma, maps.coordinate, sequence.strategy.layout(), taken, world);

  const ResultFiles files{.cloud = folder / "cloud.ply",
                          .depth = folder / "depth.tiff",
                          .preview = folder / "preview.png"};
  write_results(files, cloud, {});
  const PredictedRms predicted = predicted_rms(sigma);

  output.say("reconstructed a cloud of {} points; RMS error {:.2f} mm; {}", point_count(cloud),
             errors.rms, text_of(predicted));

  for (const auto& [name, path] : files.named()) {
    output.say("  {}: {}", name, path);
    output.object("files")[name] = path;
  }

  say_what_next(files, scan, output);

  output.add("scan", scan.string(), "points", point_count(cloud), "rms_mm", errors.rms,
             "predicted_mm", predicted.with_edges, "predicted_from_noise_mm", predicted.of_noise);
}

}  // namespace

void add_demo(const Commands& program) {
  const auto [command, flags] = program.add(
      demo, "demo", "scan the virtual world and reconstruct it: a self-test, and data to try");
  command.add_output("folder", flags.folder, "output folder", output_folder_type);
  command.examples({"demo && slipstream view demo/cloud.ply"});
}

}  // namespace slipstream::app
