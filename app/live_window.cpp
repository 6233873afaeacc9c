#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "app/live_session.h"
#include "app/live_settings.h"
#include "app/save_folder.h"
#include "app/scan_findings.h"
#include "app/view_files.h"
#include "slipstream/view/live_source.h"
#include "slipstream/view/viewer.h"

namespace slipstream::app {
namespace {

/// Borrows the session.
view::ViewSource view_source_of(LiveSession& session) {
  view::ViewSource source =
      view::live_source(session.pipeline, setup_of(session), session.patterns_can_change);
  source.title = fmt::format("slipstream live: {}", session.source);
  source.waits_for = fmt::format("waiting for the first {} frames of {}",
                                 cycle_length(source.setup->sequence), session.source);
  source.camera = session.recorder.controls();
  source.camera_region = fmt::format("{} pixels; --region at the start changes that",
                                     text_of(session.recorder.format().size));
  source.change = [&session](const EngineSetup& setup) { change_setup(session, setup); };
  source.changed = [&session, seen = session.changes.load()]() mutable {
    const std::uint64_t changes = session.changes;
    const bool same = std::exchange(seen, changes) == changes;
    return same ? std::nullopt : std::optional(setup_of(session));
  };
  source.save = [&session](const view::ShownCloud& cloud, const EngineSetup& setup) {
    return save_in_new_folder(cloud.frames, setup, session.view.save_to,
                              doubts(session.pipeline.statistics().findings));
  };
  source.record = [&session](bool on) { change_setting(session, "record", on ? "on" : "off"); };
  source.recording = [&session] {
    const auto recording = session.recorder.recording();
    return recording ? text_of(*recording) : std::string();
  };
  return source;
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
  write_snapshot(source, session.view, output);
  if (screenshot_too) write_screenshot(source, session.view, output);
}

}  // namespace slipstream::app
