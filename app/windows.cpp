// All that needs windows, for builds with SLIPSTREAM_VIEW.
#include "app/windows.h"

#include <cstdint>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "app/live.h"
#include "app/scan_flags.h"
#include "slipstream/base/error.h"
#include "slipstream/check/scan_check.h"
#include "slipstream/devices/monitor.h"
#include "slipstream/io/image_file.h"
#include "slipstream/view/view_source.h"
#include "slipstream/view/viewer.h"

namespace slipstream::app {
namespace {

/// Writes a picture and says so, under its name.
void write_picture(const char* name, const std::string& path, const Image<Colour>& picture,
                   Output& output) {
  write_image(path, picture);
  output.say("{}: {}", name, path);
  output.object("files")[name] = path;
}

void draw(const view::ViewSource& source, const ViewFlags& flags, view::Surround surround,
          const char* name, const std::string& path, Output& output) {
  if (path.empty()) return;
  if (!source.newest()) {
    throw WorldError(fmt::format("{}: no cloud came that could be drawn", path));
  }
  write_picture(name, path, view::render_screen(source, flags.settings, flags.size, surround),
                output);
}

/// Borrows the session.
view::ViewSource view_source_of(LiveSession& session) {
  const std::string& name = session.flags.source.request.source;
  view::ViewSource source =
      view::live_source(session.pipeline, setup_of(session), session.patterns_can_change);
  source.title = fmt::format("slipstream live: {}", name);
  source.waits_for = fmt::format("waiting for the first {} frames of {}",
                                 cycle_length(source.setup->sequence), name);
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
    return save_in_new_folder(cloud.frames, setup, session.flags.view.save_to,
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

void add_view_flags(CLI::App& subcommand, ViewFlags& flags) {
  const FlagGroup group{subcommand, "What is drawn"};
  group.add_output("--snapshot", flags.snapshot,
                   "the cloud as a picture, drawn without a window: .png, .tiff or .bmp");
  group.add_output("--screenshot", flags.screenshot,
                   "likewise with the panel and the camera's pictures beside it");
  add_size_flag(group, flags.size, "of window and pictures, pixels");
  group.add_named("--colour", flags.settings.colour, view::point_colour_named,
                  view::point_colour_names().front(),
                  fmt::format("of the points: {}", fmt::join(view::point_colour_names(), ", ")));
  group.add("--save-to", flags.save_to, "where the viewer's Save makes a folder for each scan");
}

void require_good(const ViewFlags& flags) {
  for (const std::string& path : {flags.snapshot, flags.screenshot}) {
    if (!path.empty()) require_colour_ending(path);
  }
}

void write_pictures(const view::ViewSource& source, const ViewFlags& flags, bool screenshot_too,
                    Output& output) {
  draw(source, flags, view::Surround::nothing, "snapshot", flags.snapshot, output);
  if (!screenshot_too) return;
  draw(source, flags, view::Surround::panel, "screenshot", flags.screenshot, output);
}

void show_in_window(LiveSession& session, Output& output) {
  const ViewFlags& flags = session.flags.view;
  const auto last =
      view::run_viewer(view_source_of(session), {.view = flags.settings,
                                                 .size = flags.size,
                                                 .ends = session.is_over,
                                                 .keep_last = !flags.screenshot.empty()});
  if (last) write_picture("screenshot", flags.screenshot, *last, output);
}

void draw_newest(LiveSession& session, bool screenshot_too, Output& output) {
  write_pictures(view_source_of(session), session.flags.view, screenshot_too, output);
}

CaptureDesktop open_desktop(const DesktopWishes& wishes) {
  if (!wishes.monitor && !wishes.guides) return {};
  struct Windows {
    opengl::WindowSystem system;
    std::optional<monitor::MonitorSink> projector;
    std::optional<view::GuideWindow> guide;
  };
  const auto windows = std::make_shared<Windows>();
  auto& [system, projector, guide] = *windows;
  CaptureDesktop desktop;
  if (wishes.monitor) desktop.projector = &projector.emplace(system, *wishes.monitor);
  desktop.closed = [windows] {
    return (windows->guide && windows->guide->closed()) ||
           (windows->projector && windows->projector->closed());
  };
  if (!wishes.guides) return desktop;
  guide.emplace(system, "slipstream capture", wishes.size);
  desktop.show = [windows](view::Guide shown) { windows->guide->show(std::move(shown)); };
  desktop.picture = [windows] { return windows->guide->picture(); };
  return desktop;
}

}  // namespace slipstream::app
