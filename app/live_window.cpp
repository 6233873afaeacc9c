#include <chrono>
#include <ctime>
#include <filesystem>
#include <string>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "app/live_session.h"
#include "app/save_scan.h"
#include "slipstream/io/image_file.h"

namespace slipstream::app {
namespace fs = std::filesystem;
namespace {

/// "recording-20260131-142530.slip" in that folder.
fs::path new_recording(const fs::path& folder) {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  return folder / fmt::format("recording-{:%Y%m%d-%H%M%S}.slip", fmt::localtime(now));
}

/// Empty where nothing is recorded.
std::string progress_of(const RecordedSource& recorder) {
  const auto recording = recorder.recording();
  if (!recording) return {};
  if (!recording->error.empty()) return recording->error;
  return fmt::format("{}, {} frames, {} lost", recording->path.filename().string(),
                     recording->counts.written, recording->counts.lost);
}

/// Borrows the session.
view::ViewSource source_of(LiveSession& session, const ViewFlags& flags) {
  view::ViewSource source;
  LivePipeline& pipeline = session.pipeline;
  RecordedSource& recorder = session.recorder;
  source.title = "slipstream live";
  source.newest = [&] { return pipeline.newest(); };
  source.shown = [&](const LiveCloud& cloud) { pipeline.shown(cloud); };
  source.statistics = [&] { return pipeline.statistics(); };
  source.scan = session.scan;
  source.change = [&](const LiveScan& scan) { pipeline.change(scan); };
  source.gammas = {{"as given", session.scan.settings.phase_corrections}, {"none", {}}};
  source.save = [folder = flags.save_to](const LiveCloud& cloud, const LiveScan& scan) {
    return save_scan(cloud, scan, folder);
  };
  source.record = [&, folder = fs::path(flags.save_to)](bool on) {
    on ? recorder.record_to(new_recording(folder)) : recorder.finish_recording();
  };
  source.recording = [&] { return progress_of(recorder); };
  return source;
}

}  // namespace

void show_in_window(LiveSession& session, const ViewFlags& flags) {
  view::run_viewer(
      source_of(session, flags),
      {.view = view_settings_from(flags), .size = size_from(flags), .ends = session.is_over});
}

void write_picture(LiveSession& session, const ViewFlags& flags, const std::string& path,
                   view::Surround surround) {
  write_image(path, view::render_screen(source_of(session, flags), view_settings_from(flags),
                                        size_from(flags), surround));
}

}  // namespace slipstream::app
