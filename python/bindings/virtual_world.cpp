#include "python/bindings/virtual_world.h"

#include <numbers>

#include "python/bindings/arrays.h"
#include "python/bindings/bindings.h"
#include "slipstream/error/error.h"
#include "slipstream/io/mesh_file.h"
#include "slipstream/io/virtual_scan.h"
#include "slipstream/scan/scan.h"
#include "slipstream/simulate/named_photometry.h"
#include "slipstream/simulate/named_scenes.h"

namespace slipstream::python {
namespace {
namespace fs = std::filesystem;

/// What the virtual scanner took, and the world that it took it in.
struct TakenScan {
  VirtualWorld world;
  Sequence sequence;
  VirtualScan truth;
  Scan scan;  ///< several exposures merged
};

std::shared_ptr<TakenScan> taken(const Sequence& sequence, const py::kwargs& given) {
  Keywords keywords(given);
  VirtualWorld world = world_from(keywords);
  keywords.require_none_left();
  const py::gil_scoped_release release;
  auto made = std::make_shared<TakenScan>();
  Sequence shown = sequence;
  if (shown.projector == Size{}) shown.projector = world.scanner.projector.size;
  if (shown.projector != world.scanner.projector.size) {
    throw Error("projector " + text_of(shown.projector) + " is not that of the scanner, " +
                text_of(world.scanner.projector.size));
  }
  require_shown(shown);
  made->truth = take_scan(world.scanner, world.scene, pattern_set(shown), world.photometry);
  made->scan = merged({.frames = made->truth.frames,
                       .sequence = shown,
                       .scanner = as_calibrated(world),
                       .exposures = shown.exposures});
  made->world = std::move(world);
  made->sequence = std::move(shown);
  return made;
}

template <class Class, class Member>
void add_truth(Class& bound, const char* name, Member member, const char* help) {
  bound.def_property_readonly(
      name,
      [member](const py::object& self) {
        return array_of(self.cast<const TakenScan&>().truth.*member, self);
      },
      help);
}

}  // namespace

VirtualWorld world_from(Keywords& keywords) {
  std::string scene = "statue", world = "bench";
  std::optional<Scanner> scanner;
  std::optional<Size> camera;
  std::optional<fs::path> mesh;
  std::optional<double> ambient, noise_variance, reflectivity;
  std::optional<MeasuredResponse> response;
  std::array<double, 3> step{};
  double turn = 0;
  keywords.take("scene", scene);
  keywords.take("mesh", mesh);
  keywords.take("world", world);
  keywords.take("scanner", scanner);
  keywords.take("camera", camera);
  keywords.take("ambient", ambient);
  keywords.take("noise_variance", noise_variance);
  keywords.take("reflectivity", reflectivity);
  keywords.take("response", response);
  keywords.take("step", step);
  keywords.take("turn", turn);
  if (scanner && camera) throw Error("the scanner says the camera's size; give one of both");
  VirtualWorld made{
      .scanner = scanner ? *scanner : example_scanner(camera.value_or(Size{640, 480})),
      .photometry = photometry_named(world)};
  Photometry& photometry = made.photometry;
  photometry.bits = 8;
  keywords.take("bits", photometry.bits);
  keywords.take("seed", photometry.seed);
  keywords.take("rays", photometry.rays);
  photometry.ambient = ambient.value_or(photometry.ambient);
  if (response) photometry.response = response->response;
  if (noise_variance) {
    photometry.noise_variance = *noise_variance;
    photometry.physics.full_well = photometry.physics.row_noise = 0;
  }
  made.scene =
      mesh ? scene_with_mesh(read_mesh(*mesh), made.scanner) : scene_named(scene, made.scanner);
  const Motion motion{.step = Eigen::Vector3d(step.data()),
                      .turn = {0, turn * std::numbers::pi / 180, 0},
                      .centre = working_volume(made.scanner).centre};
  for (Body& body : made.scene) {
    if (reflectivity) body.texture = uniform_texture(*reflectivity);
    if (!body.fixed) body.motion = motion;
  }
  return made;
}

void bind_virtual_world(py::module_& module) {
  using Class = py::class_<TakenScan, std::shared_ptr<TakenScan>>;
  Class scan(module, "VirtualScan", "A scan of the virtual world, and what was really there.");
  scan.def_readonly("scan", &TakenScan::scan);
  add_truth(scan, "depth", &VirtualScan::depth, "mm; NaN without a surface.");
  add_truth(scan, "coordinate", &VirtualScan::coordinate,
            "Projector coordinate that lights it; NaN in shadow.");
  add_truth(scan, "reflectivity", &VirtualScan::reflectivity, "0 without a surface.");
  scan.def(
          "save",
          [](const TakenScan& of, const fs::path& path) {
            save_virtual_scan(path, of.sequence, of.world, of.truth);
          },
          py::arg("path"), py::call_guard<py::gil_scoped_release>(),
          "Into a folder with truth/ beside the frames, or a recording (.slip).")
      .def("__repr__", [](const TakenScan& of) {
        return py::str("<slipstream.VirtualScan of {!r}>").format(py::cast(of.scan));
      });
  module.def("simulate", &taken, py::arg("sequence"), "What the virtual scanner sees of patterns.");
  module.def("scene_names", &scene_names, "Scenes of the virtual world.");
  module.def("world_names", &world_names, "Worlds by how their light, optics and sensor are.");
}

}  // namespace slipstream::python
