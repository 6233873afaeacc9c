#include <numbers>

#include "python/bindings/keywords.h"
#include "slipstream/base/error.h"
#include "slipstream/geometry/scan.h"
#include "slipstream/simulate/mesh_file.h"
#include "slipstream/simulate/named_photometry.h"
#include "slipstream/simulate/named_scenes.h"
#include "slipstream/simulate/virtual_scan.h"

namespace slipstream::python {
namespace {

py::object simulated(Sequence sequence, const std::optional<fs::path>& path,
                     const py::kwargs& given) {
  Keywords keywords(given);
  const VirtualWorld world = world_from(keywords);
  keywords.require_none_left();
  const Size projector = world.scanner.projector.size;
  if (sequence.projector == Size{}) sequence.projector = projector;
  if (sequence.projector != projector) throw Error("the sequence is of another projector");
  VirtualScan taken = unlocked([&] {
    require_shown(sequence);
    VirtualScan made =
        take_scan(world.scanner, world.scene, pattern_set(sequence), world.photometry);
    if (path) save_virtual_scan(*path, sequence, world, made);
    return made;
  });
  Scan scan = merged({.frames = std::move(taken.frames),
                      .sequence = sequence,
                      .scanner = as_calibrated(world),
                      .exposures = sequence.exposures});
  return results("scan"_a = std::move(scan), "depth"_a = array_from(std::move(taken.depth)),
                 "coordinate"_a = array_from(std::move(taken.coordinate)),
                 "reflectivity"_a = array_from(std::move(taken.reflectivity)));
}

Photometry photometry_from(Keywords& keywords) {
  std::string world = "bench";
  std::optional<double> ambient, noise_variance;
  std::optional<MeasuredResponse> response;
  keywords.take("world", world, "ambient", ambient, "noise_variance", noise_variance, "response",
                response);
  Photometry photometry = photometry_named(world);
  keywords.take("bits", photometry.bits, "seed", photometry.seed, "rays", photometry.rays);
  photometry.ambient = ambient.value_or(photometry.ambient);
  if (response) photometry.response = response->response;
  if (noise_variance) {
    photometry.noise_variance = *noise_variance;
    photometry.physics.full_well = photometry.physics.row_noise = 0;
  }
  return photometry;
}

}  // namespace

VirtualWorld world_from(Keywords& keywords) {
  std::string scene = "statue";
  std::optional<Scanner> scanner;
  std::optional<fs::path> mesh;
  std::optional<double> reflectivity;
  Size camera{640, 480};
  std::array<double, 3> step{};
  double turn = 0;
  keywords.take("scene", scene, "mesh", mesh, "scanner", scanner, "camera", camera, "reflectivity",
                reflectivity, "step", step, "turn", turn);
  VirtualWorld world{.scanner = scanner ? *scanner : example_scanner(camera),
                     .photometry = photometry_from(keywords)};
  world.scene =
      mesh ? scene_with_mesh(read_mesh(*mesh), world.scanner) : scene_named(scene, world.scanner);
  const Motion motion{.step = Eigen::Vector3d(step.data()),
                      .turn = {0, turn * std::numbers::pi / 180, 0},
                      .centre = working_volume(world.scanner).centre};
  for (Body& body : world.scene) {
    if (reflectivity) body.texture = uniform_texture(*reflectivity);
    if (!body.fixed) body.motion = motion;
  }
  return world;
}

void bind_virtual_world(py::module_& module) {
  module.def("simulate", &simulated, "sequence"_a, "path"_a = py::none(),
             "What the virtual scanner sees of patterns, a `scan`, and what was there: depth (mm), "
             "coordinate and reflectivity; into a folder too, or a recording (.slip).");
  module.def("scene_names", &scene_names, "Scenes of the virtual world.");
  module.def("world_names", &world_names, "Worlds, by how light, optics and sensor are.");
}

}  // namespace slipstream::python
