#include "python/bindings/engines.h"

#include <chrono>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <type_traits>

#include "python/bindings/arguments.h"
#include "python/bindings/clouds.h"
#include "python/bindings/scans.h"
#include "slipstream/gamma.h"
#include "slipstream/live_pipeline.h"
#include "slipstream/named_source.h"
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

  std::string backend_for(const FrameViews& frames) { return engine()->backend_for(frames); }

 private:
  const Engine first_;  // only serves as the original of copies
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

std::shared_ptr<HeldCloud> reconstructed(Scan scan, const std::string& gamma, bool anyway,
                                         const py::kwargs& given) {
  const ScanJobSettings settings{.reconstruct = settings_from<ReconstructSettings>(given),
                                 .gamma = gamma,
                                 .keep_refused = anyway};

  const CheckedJob job = unlocked([&] { return checked_job(std::move(scan), settings, "scan"); });
  refuse_or_warn(job.checked, "scan", anyway);

  ScanResult made = unlocked([&] { return ScanJob(settings)(job, "scan"); });
  const auto found =
      made.checked.findings.begin() + static_cast<std::ptrdiff_t>(job.checked.findings.size());
  for (auto finding = found; finding != made.checked.findings.end(); ++finding) {
    warn_of("scan", {text_of(*finding)});
  }

  // The doubts about the points are remarks of the cloud's files.
  auto result = std::make_shared<HeldCloud>();
  result->cloud = std::move(made.cloud);
  result->remarks = doubts(made.checked.findings);
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

/// A LivePipeline for Python.
class Live {
 public:
  Live(NamedSource source, const EngineSetup& setup, LiveSettings settings, py::object on_cloud)
      : on_cloud_(std::move(on_cloud)) {
    settings.on_cloud = [this](const Pooled<LiveCloud>& cloud) { take(cloud); };
    pipeline_ = std::make_unique<LivePipeline>(std::move(source.frames), setup, settings);
  }

  ~Live() {
    const py::gil_scoped_release release;  // the threads ending here may wait for the GIL
    pipeline_.reset();
  }

  void start() {
    pipeline_->start();
    told_ = false;
  }

  /// Rethrows an exception of a stage, the source or `on_cloud`, once.
  void stop() {
    unlocked([this] { pipeline_->stop(); });

    const auto failure = pipeline_->failure();
    if (failure && !std::exchange(told_, true)) std::rethrow_exception(failure);
  }

  /// Waits for the newest cloud not returned yet.
  std::shared_ptr<HeldCloud> next() {
    // Looks for Ctrl+C between short waits.
    while (!has_new()) {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (pipeline_->running()) continue;
      stop();
      if (!has_new()) throw py::stop_iteration();
    }

    return unlocked([this] {
      std::unique_lock lock(mutex_);
      const Pooled<LiveCloud> newest = std::exchange(newest_, {});
      // Copies without the mutex, which the show stage needs.
      lock.unlock();
      return copy_of(*newest);
    });
  }

  [[nodiscard]] bool running() const { return pipeline_->running(); }
  [[nodiscard]] LiveStatistics statistics() const { return pipeline_->statistics(); }

 private:
  /// Called in the thread of the show stage.
  void take(const Pooled<LiveCloud>& cloud) {
    if (!on_cloud_.is_none()) {
      std::shared_ptr<HeldCloud> copy = copy_of(*cloud);
      const py::gil_scoped_acquire acquire;
      on_cloud_(std::move(copy));
    }

    const std::lock_guard lock(mutex_);
    newest_ = cloud;
    came_.notify_all();
  }

  bool has_new() {
    const py::gil_scoped_release release;

    std::unique_lock lock(mutex_);
    return came_.wait_for(lock, std::chrono::milliseconds(20), [this] { return bool(newest_); });
  }

  std::shared_ptr<HeldCloud> copy_of(const LiveCloud& cloud) {
    std::shared_ptr<HeldCloud> copy = clouds_.take();
    copy->fresh() = cloud.cloud;
    return copy;
  }

  py::object on_cloud_;
  bool told_ = false;

  Reused<HeldCloud> clouds_;

  std::mutex mutex_;  // guards the next two
  std::condition_variable came_;
  Pooled<LiveCloud> newest_;

  std::unique_ptr<LivePipeline> pipeline_;
};

std::unique_ptr<Live> live(const std::string& name, const std::optional<Sequence>& sequence,
                           const std::optional<Scanner>& scanner, const py::object& on_cloud,
                           const py::kwargs& given) {
  // 1. The keywords; a virtual source also takes a virtual world's.
  Keywords keywords(given);
  SourceRequest request{.source = name};
  std::string indexing = "told", gamma = "scanner";
  LiveSettings settings;
  ReconstructSettings points;

  take_described(keywords, request);
  keywords.take("indexing", indexing, "gamma", gamma, "most_frames", settings.most_frames);

  if (sequence) request.sequence = changes_to(*sequence);
  if (scheme_of(name) == "virtual") request.world = world_from(keywords);
  take(keywords, points);

  keywords.require_none_left();

  // 2. Opens the source. A marker, if the patterns have one, shows where each cycle begins.
  NamedSource source = unlocked([&] { return open_source(request); });
  settings.indexing = pattern_indexing_named(source.sequence.marker ? "marker" : indexing);

  if (scanner) source.scanner = *scanner;
  if (!source.scanner) throw Error("no scanner is known for " + name + "; give it as scanner");

  // 3. The setup, with the chosen response.
  EngineSetup setup{completed(*source.scanner, "scanner", source.frames->format().size,
                              source.sequence.projector),
                    source.sequence, points};
  require_ambient_known(setup, "scanner");

  auto& response = setup.scanner.photometry.response;
  response = choose_gamma(gamma, response).response;

  return std::make_unique<Live>(std::move(source), setup, settings, on_cloud);
}

py::dict statistics_of(const Live& live) {
  const LiveStatistics of = live.statistics();
  py::dict told;

  // Only figures that are a number or a text fit into this dict.
  const auto tell = [&](const std::string& name, const auto& figure, const auto&...) {
    using Figure = std::remove_cvref_t<decltype(figure)>;
    if constexpr (std::is_arithmetic_v<Figure> || std::is_same_v<Figure, std::string>) {
      told[py::str(name)] = figure;
    }
  };

  of.for_each_figure(tell);
  of.frames.for_each_figure(tell);
  of.latency.for_each_figure(
      [&](const char* name, double ms) { tell("latency_" + std::string(name), ms); });

  return told;
}

}  // namespace

