#include <chrono>
#include <condition_variable>

#include "python/bindings/engines.h"
#include "slipstream/base/error.h"
#include "slipstream/devices/named_source.h"
#include "slipstream/live/live_pipeline.h"
#include "slipstream/response/gamma_choice.h"

namespace slipstream::python {
namespace {

/// A LivePipeline whose clouds Python takes.
class Live {
 public:
  Live(NamedSource source, const EngineSetup& setup, LiveSettings settings, py::object on_cloud)
      : on_cloud_(std::move(on_cloud)) {
    settings.on_cloud = [this](const Pooled<LiveCloud>& cloud) { take(cloud); };
    pipeline_ = std::make_unique<LivePipeline>(std::move(source.frames), setup, settings);
  }
  ~Live() {
    const py::gil_scoped_release release;  // the threads that end here may wait for the lock
    pipeline_.reset();
  }

  void start() {
    pipeline_->start();
    told_ = false;
  }
  /// What a stage, the source or `on_cloud` threw comes out here, once.
  void stop() {
    unlocked([this] { pipeline_->stop(); });
    const auto failure = pipeline_->failure();
    if (failure && !std::exchange(told_, true)) std::rethrow_exception(failure);
  }
  /// The newest cloud, as soon as there is one that was not given yet.
  std::shared_ptr<HeldCloud> next() {
    while (!has_new()) {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (pipeline_->running()) continue;
      stop();
      if (!has_new()) throw py::stop_iteration();
    }
    return unlocked([this] {
      std::unique_lock lock(mutex_);
      const Pooled<LiveCloud> newest = std::exchange(newest_, {});
      lock.unlock();
      return copy_of(*newest);
    });
  }
  [[nodiscard]] bool running() const { return pipeline_->running(); }
  [[nodiscard]] LiveStatistics statistics() const { return pipeline_->statistics(); }

 private:
  /// In the thread of the show stage.
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
  std::mutex mutex_;  // of the next two
  std::condition_variable came_;
  Pooled<LiveCloud> newest_;
  std::unique_ptr<LivePipeline> pipeline_;
};

std::unique_ptr<Live> live(const std::string& name, const std::optional<Sequence>& sequence,
                           const std::optional<Scanner>& scanner, const py::object& on_cloud,
                           const py::kwargs& given) {
  Keywords keywords(given);
  SourceRequest request{.source = name};
  std::string indexing = "told", gamma = "scanner";
  LiveSettings settings;
  ReconstructSettings points;
  keywords.take("rate", request.rate, "loop", request.loop, "indexing", indexing, "gamma", gamma,
                "most_frames", settings.most_frames);
  if (sequence) request.sequence = changes_to(*sequence);
  if (scheme_of(name) == "virtual") request.world = world_from(keywords);
  take(keywords, points);
  keywords.require_none_left();
  NamedSource source = unlocked([&] { return open_source(request); });
  settings.indexing = pattern_indexing_named(source.sequence.marker ? "marker" : indexing);
  if (scanner) source.scanner = *scanner;
  if (!source.scanner) throw Error("no scanner is known for " + name + "; give it as scanner");
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
  return py::dict("clouds"_a = of.clouds, "clouds_per_second"_a = of.clouds_per_second,
                  "captured"_a = of.frames.captured, "lost"_a = of.frames.lost,
                  "overwritten"_a = of.frames.overwritten, "repeated"_a = of.frames.repeated,
                  "windows_lost"_a = of.windows_lost, "seconds"_a = of.seconds,
                  "latency_p50"_a = of.latency.p50, "latency_p99"_a = of.latency.p99,
                  "source_state"_a = of.source_state);
}

}  // namespace

void bind_live(py::module_& module) {
  py::class_<Live> bound(
      module, "Live",
      "Frames to clouds as they come, of a source by its name: virtual, replay:PATH, aravis:NAME "
      "or "
      "v4l2:NUMBER; each new frame gives a cloud of the newest ones. `with Live(...) as live: for "
      "cloud in live:` "
      "gives the newest each time, `on_cloud` takes them all, in a thread of its own. Statistics "
      "count from the start, latencies are in ms.");
  bound.def(py::init(&live), "source"_a, "sequence"_a = py::none(), "scanner"_a = py::none(),
            "on_cloud"_a = py::none());
  bound.def("start", &Live::start, Unlocked());
  bound.def("stop", &Live::stop, "Ends it; raises what went wrong.");
  bound.def("__next__", &Live::next);
  add(bound, "running", &Live::running, "statistics", &statistics_of, "findings",
      [](const Live& of) { return of.statistics().findings; });
}

}  // namespace slipstream::python
