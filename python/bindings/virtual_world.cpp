#include "python/bindings/virtual_world.h"

#include <array>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include "python/bindings/given.h"
#include "python/bindings/scans.h"
#include "python/bindings/settings_help.h"
#include "simulate/virtual_files.h"
#include "slipstream/named_scenes.h"
#include "slipstream/scan_files.h"

namespace slipstream::python {
namespace {

py::object simulated(Given<Sequence> patterns, const std::optional<fs::path>& path,
                     const py::kwargs& kwargs) {
  Sequence& sequence = patterns.value;

  // 1. The virtual world, whose projector must be the sequence's.
  Keywords keywords(kwargs);
  const VirtualWorld world = world_from(keywords);
  keywords.require_none_left();

  const Size projector = world.scanner.projector.size;
  if (sequence.projector == Size{}) sequence.projector = projector;
  if (sequence.projector != projector) throw Error("the sequence belongs to another projector");

  // 2. Renders the frames.
  VirtualScan taken = unlocked([&] {
    require_shown(sequence);
    VirtualScan made =
        take_scan(world.scanner, world.scene, pattern_set(sequence), world.photometry);
    if (path) save_virtual_scan(*path, sequence, world, made);
    return made;
  });

  // 3. The scan and its ground truth.
  Scan scan = merged({.frames = std::move(taken.frames),
                      .sequence = sequence,
                      .scanner = as_calibrated(world),
                      .exposures = sequence.exposures});

  return results("scan"_a = std::move(scan), "depth"_a = array_from(std::move(taken.depth)),
                 "coordinate"_a = array_from(std::move(taken.coordinate)),
                 "reflectivity"_a = array_from(std::move(taken.reflectivity)));
}

}  // namespace

VirtualWorld world_from(Keywords& keywords) {
  WorldSettings settings;
  std::optional<Given<Scanner>> scanner;
  std::optional<MeasuredResponse> response;
  std::array<double, 3> step{};
  double turn = 0;

  keywords.take("scene", settings.scene, "mesh", settings.mesh, "scanner", scanner, "camera",
                settings.camera, "step", step, "turn", turn, "world", settings.world, "response",
                response);
  take_described(keywords, settings);

  if (scanner) settings.scanner = scanner->value;
  if (response) settings.response = response->response;

  // The motion between frames: a step in mm and a turn about the y axis, given in degrees.
  settings.motion.step = Eigen::Vector3d(step.data());
  settings.motion.turn.y() = turn * std::numbers::pi / 180;

  return virtual_world(settings);
}

std::string world_help() {
  const WorldSettings usual;

  return keyword_help("scene", "str", usual.scene, "see `scene_names`") +
         keyword_help("mesh", "str | PathLike | None", usual.mesh,
                      "mesh file that replaces the scene") +
         keyword_help("camera", "tuple[int, int]", usual.camera, "width and height, pixels") +
         keyword_help("step", "typing.Sequence[float]", std::array<double, 3>{},
                      "motion per frame, mm") +
         keyword_help("turn", "float", 0., "about the vertical axis per frame, degrees") +
         keyword_help("world", "str", usual.world, "see `world_names`") +
         keyword_help("response", "Response | None", std::optional<MeasuredResponse>(),
                      "from pattern values to light; default: the world's") +
         described_help(usual);
}

void bind_virtual_world(py::module_& module) {
  module.def("simulate", &simulated, "sequence"_a, "path"_a = py::none(),
             with_settings(world_help(), R"(
      Simulates a scan, with the truth.

      Args:
          sequence (Sequence | Strategy | str): pattern sequence, or its strategy along x.
          path (str | PathLike | None): folder or recording (.slip) to write.
          scanner (Scanner | str | PathLike | None, default None): calibration, or its file; None:
              `example_scanner(camera)`.
          {settings}

      Returns:
          SimpleNamespace: scan and truth.
              scan (Scan): with the true scanner.
              depth (NDArray[float64]): mm, rows x columns.
              coordinate (NDArray[float64]): 0 to 1, rows x columns.
              reflectivity (NDArray[float64]): 0 to 1, rows x columns.

      Raises:
          Error: if a value is out of range.
          WorldError: if the path cannot be written.
          TypeError: for an unknown keyword or a value of the wrong type.

      Example:
          >>> slipstream.simulate(sequence, scene="board", camera=(64, 48)).depth.shape
          (48, 64)
  )")
                 .c_str());

  module.def("scene_names", &scene_names, R"(
      Scenes of the virtual world.

      Returns:
          list[str]

      Example:
          >>> "statue" in slipstream.scene_names()
          True
  )");

  module.def("world_names", &world_names, R"(
      Names of virtual worlds (light, optics and sensor).

      Returns:
          list[str]

      Example:
          >>> "bench" in slipstream.world_names()
          True
  )");
}

}  // namespace slipstream::python