void bind_engine(py::module_& module) {
  const py::arg_v bits = "bits"_a = py::none();

  py::class_<SharedEngine> engine(module, "Engine");
  engine.def(
      py::init([](const Scanner& scanner, const Sequence& sequence, const py::kwargs& given) {
        const EngineSetup setup{scanner, sequence, settings_from<ReconstructSettings>(given)};
        return unlocked([&] { return std::make_unique<SharedEngine>(setup); });
      }),
      "scanner"_a, "sequence"_a);

  engine.def("cloud", &computed<&SharedEngine::cloud>, "frames"_a, py::kw_only(), bits);
  engine.def("maps", &computed<&SharedEngine::maps>, "frames"_a, py::kw_only(), bits);
  engine.def("cloud_and_maps", &computed<&SharedEngine::cloud_and_maps>, "frames"_a, py::kw_only(),
             bits);
  engine.def("uncertainty", &uncertainty, "cloud"_a, "maps"_a, "frames"_a, py::kw_only(), bits);
  engine.def("backend_for", &computed<&SharedEngine::backend_for>, "frames"_a, py::kw_only(), bits);

  const auto in_setup = [](auto member) {
    return [member](const SharedEngine& of) { return of.setup().*member; };
  };
  add(engine, "scanner", in_setup(&EngineSetup::scanner), "sequence",
      in_setup(&EngineSetup::sequence));

  module.def("reconstruct", &reconstructed, "scan"_a, py::kw_only(), "gamma"_a = "scanner",
             "anyway"_a = false);
  module.def("decode", &decoded, "frames"_a, "sequence"_a, py::kw_only(), bits);
}

void bind_live(py::module_& module) {
  py::class_<Live> bound(module, "Live");
  bound.def(py::init(&live), "source"_a, "sequence"_a = py::none(), "scanner"_a = py::none(),
            "on_cloud"_a = py::none());

  bound.def("start", &Live::start, Unlocked());
  bound.def("stop", &Live::stop);
  bound.def("__next__", &Live::next);

  add(bound, "running", &Live::running, "statistics", &statistics_of, "findings",
      [](const Live& of) { return of.statistics().findings; });
}

}  // namespace slipstream::python
