#include "app/demo.h"

#include <string>

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

  output.say(
      "reconstructed a cloud of {} points; RMS error {:.2f} mm, predicted from noise: {:.2f} mm",
      point_count(cloud), errors.rms, errors.predicted);

  for (const auto& [name, path] : files.named()) {
    output.say("  {}: {}", name, path);
    output.object("files")[name] = path;
  }

  output.say(
      "look at it: slipstream view {0}\ndo it yourself: slipstream reconstruct {0} -o cloud.ply",
      scan.string());

  output.add("scan", scan.string(), "points", point_count(cloud), "rms_mm", errors.rms,
             "predicted_mm", errors.predicted);
}

}  // namespace

void add_demo(const Commands& program) {
  const auto [command, flags] = program.add(
      demo, "demo", "scan the virtual world and reconstruct it: a self-test, and data to try");
  command.add_output("folder", flags.folder, "output folder", output_folder_type);
  command.examples({"demo && slipstream view demo/cloud.ply"});
}

}  // namespace slipstream::app
