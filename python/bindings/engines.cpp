#include "python/bindings/engines.h"

#include <algorithm>

#include "python/bindings/bindings.h"
#include "python/bindings/keywords.h"
#include "python/bindings/scans.h"
#include "slipstream/photometry/gamma_choice.h"
#include "slipstream/reconstruct/epipolar_check.h"
#include "slipstream/reconstruct/phase_matcher.h"
#include "slipstream/strategy/registry.h"

namespace slipstream::python {

std::shared_ptr<HeldCloud> SharedEngine::cloud(const FrameViews& frames) {
  std::shared_ptr<HeldCloud> cloud = free_cloud();
  engine()->cloud(frames, cloud->fresh());
  return cloud;
}

std::shared_ptr<Maps> SharedEngine::maps(const FrameViews& frames) {
  std::shared_ptr<Maps> maps = free_maps();
  engine()->maps(frames, *maps);
  return maps;
}

std::pair<std::shared_ptr<HeldCloud>, std::shared_ptr<Maps>> SharedEngine::cloud_and_maps(
    const FrameViews& frames) {
  std::pair made(free_cloud(), free_maps());
  engine()->cloud_and_maps(frames, made.first->fresh(), *made.second);
  return made;
}

std::shared_ptr<Uncertainty> SharedEngine::uncertainty(const HeldCloud& cloud, const Maps& maps,
                                                       const FrameViews& frames) {
  return std::make_shared<Uncertainty>(engine()->uncertainty(cloud.cloud, maps, frames));
}

namespace {

/// Calls `compute(views)` without the interpreter's lock.
template <class Compute>
auto computed(const py::object& frames, std::optional<int> bits, const Compute& compute) {
  const BorrowedFrames given = borrowed(frames, bits);
  const py::gil_scoped_release release;
  return compute(given.views);
}

/// The cloud of a scan as the program makes it: see reconstruct of the module.
std::shared_ptr<HeldCloud> reconstructed(Scan scan, const std::string& gamma, bool anyway,
                                         const ReconstructSettings& settings) {
  auto result = std::make_shared<HeldCloud>();
  const bool two_cameras = !scan.further_cameras.empty();
  EngineSetup setup;
  CheckedScan checked;
  {
    const py::gil_scoped_release release;
    (void)choose_response(scan, gamma);
    setup = setup_for(scan, settings);
    two_cameras ? require_valid(setup) : require_reconstructible(setup);
    checked = check_and_repair(scan, {.minimum_modulation = settings.minimum_modulation});
  }
  refuse_or_warn(checked, "scan", anyway);
  const py::gil_scoped_release release;
  if (!checked.repairs.empty()) (void)choose_response(scan, gamma);
  setup.scanner.photometry.response = scan.scanner->photometry.response;
  result->remarks = doubts(checked.findings);
  Maps maps;
  if (two_cameras) {
    setup.scanner.photometry.response.reset();  // two cameras match whatever phase is shown
    const Scan& second = scan.further_cameras.front();
    const PhaseMatcher match(setup.scanner, setup_for(second).scanner, setup.sequence, settings);
    result->cloud = match(scan.frames, second.frames).cloud;
  } else if (!scan.other_axis.empty()) {
    Engine(setup).cloud_and_maps(scan.frames, result->cloud, maps);
    check_epipolar(setup, scan.other_axis.front(), maps, result->cloud);
  } else {
    Engine(setup).cloud(scan.frames, result->cloud);
  }
  return result;
}

/// Without a scanner.
std::shared_ptr<Maps> decoded(const py::object& frames, const Sequence& sequence,
                              std::optional<int> bits, const py::kwargs& given) {
  const ReconstructSettings settings = reconstruct_settings(given);
  return computed(frames, bits, [&](const FrameViews& views) {
    SharedEngine engine({without_geometry(views.size(), sequence.projector), sequence, settings});
    return engine.maps(views);
  });
}

template <auto Compute>
auto bound() {
  return [](SharedEngine& engine, const py::object& frames, std::optional<int> bits) {
    return computed(frames, bits,
                    [&](const FrameViews& views) { return (engine.*Compute)(views); });
  };
}

}  // namespace

void bind_engine(py::module_& module) {
  const auto frames = py::arg("frames");
  const py::arg_v bits = py::arg("bits") = py::none();
  py::class_<SharedEngine>(
      module, "Engine",
      "Frames to clouds and maps, for one scanner and sequence: tables are built once and memory "
      "is used again. Frames are one array frames x rows x columns, a list of arrays, or "
      "Scan.frames, and are not copied. Any number of threads may use it.")
      .def(py::init([](const Scanner& scanner, const Sequence& sequence, const py::kwargs& given) {
             const EngineSetup setup{scanner, sequence, reconstruct_settings(given)};
             const py::gil_scoped_release release;
             return std::make_unique<SharedEngine>(setup);
           }),
           py::arg("scanner"), py::arg("sequence"))
      .def("cloud", bound<&SharedEngine::cloud>(), frames, py::kw_only(), bits,
           "The cloud of a scan's frames.")
      .def("maps", bound<&SharedEngine::maps>(), frames, py::kw_only(), bits,
           "What they say before geometry.")
      .def("cloud_and_maps", bound<&SharedEngine::cloud_and_maps>(), frames, py::kw_only(), bits,
           "Both in one pass.")
      .def(
          "uncertainty",
          [](SharedEngine& engine, const HeldCloud& cloud, const Maps& maps, const py::object& of,
             std::optional<int> of_bits) {
            return computed(of, of_bits, [&](const FrameViews& views) {
              return engine.uncertainty(cloud, maps, views);
            });
          },
          py::arg("cloud"), py::arg("maps"), frames, py::kw_only(), bits,
          "How sure each point is, of the frames that cloud and maps were made of.")
      .def("backend_for", bound<&SharedEngine::backend_for>(), frames, py::kw_only(), bits,
           "What computes such frames: 'fused', or methods of the reference engine.")
      .def_property_readonly("scanner", [](const SharedEngine& of) { return of.setup().scanner; })
      .def_property_readonly("sequence", [](const SharedEngine& of) { return of.setup().sequence; })
      .def("__repr__", [](const SharedEngine& of) {
        return "<slipstream.Engine for " + text_of(of.setup().scanner.camera.size) + ", " +
               label_of(of.setup().sequence.strategy) + ">";
      });
  module.def(
      "reconstruct",
      [](const Scan& scan, const std::string& gamma, bool anyway, const py::kwargs& given) {
        return reconstructed(scan, gamma, anyway, reconstruct_settings(given));
      },
      py::arg("scan"), py::kw_only(), py::arg("gamma") = "scanner", py::arg("anyway") = false,
      "The cloud of a scan as `slipstream reconstruct` makes it: its response chosen, its frames "
      "checked and refused where they cannot be right. Settings as an Engine's.");
  module.def("decode", &decoded, frames, py::arg("sequence"), py::kw_only(), bits,
             "The maps of frames without any scanner.");
}

}  // namespace slipstream::python
