#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "app/live_session.h"
#include "app/save_scan.h"
#include "slipstream/error/error.h"
#include "slipstream/gamma/correction.h"
#include "slipstream/io/file.h"
#include "slipstream/io/image_file.h"
#include "slipstream/view/viewer.h"

namespace slipstream::app {
namespace fs = std::filesystem;
namespace {

/// What people project most, where it is not known to be otherwise.
std::vector<Strategy> usual_strategies() {
  std::vector<Strategy> usual{
      make_strategy("dual-frequency", {{"steps", 3}, {"high", 16}, {"low", 1}}),
      make_strategy("dual-frequency", {{"steps", 4}, {"high", 32}, {"low", 1}})};
  for (const double steps : {3, 4, 6}) {
    usual.push_back(make_strategy("pmp", {{"steps", steps}, {"frequency", 1}}));
  }
  return usual;
}

std::string label_of(const Strategy& strategy) {
  std::string label(name_of(strategy));
  for (const auto& [name, value] : settings_of(strategy)) {
    label += fmt::format(", {} {:g}", name, value);
  }
  return label;
}

/// The one given first; others where the patterns come from a projector that may show them.
std::vector<std::pair<std::string, Strategy>> strategies_for(const LiveSession& session) {
  std::vector<std::pair<std::string, Strategy>> choices{
      {label_of(session.scan.strategy), session.scan.strategy}};
  for (const Strategy& strategy : usual_strategies()) {
    if (session.patterns_can_change && label_of(strategy) != choices.front().first) {
      choices.emplace_back(label_of(strategy), strategy);
    }
  }
  return choices;
}

std::vector<std::pair<std::string, GammaChoice>> gammas_for(const LiveSession& session) {
  std::vector<int> steps = step_counts(session.scan.strategy);
  if (session.patterns_can_change) steps.insert(steps.end(), {3, 4, 6});
  std::vector<std::pair<std::string, GammaChoice>> choices{
      {"as given", session.scanner.gammas.front()}, {"none", {}}};
  for (const double gamma : {1.4, 1.8, 2.0, 2.2, 2.4}) {
    choices.emplace_back(fmt::format("{:g}", gamma),
                         GammaChoice{.corrections = phase_corrections(PowerLaw{gamma}, steps),
                                     .source = "given",
                                     .gamma = gamma,
                                     .sentence = {}});
  }
  return choices;
}

fs::path new_recording(const std::string& folder) {
  make_folder(folder);
  return path_named_by_time(folder, "recording", ".slip");
}

std::string text_of(const RecordedSource::Recording& recording) {
  if (!recording.error.empty()) return recording.error;
  std::string text =
      fmt::format("{}, {} frames", recording.path.string(), recording.counts.written);
  if (recording.counts.lost != 0) text += fmt::format(", {} lost", recording.counts.lost);
  return text;
}

/// Borrows the session.
view::ViewSource view_source_of(LiveSession& session) {
  view::ViewSource source;
  source.title = fmt::format("slipstream live: {}", session.source);
  source.newest = [&session] { return session.pipeline.newest(); };
  source.shown = [&session](const LiveCloud& cloud) { session.pipeline.shown(cloud); };
  source.statistics = [&session] { return session.pipeline.statistics(); };
  source.scan = session.scan;
  source.change = [&session](const LiveScan& scan) {
    session.pipeline.change(scan);
    session.scan = scan;
    session.recorder.set_strategy(scan.strategy);
  };
  source.strategies = strategies_for(session);
  SavedScanner scanner = session.scanner;
  scanner.gammas.clear();
  for (auto& [label, gamma] : gammas_for(session)) {
    source.gammas.emplace_back(label, gamma.corrections);
    scanner.gammas.push_back(std::move(gamma));
  }
  source.full_scale = (1 << session.recorder.format().bits) - 1;
  source.save = [scanner, folder = session.view.save_to](const LiveCloud& cloud,
                                                         const LiveScan& scan) {
    return save_scan(cloud, scan, scanner, folder);
  };
  source.record = [&session](bool on) {
    if (on) {
      session.recorder.record_to(new_recording(session.view.save_to));
    } else {
      session.recorder.finish_recording();
    }
  };
  source.recording = [&session] {
    const auto recording = session.recorder.recording();
    return recording ? text_of(*recording) : std::string();
  };
  return source;
}

void write_picture(const char* name, const std::string& path, const Image<Colour>& picture,
                   Output& output) {
  write_image(path, picture);
  output.say("{}: {}", name, path);
  output.document["files"][name] = path;
}

}  // namespace

void show_in_window(LiveSession& session, Output& output) {
  const view::ViewSource source = view_source_of(session);
  view::ViewerSettings settings;
  settings.view = view_settings_from(session.view);
  settings.size = size_from(session.view);
  settings.ends = session.is_over;
  settings.keep_last = !session.view.screenshot.empty();
  const auto last = view::run_viewer(source, settings);
  if (last) write_picture("screenshot", session.view.screenshot, *last, output);
}

void draw_newest(LiveSession& session, bool screenshot_too, Output& output) {
  const view::ViewSource source = view_source_of(session);
  const auto draw = [&](const char* name, const std::string& path, view::Surround surround) {
    if (path.empty()) return;
    if (!session.pipeline.newest()) {
      throw WorldError(fmt::format("{}: no cloud came that could be drawn", path));
    }
    write_picture(name, path,
                  view::render_screen(source, view_settings_from(session.view),
                                      size_from(session.view), surround),
                  output);
  };
  draw("snapshot", session.view.snapshot, view::Surround::nothing);
  if (screenshot_too) draw("screenshot", session.view.screenshot, view::Surround::panel);
}

}  // namespace slipstream::app
