#include <chrono>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include "python/bindings/arguments.h"
#include "python/bindings/bindings.h"
#include "python/bindings/clouds.h"
#include "python/bindings/given.h"
#include "python/bindings/settings_help.h"
#include "python/bindings/virtual_world.h"
#include "slipstream/engine.h"
#include "slipstream/gamma.h"
#include "slipstream/live_pipeline.h"
#include "slipstream/named_source.h"

namespace slipstream::python {
namespace {

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
    rethrown_ = false;
  }

  /// Rethrows an exception of a stage, the source or `on_cloud`, once.
  void stop() {
    unlocked([this] {
      const std::lock_guard lock(stopping_);
      pipeline_->stop();
    });

    const auto failure = pipeline_->failure();
    if (failure && !std::exchange(rethrown_, true)) std::rethrow_exception(failure);
  }

  /// Waits for the newest cloud not returned yet.
  std::shared_ptr<HeldCloud> next() {
    while (true) {
      // Looks for Ctrl+C between short waits.
      if (auto cloud = newest_soon()) return cloud;
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (pipeline_->running()) continue;

      // Its last cloud may have come while it stopped.
      stop();
      if (auto cloud = newest_soon()) return cloud;
      throw py::stop_iteration();
    }
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

  /// Takes the newest cloud, for one of the threads that wait; null if none comes soon.
  std::shared_ptr<HeldCloud> newest_soon() {
    const py::gil_scoped_release release;

    std::unique_lock lock(mutex_);
    came_.wait_for(lock, std::chrono::milliseconds(20), [this] { return bool(newest_); });
    const Pooled<LiveCloud> newest = std::exchange(newest_, {});

    // Copies without the mutex, which the show stage needs.
    lock.unlock();
    return newest ? copy_of(*newest) : nullptr;
  }

  std::shared_ptr<HeldCloud> copy_of(const LiveCloud& cloud) {
    std::shared_ptr<HeldCloud> copy = clouds_.take();
    copy->fresh() = cloud.cloud;
    return copy;
  }

  py::object on_cloud_;
  bool rethrown_ = false;

  Reused<HeldCloud> clouds_;

  std::mutex stopping_;  // one thread at a time
  std::mutex mutex_;     // guards the next two
  std::condition_variable came_;
  Pooled<LiveCloud> newest_;

  std::unique_ptr<LivePipeline> pipeline_;
};

/// A path is a recording's or a folder's, to replay.
std::string source_from(const py::object& given) {
  if (py::isinstance<py::str>(given)) return given.cast<std::string>();
  if (is_path(given)) return "replay:" + given.cast<fs::path>().string();
  throw py::type_error("source cannot be " + shown(given) + "; expected str | PathLike");
}

std::unique_ptr<Live> live(const py::object& source_name,
                           const std::optional<Given<Sequence>>& sequence,
                           const std::optional<Given<Scanner>>& scanner, const py::object& on_cloud,
                           const py::kwargs& kwargs) {
  const std::string name = source_from(source_name);

  // 1. The keywords; a virtual source also takes a virtual world's.
  Keywords keywords(kwargs);
  SourceRequest request{.source = name};
  std::string indexing = "source", gamma = "scanner";
  LiveSettings settings;
  ReconstructSettings points;

  take_described(keywords, request);
  keywords.take("indexing", indexing, "gamma", gamma, "most_frames", settings.most_frames);

  if (sequence) request.sequence = changes_to(sequence->value);
  if (scheme_of(name) == "virtual") request.world = world_from(keywords);
  take(keywords, points);

  keywords.require_none_left();

  // 2. Opens the source. A marker, if the patterns have one, shows where each cycle begins.
  NamedSource source = unlocked([&] { return open_source(request); });
  settings.indexing = pattern_indexing_named(source.sequence.marker ? "marker" : indexing);

  if (scanner) source.scanner = scanner->value;
  const std::string scanner_name = scanner ? scanner->name : "scanner";
  if (!source.scanner) throw Error("no scanner is known for " + name + "; give it as scanner");

  // 3. The setup, with the chosen response.
  EngineSetup setup{completed(*source.scanner, scanner_name, source.frames->format().size,
                              source.sequence.projector),
                    source.sequence, points};
  require_ambient_known(setup, scanner_name);

  auto& response = setup.scanner.photometry.response;
  response = choose_gamma(gamma, response).response;

  return std::make_unique<Live>(std::move(source), setup, settings, on_cloud);
}

py::dict statistics_of(const Live& live) {
  const LiveStatistics statistics = live.statistics();
  py::dict figures;

  // Only figures that are a number or a text fit into this dict.
  const auto tell = [&](const std::string& name, const auto& figure, const auto&...) {
    using Figure = std::remove_cvref_t<decltype(figure)>;
    if constexpr (std::is_arithmetic_v<Figure> || std::is_same_v<Figure, std::string>) {
      figures[py::str(name)] = figure;
    }
  };

  statistics.for_each_figure(tell);
  statistics.frames.for_each_figure(tell);
  statistics.latency.for_each_figure(
      [&](const char* name, double ms) { tell("latency_" + std::string(name), ms); });

  return figures;
}

/// The entries of the keywords after the first ones of `live`.
std::string live_help() {
  return described_help(SourceRequest()) + world_help() + reconstruct_help();
}

}  // namespace

void bind_live(py::module_& module) {
  py::class_<Live> bound(module, "Live",
                         with_settings(live_help(), R"(
      Reconstructs live; iteration yields the newest cloud each time.

      Args:
          source (str | PathLike): virtual, replay:PATH, aravis:NAME or v4l2:NUMBER; a PathLike is
              replayed.
          sequence (Sequence | Strategy | str | None): pattern sequence, or its strategy along x;
              None: the source's own.
          scanner (Scanner | str | PathLike | None): calibration, or its file; None: the source's
              own.
          on_cloud (Callable[[Cloud], object] | None): called with every cloud, in its own thread.
          indexing (Literal["source", "counted", "marker"], default 'source'): how frames match
              patterns.
          gamma (str, default 'scanner'): response correction: scanner (if present), blind (from the
              frames), none, or a gamma.
          most_frames (int | None, default None): ends the stream after this many frames.
          {settings}

      Raises:
          Error: if a value is out of range.
          TypeError: for an unknown keyword or a value of the wrong type.

      Example:
          >>> with slipstream.Live("virtual", sequence, camera=(64, 48), most_frames=9) as live:
          ...     clouds = list(live)
  )")
                             .c_str());

  bound.def(py::init(&live), "source"_a, "sequence"_a = py::none(), "scanner"_a = py::none(),
            "on_cloud"_a = py::none());

  bound.def("_start", &Live::start, Unlocked());
  bound.def("stop", &Live::stop, R"(
      Stops it; raises any error of its threads.

      Example:
          >>> live.stop()
  )");
  bound.def("__next__", &Live::next);

  bound.def_property_readonly("running", &Live::running, "bool: whether it captures.");
  bound.def_property_readonly("statistics", &statistics_of,
                              "dict[str, Any]: counts since the start; latencies, ms.");
  bound.def_property_readonly(
      "findings", [](const Live& self) { return self.statistics().findings; },
      "list[Finding]: diagnostics.");
}

}  // namespace slipstream::python
