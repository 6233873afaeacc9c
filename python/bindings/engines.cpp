#include "python/bindings/engines.h"

#include "slipstream/reconstruct/epipolar_check.h"
#include "slipstream/reconstruct/phase_matcher.h"
#include "slipstream/response/gamma_choice.h"

namespace slipstream::python {
namespace {

/// An engine that any number of threads may use at a time: each call takes one of its copies.
class SharedEngine {
 public:
  explicit SharedEngine(const EngineSetup& setup) : first_(setup) {}

  [[nodiscard]] const EngineSetup& setup() const { return first_.setup(); }
  std::shared_ptr<Engine> engine() { return engines_.take(first_); }

  std::shared_ptr<HeldCloud> cloud(const FrameViews& frames) {
    std::shared_ptr<HeldCloud> cloud = clouds_.take();
    engine()->cloud(frames, cloud->fresh());
    return cloud;
  }
  std::shared_ptr<Maps> maps(const FrameViews& frames) {
    std::shared_ptr<Maps> maps = maps_.take();
    engine()->maps(frames, *maps);
    return maps;
  }
  std::pair<std::shared_ptr<HeldCloud>, std::shared_ptr<Maps>> cloud_and_maps(
      const FrameViews& frames) {
    std::pair made(clouds_.take(), maps_.take());
    engine()->cloud_and_maps(frames, made.first->fresh(), *made.second);
    return made;
  }
  std::string backend_for(const FrameViews& frames) { return engine()->backend_for(frames); }

 private:
  const Engine first_;  // is copied and does nothing else
  Reused<Engine> engines_;
  Reused<HeldCloud> clouds_;
  Reused<Maps> maps_;
};

template <auto Compute>
auto computed(SharedEngine& engine, const py::object& frames, std::optional<int> bits) {
  const BorrowedFrames given = borrowed(frames, bits);
  return unlocked([&] { return (engine.*Compute)(given.views); });
}

std::shared_ptr<Uncertainty> uncertainty(SharedEngine& engine, const HeldCloud& cloud,
                                         const Maps& maps, const py::object& frames,
                                         std::optional<int> bits) {
  const BorrowedFrames given = borrowed(frames, bits);
  return unlocked([&] {
    return std::make_shared<Uncertainty>(
        engine.engine()->uncertainty(cloud.cloud, maps, given.views));
  });
}

/// A scan that was checked, into a cloud.
void reconstruct(const Scan& scan, const EngineSetup& setup, Cloud& cloud) {
  if (!scan.further_cameras.empty()) {
    const Scan& second = scan.further_cameras.front();
    const PhaseMatcher match(setup.scanner, setup_for(second).scanner, setup.sequence,
                             setup.settings);
    cloud = match(scan.frames, second.frames).cloud;
  } else if (!scan.other_axis.empty()) {
    Maps maps;
    Engine(setup).cloud_and_maps(scan.frames, cloud, maps);
    check_epipolar(setup, scan.other_axis.front(), maps, cloud);
  } else {
    Engine(setup).cloud(scan.frames, cloud);
  }
}

std::shared_ptr<HeldCloud> reconstructed(Scan scan, const std::string& gamma, bool anyway,
                                         const py::kwargs& given) {
  const auto settings = settings_from<ReconstructSettings>(given);
  const bool two_cameras = !scan.further_cameras.empty();
  EngineSetup setup;
  const CheckedScan checked = unlocked([&] {
    choose_response(scan, gamma);
    setup = setup_for(scan, settings);
    two_cameras ? require_valid(setup) : require_reconstructible(setup);
    return check_and_repair(scan, {.minimum_modulation = settings.minimum_modulation});
  });
  refuse_or_warn(checked, "scan", anyway);
  const py::gil_scoped_release release;
  if (!checked.repairs.empty()) choose_response(scan, gamma);
  auto& response = setup.scanner.photometry.response;
  response = scan.scanner->photometry.response;
  if (two_cameras) response.reset();  // they match whatever phase is shown
  auto result = std::make_shared<HeldCloud>();
  result->remarks = doubts(checked.findings);
  reconstruct(scan, setup, result->cloud);
  return result;
}

std::shared_ptr<Maps> decoded(const py::object& frames, const Sequence& sequence,
                              std::optional<int> bits, const py::kwargs& given) {
  const auto settings = settings_from<ReconstructSettings>(given);
  const BorrowedFrames of = borrowed(frames, bits);
  return unlocked([&] {
    auto maps = std::make_shared<Maps>();
    Engine engine(without_geometry(of.views.size(), sequence.projector), sequence, settings);
    engine.maps(of.views, *maps);
    return maps;
  });
}

}  // namespace

void bind_engine(py::module_& module) {
  const py::arg_v bits = "bits"_a = py::none();
  py::class_<SharedEngine> engine(
      module, "Engine",
      "Frames to clouds and maps, for one scanner and sequence: tables are built once and memory "
      "is used again. Frames are one array frames x rows x columns, a list of arrays, or "
      "Scan.frames, and are not copied. Any number of threads may use it.");
  engine.def(
      py::init([](const Scanner& scanner, const Sequence& sequence, const py::kwargs& given) {
        const EngineSetup setup{scanner, sequence, settings_from<ReconstructSettings>(given)};
        return unlocked([&] { return std::make_unique<SharedEngine>(setup); });
      }),
      "scanner"_a, "sequence"_a);
  engine.def("cloud", &computed<&SharedEngine::cloud>, "frames"_a, py::kw_only(), bits,
             "The cloud of a scan's frames.");
  engine.def("maps", &computed<&SharedEngine::maps>, "frames"_a, py::kw_only(), bits,
             "What they say before geometry.");
  engine.def("cloud_and_maps", &computed<&SharedEngine::cloud_and_maps>, "frames"_a, py::kw_only(),
             bits, "Both in one pass.");
  engine.def("uncertainty", &uncertainty, "cloud"_a, "maps"_a, "frames"_a, py::kw_only(), bits,
             "How sure each point is, of the frames that cloud and maps were made of.");
  engine.def("backend_for", &computed<&SharedEngine::backend_for>, "frames"_a, py::kw_only(), bits,
             "What computes such frames: 'fused', or methods of the reference engine.");
  add(
      engine, "scanner", [](const SharedEngine& of) { return of.setup().scanner; }, "sequence",
      [](const SharedEngine& of) { return of.setup().sequence; });
  module.def("reconstruct", &reconstructed, "scan"_a, py::kw_only(), "gamma"_a = "scanner",
             "anyway"_a = false,
             "The cloud of a scan as `slipstream reconstruct` makes it: its response chosen, its "
             "frames checked and refused where they cannot be right. Settings as an Engine's.");
  module.def("decode", &decoded, "frames"_a, "sequence"_a, py::kw_only(), bits,
             "The maps of frames without any scanner. Settings as an Engine's.");
}

}  // namespace slipstream::python
