#include <algorithm>
#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "merge/fused_model.h"
#include "python/bindings/arguments.h"
#include "python/bindings/bindings.h"
#include "python/bindings/clouds.h"
#include "python/bindings/given.h"
#include "python/bindings/scans.h"
#include "python/bindings/settings_help.h"
#include "slipstream/scan_job.h"

namespace slipstream::python {
namespace {

/// A thread-safe engine: each call takes one of its copies.
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

  /// True the first time: a stream of dark frames gives one warning.
  bool warns() { return !has_warned_.exchange(true); }

 private:
  std::atomic<bool> has_warned_ = false;
  const Engine first_;  // only serves as the original of copies
  Reused<Engine> engines_;
  Reused<HeldCloud> clouds_;
  Reused<Maps> maps_;
};

/// Frames for this engine.
BorrowedFrames borrowed_for(const SharedEngine& engine, const py::object& frames,
                            std::optional<int> bits) {
  const EngineSetup& setup = engine.setup();
  BorrowedFrames given = borrowed(frames, bits, frame_count(setup.sequence));
  require_upright(given.views.size(), setup.scanner.camera.size);
  return given;
}

// Whether no pixel gives a result. Quick otherwise, so that it costs no time of a stream.

bool is_empty(const HeldCloud& self) {
  return std::ranges::find(self.cloud.validity, Validity::valid) == self.cloud.validity.end();
}

bool is_empty(const Maps& maps, const FrameViews& frames, double minimum_modulation) {
  const double level = ((1 << frames.bits()) - 1) / 255.;  // grey levels of the frames
  return maps.modulation.width() != 0 &&
         std::ranges::none_of(maps.modulation, [&](float modulation) {
           return modulation >= minimum_modulation * level;
         });
}

/// The check's findings about frames without a result.
std::vector<Finding> reasons(Engine& engine, const FrameViews& frames) {
  const EngineSetup& setup = engine.setup();
  const Sequence sequence = merged_sequence(setup.sequence);
  const FrameViews& merged = engine.merged(frames);
  if (merged.count() != frame_count(sequence)) return {};

  std::optional<Scanner> scanner;
  if (has_geometry(setup.scanner)) scanner = setup.scanner;
  return check_frames(merged, sequence, scanner,
                      {.minimum_modulation = setup.settings.minimum_modulation,
                       .photometry = setup.scanner.photometry})
      .findings;
}

void warn_of_reasons(const char* what, Engine& engine, const FrameViews& frames) {
  const std::vector<Finding> findings = unlocked([&] { return reasons(engine, frames); });
  if (findings.empty()) warn_of("frames", {std::string(what) + "; inspect the frames"});
  for (const Finding& finding : findings) {
    warn_of("frames", {fmt::format("{}: {}", what, text_of(finding))});
  }
}

constexpr const char* no_points = "no pixel became a point";
constexpr const char* no_pattern = "no pixel shows the patterns";

void warn_if_empty(SharedEngine& engine, const FrameViews& frames, const HeldCloud& cloud) {
  if (is_empty(cloud) && engine.warns()) warn_of_reasons(no_points, *engine.engine(), frames);
}

void warn_if_empty(SharedEngine& engine, const FrameViews& frames, const Maps& maps) {
  const double minimum = engine.setup().settings.minimum_modulation;
  if (is_empty(maps, frames, minimum) && engine.warns()) {
    warn_of_reasons(no_pattern, *engine.engine(), frames);
  }
}

template <auto Compute>
auto computed(SharedEngine& engine, const py::object& frames, std::optional<int> bits) {
  const BorrowedFrames given = borrowed_for(engine, frames, bits);
  const auto made = unlocked([&] { return (engine.*Compute)(given.views); });

  warn_if_empty(engine, given.views, *made);
  return made;
}

auto cloud_and_maps(SharedEngine& engine, const py::object& frames, std::optional<int> bits) {
  const BorrowedFrames given = borrowed_for(engine, frames, bits);
  const auto made = unlocked([&] { return engine.cloud_and_maps(given.views); });

  warn_if_empty(engine, given.views, *made.first);
  return made;
}

std::string backend_for(SharedEngine& engine, const py::object& frames, std::optional<int> bits) {
  const BorrowedFrames given = borrowed_for(engine, frames, bits);
  return unlocked([&] { return engine.engine()->backend_for(given.views); });
}

std::shared_ptr<Uncertainty> uncertainty(SharedEngine& engine, const HeldCloud& cloud,
                                         const Maps& maps, const py::object& frames,
                                         std::optional<int> bits) {
  const BorrowedFrames given = borrowed_for(engine, frames, bits);

  return unlocked([&] {
    return std::make_shared<Uncertainty>(
        engine.engine()->uncertainty(cloud.cloud, maps, given.views));
  });
}

std::shared_ptr<HeldCloud> reconstructed(Given<Scan> scan, const std::string& gamma, bool fuse,
                                         bool anyway, const py::kwargs& kwargs) {
  const std::string& name = scan.name;
  const ScanJobSettings settings{.reconstruct = settings_from<ReconstructSettings>(kwargs),
                                 .gamma = gamma,
                                 .keep_refused = anyway,
                                 .fuse = fuse};

  const CheckedJob job =
      unlocked([&] { return checked_job(std::move(scan.value), settings, name); });
  refuse_or_warn(job.checked, name, anyway);

  ScanResult made = unlocked([&] { return ScanJob(settings)(job, name); });
  const auto found =
      made.checked.findings.begin() + static_cast<std::ptrdiff_t>(job.checked.findings.size());
  for (auto finding = found; finding != made.checked.findings.end(); ++finding) {
    warn_of(name, {text_of(*finding)});
  }

  // The doubts about the points are remarks of the cloud's files.
  auto result = std::make_shared<HeldCloud>();
  result->cloud = made.fused ? model_points(*made.fused).cloud : std::move(made.cloud);
  result->remarks = doubts(made.checked.findings);
  return result;
}

std::shared_ptr<Maps> decoded(const py::object& frames, const Given<Sequence>& patterns,
                              std::optional<int> bits, const py::kwargs& kwargs) {
  const Sequence& sequence = patterns.value;
  const auto settings = settings_from<ReconstructSettings>(kwargs);
  const BorrowedFrames given = borrowed(frames, bits, frame_count(sequence));

  auto maps = std::make_shared<Maps>();
  std::optional<Engine> engine;
  unlocked([&] {
    engine.emplace(
        EngineSetup{without_geometry(given.views.size(), sequence.projector), sequence, settings});
    engine->maps(given.views, *maps);
  });

  if (is_empty(*maps, given.views, settings.minimum_modulation)) {
    warn_of_reasons(no_pattern, *engine, given.views);
  }
  return maps;
}

using EngineClass = py::class_<SharedEngine>;

std::unique_ptr<SharedEngine> engine_from(const Given<Scanner>& scanner,
                                          const Given<Sequence>& sequence,
                                          const py::kwargs& kwargs) {
  const EngineSetup setup{scanner.value, sequence.value,
                          settings_from<ReconstructSettings>(kwargs)};
  return unlocked([&] { return std::make_unique<SharedEngine>(setup); });
}

void bind_clouds_and_maps(EngineClass& engine) {
  const py::arg_v bits = "bits"_a = py::none();

  engine.def("cloud", &computed<&SharedEngine::cloud>, "frames"_a, py::kw_only(), bits, R"(
      The cloud of a scan's frames.

      Args:
          frames (Frames | NDArray | typing.Sequence[NDArray]): see `Frames`.
          bits (int | None): bits per pixel; of uint16 frames by default 16.

      Returns:
          Cloud

      Raises:
          Error: if the number, size or type of the frames is wrong.

      Example:
          >>> engine.cloud(numpy.stack(list(scan.frames))).z.shape
          (120, 160)
  )");

  engine.def("maps", &computed<&SharedEngine::maps>, "frames"_a, py::kw_only(), bits, R"(
      The maps of a scan's frames.

      Args:
          frames (Frames | NDArray | typing.Sequence[NDArray]): see `Frames`.
          bits (int | None): bits per pixel; of uint16 frames by default 16.

      Returns:
          Maps

      Raises:
          Error: if the number, size or type of the frames is wrong.

      Example:
          >>> engine.maps(scan.frames).modulation.shape
          (120, 160)
  )");

  engine.def("cloud_and_maps", &cloud_and_maps, "frames"_a, py::kw_only(), bits, R"(
      Cloud and maps in one pass.

      Args:
          frames (Frames | NDArray | typing.Sequence[NDArray]): see `Frames`.
          bits (int | None): bits per pixel; of uint16 frames by default 16.

      Returns:
          tuple[Cloud, Maps]

      Raises:
          Error: if the number, size or type of the frames is wrong.

      Example:
          >>> cloud, maps = engine.cloud_and_maps(scan.frames)
  )");
}

void bind_judgements(EngineClass& engine) {
  const py::arg_v bits = "bits"_a = py::none();

  engine.def("uncertainty", &uncertainty, "cloud"_a, "maps"_a, "frames"_a, py::kw_only(), bits, R"(
      Uncertainty of each point.

      Args:
          cloud (Cloud): of the same frames.
          maps (Maps): of the same frames.
          frames (Frames | NDArray | typing.Sequence[NDArray]): see `Frames`.
          bits (int | None): bits per pixel; of uint16 frames by default 16.

      Returns:
          Uncertainty

      Raises:
          Error: if the number, size or type of the frames is wrong, or if the scanner's noise
              variance is unknown.

      Example:
          >>> engine.uncertainty(cloud, maps, scan.frames).x.shape
          (120, 160)
  )");

  engine.def("backend_for", &backend_for, "frames"_a, py::kw_only(), bits,
             R"(
      The engine that processes such frames.

      Args:
          frames (Frames | NDArray | typing.Sequence[NDArray]): see `Frames`.
          bits (int | None): bits per pixel; of uint16 frames by default 16.

      Returns:
          str: 'fused', or methods of the reference.

      Raises:
          Error: if the number, size or type of the frames is wrong.

      Example:
          >>> engine.backend_for(scan.frames)
          'fused'
  )");
}

void bind_reconstruct(py::module_& module) {
  module.def("reconstruct", &reconstructed, "scan"_a, py::kw_only(), "gamma"_a = "scanner",
             "fuse"_a = false, "anyway"_a = false,
             with_settings(reconstruct_help(), R"(
      Reconstructs a scan like `slipstream reconstruct`.

      Checks and refuses wrong frames, and warns of doubts about the points. Two cameras are matched
      or fused, three or more always fused: then the cloud is one row of points, without normals.

      Args:
          scan (Scan | str | PathLike): frames with their sequence and scanner, or their path.
          gamma (str): response correction: scanner (if present), blind (from the frames), none, or
              a gamma.
          fuse (bool): of two cameras, fuses the points that each measures with the projector.
          anyway (bool): turns a refusal into remarks of the cloud.
          {settings}

      Returns:
          Cloud

      Raises:
          Error: if a value is out of range, or if the scan is refused.
          TypeError: for an unknown keyword or a value of the wrong type.

      Example:
          >>> len(slipstream.reconstruct(scan)) == len(cloud)
          True
  )")
                 .c_str());
}

void bind_decode(py::module_& module) {
  module.def("decode", &decoded, "frames"_a, "sequence"_a, py::kw_only(), "bits"_a = py::none(),
             with_settings(reconstruct_help(), R"(
      The maps of frames, without a scanner.

      Args:
          frames (Frames | NDArray | typing.Sequence[NDArray]): see `Frames`.
          sequence (Sequence | Strategy | str): pattern sequence, or its strategy along x.
          bits (int | None): bits per pixel; of uint16 frames by default 16.
          {settings}

      Returns:
          Maps

      Raises:
          Error: if the number, size or type of the frames is wrong, or a value is out of range.
          TypeError: for an unknown keyword or a value of the wrong type.

      Example:
          >>> slipstream.decode(scan.frames, sequence).coordinate.shape
          (120, 160)
  )")
                 .c_str());
}

}  // namespace

void bind_engine(py::module_& module) {
  EngineClass engine(module, "Engine",
                     with_settings(reconstruct_help(), R"(
      Reconstructs scans of one scanner and sequence; builds tables once. Thread-safe.

      Args:
          scanner (Scanner | str | PathLike): calibration, or its file.
          sequence (Sequence | Strategy | str): pattern sequence, or its strategy along x.
          {settings}

      Raises:
          Error: if a value is out of range.
          TypeError: for an unknown keyword or a value of the wrong type.

      Example:
          >>> slipstream.Engine(scan.scanner, sequence, raw=True).cloud(scan.frames).size
          (160, 120)
  )")
                         .c_str());

  engine.def(py::init(&engine_from), "scanner"_a, "sequence"_a);

  engine.def_property_readonly(
      "scanner", [](const SharedEngine& self) { return self.setup().scanner; },
      "Scanner: calibration.");
  engine.def_property_readonly(
      "sequence", [](const SharedEngine& self) { return self.setup().sequence; },
      "Sequence: pattern sequence.");

  bind_clouds_and_maps(engine);
  bind_judgements(engine);

  bind_reconstruct(module);
  bind_decode(module);
}

}  // namespace slipstream::python
