#include "app/publish.h"

#include "app/save_folder.h"
#include "slipstream/check/checked_scan.h"
#include "slipstream/cycle/window_frames.h"
#include "slipstream/error/error.h"
#include "slipstream/publish/named_sink.h"

namespace slipstream::app {
namespace {

std::string trouble_of(const LivePipeline& pipeline) {
  if (const auto failure = pipeline.failure()) return "the pipeline has failed";
  const std::string state = pipeline.statistics().source_state;
  if (!state.empty()) return state;
  return pipeline.running() ? "" : "the source has ended";
}

/// Which strategy and folder: those of the session when it is asked for.
std::string save_newest(LiveSession& session) {
  const Pooled<LiveCloud> newest = session.pipeline.newest();
  if (!newest) throw Error("no cloud has come that could be saved");
  EngineSetup setup;
  {
    const std::lock_guard lock(session.mutex);
    setup = session.setup;
  }
  return save_in_new_folder(views_of(newest->frames), setup, session.view.save_to,
                            doubts(session.pipeline.statistics().findings));
}

}  // namespace

void open_sinks(const std::vector<std::string>& names, LiveSession& session,
                const std::function<nlohmann::json()>& document, Publisher& publisher) {
  const Scanner& scanner = session.setup.scanner;
  for (const std::string& name : names) {
    PublishedRun run{
        .camera = scanner.camera,
        .has_points = has_geometry(scanner),
        .statistics = [document] { return document().dump(); },
        .trouble = [&pipeline = session.pipeline] { return trouble_of(pipeline); },
        .save = [&session] { return save_newest(session); },
    };
    publisher.add(name, open_sink(name, std::move(run)));
  }
}

nlohmann::json json_of(const std::vector<SinkStatistics>& sinks) {
  nlohmann::json list = nlohmann::json::array();
  for (const auto& [name, published, dropped, error] : sinks) {
    list.push_back(
        {{"name", name}, {"published", published}, {"dropped", dropped}, {"error", error}});
  }
  return list;
}

void tell_news(Publisher& publisher, Output& output) {
  publisher.tell([&](const std::string& line) { output.say("{}", line); },
                 [&](const std::string& line) { output.warn(line); });
}

}  // namespace slipstream::app
