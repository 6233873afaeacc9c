#include <chrono>
#include <condition_variable>
#include <mutex>

#include "python/bindings/arrays.h"
#include "python/bindings/bindings.h"
#include "python/bindings/held.h"
#include "python/bindings/python_source.h"
#include "python/bindings/virtual_world.h"
#include "slipstream/error/error.h"
#include "slipstream/io/scanner_file.h"
#include "slipstream/live/live_pipeline.h"
#include "slipstream/photometry/gamma_choice.h"
#include "slipstream/sources/named_source.h"

namespace slipstream::python {
namespace {
namespace fs = std::filesystem;

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
    const py::gil_scoped_release release;
    pipeline_->start();
  }
  /// What a stage, the source or `on_cloud` threw comes out here.
  void stop() {
    {
      const py::gil_scoped_release release;
      pipeline_->stop();
    }
    if (const auto failure = pipeline_->failure()) std::rethrow_exception(failure);
  }
  /// The newest cloud, as soon as there is one that was not given yet.
  std::shared_ptr<HeldCloud> next() {
    while (!wait_for_new()) {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (pipeline_->running()) continue;
      stop();
      if (!wait_for_new()) throw py::stop_iteration();
    }
    return given();
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
    {
      const std::lock_guard lock(mutex_);
      newest_ = cloud;
      is_new_ = true;
    }
    came_.notify_all();
  }
  bool wait_for_new() {
    const py::gil_scoped_release release;
    std::unique_lock lock(mutex_);
    return came_.wait_for(lock, std::chrono::milliseconds(20), [this] { return is_new_; });
  }
  std::shared_ptr<HeldCloud> given() {
    const py::gil_scoped_release release;
    Pooled<LiveCloud> newest;
    {
      const std::lock_guard lock(mutex_);
      newest = std::move(newest_);
      is_new_ = false;
    }
    return copy_of(*newest);
  }
  std::shared_ptr<HeldCloud> copy_of(const LiveCloud& cloud) {
    std::shared_ptr<HeldCloud> copy = clouds_.take([] { return std::make_unique<HeldCloud>(); });
    copy->fresh() = cloud.cloud;
    return copy;
  }

  py::object on_cloud_;
  Reused<HeldCloud> clouds_;
  std::mutex mutex_;  // of what follows
  std::condition_variable came_;
  Pooled<LiveCloud> newest_;
  bool is_new_ = false;
  std::unique_ptr<LivePipeline> pipeline_;
};

NamedSource named(const std::string& source, const std::optional<Sequence>& sequence,
                  Keywords& keywords) {
  SourceRequest request{.source = source};
  keywords.take("rate", request.rate);
  keywords.take("loop", request.loop);
  if (sequence) request.sequence = changes_to(*sequence);
  if (scheme_of(source) == "virtual") request.world = world_from(keywords);
  const py::gil_scoped_release release;
  return open_source(request);
}

NamedSource own(const py::iterable& frames, const std::optional<Sequence>& sequence,
                Keywords& keywords) {
  if (!sequence) throw Error("frames do not say what they show; give their sequence");
  std::optional<int> bits;
  keywords.take("bits", bits);
  NamedSource source;
  source.frames = std::make_unique<PythonSource>(frames, bits);
  source.sequence = *sequence;
  return source;
}

std::unique_ptr<Live> live(const py::object& from, const std::optional<Sequence>& sequence,
                           const std::optional<Scanner>& scanner, const py::object& on_cloud,
                           const py::kwargs& given) {
  Keywords keywords(given);
  const bool by_name = py::isinstance<py::str>(from);
  NamedSource source = by_name ? named(from.cast<std::string>(), sequence, keywords)
                               : own(from.cast<py::iterable>(), sequence, keywords);
  std::string indexing = by_name ? "told" : "counted", gamma = "scanner";
  LiveSettings settings;
  ReconstructSettings points;
  keywords.take("indexing", indexing);
  keywords.take("gamma", gamma);
  keywords.take("most_frames", settings.most_frames);
  take(keywords, points);
  keywords.require_none_left();
  settings.indexing =
      source.sequence.marker ? PatternIndexing::marker : pattern_indexing_named(indexing);
  if (scanner) source.scanner = *scanner;
  if (!source.scanner) throw Error("no scanner is known for the source; give it as scanner");
  EngineSetup setup{completed(*source.scanner, "scanner", source.frames->format().size,
                              source.sequence.projector),
                    source.sequence, points};
  require_ambient_known(setup, "scanner");
  setup.scanner.photometry.response =
      choose_gamma(gamma, setup.scanner.photometry.response).response;
  return std::make_unique<Live>(std::move(source), setup, settings, on_cloud);
}

py::dict json_of(const LiveStatistics& of) {
  using namespace py::literals;
  return py::dict("clouds"_a = of.clouds, "clouds_per_second"_a = of.clouds_per_second,
                  "captured"_a = of.frames.captured, "lost"_a = of.frames.lost,
                  "overwritten"_a = of.frames.overwritten, "repeated"_a = of.frames.repeated,
                  "windows_lost"_a = of.windows_lost, "seconds"_a = of.seconds,
                  "latency_p50"_a = of.latency.p50, "latency_p99"_a = of.latency.p99,
                  "source_state"_a = of.source_state);
}

}  // namespace

void bind_live(py::module_& module) {
  py::class_<Live>(module, "Live",
                   "Frames to clouds as they come; each new frame gives a cloud of the newest "
                   "ones. `for cloud in live` gives the newest each time, `on_cloud` takes them "
                   "all, in a thread of its own.")
      .def(py::init(&live), py::arg("source"), py::arg("sequence") = py::none(),
           py::arg("scanner") = py::none(), py::arg("on_cloud") = py::none())
      .def("start", &Live::start)
      .def("stop", &Live::stop, "Ends it; raises what went wrong.")
      .def("__enter__",
           [](const py::object& self) {
             self.cast<Live&>().start();
             return self;
           })
      .def("__exit__",
           [](Live& of, const py::object& type, const py::args&) {
             try {
               of.stop();
             } catch (...) {
               if (type.is_none()) throw;  // else what is under way says more
             }
           })
      .def("__iter__", [](const py::object& self) { return self; })
      .def("__next__", &Live::next)
      .def_property_readonly("running", &Live::running)
      .def_property_readonly(
          "statistics", [](const Live& of) { return json_of(of.statistics()); },
          "Counts from the start; latencies in ms.")
      .def_property_readonly(
          "findings", [](const Live& of) { return of.statistics().findings; },
          "What is amiss with the newest frames.")
      .def("__repr__", [](const Live& of) {
        return py::str("<slipstream.Live, {} clouds>").format(of.statistics().clouds);
      });
}

}  // namespace slipstream::python
