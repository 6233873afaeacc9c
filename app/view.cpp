#include "app/view.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "app/live.h"
#include "app/session_outputs.h"
#include "app/studio.h"
#include "io/file.h"
#include "io/image_file.h"
#include "slipstream/recording.h"

namespace slipstream::app {

void add_view_flags(CLI::App& subcommand, ViewFlags& flags) {
  const FlagGroup group{subcommand, "Drawing"};
  group.add_output("--snapshot", flags.snapshot,
                   "draw the cloud without a window into a picture: .png, .tiff or .bmp");
  group.add_output("--screenshot", flags.screenshot,
                   "the same with panel and camera pictures: .png, .tiff or .bmp");

  group.add("--size", flags.size, "size of window and pictures, pixels");
  group.add_named("--colour", flags.settings.colour, view::point_colour_named,
                  view::point_colour_names().front(),
                  fmt::format("point colours: {}", fmt::join(view::point_colour_names(), ", ")));

  group.add("--views", flags.settings.three_views,
            "draw the cloud from the front, the side and above, side by side");
  group.add("--save-to", flags.save_to, "folder in which Save makes a folder per scan");
}

void require_good(const ViewFlags& flags) {
  for (const std::string& path : {flags.snapshot, flags.screenshot}) {
    if (!path.empty()) require_colour_ending(path);
  }
}

void show_in_window(view::ViewSource source, const ViewFlags& flags,
                    const std::function<bool()>& ends, Output& output) {
  const auto last = view::run_viewer(std::move(source), {.view = flags.settings,
                                                         .size = flags.size,
                                                         .ends = ends,
                                                         .keep_last = !flags.screenshot.empty()});

  if (!last) return;
  write_image(flags.screenshot, *last);
  output.add_file("screenshot", flags.screenshot);
}

void write_pictures(const view::ViewSource& source, const ViewFlags& flags, bool screenshot_too,
                    Output& output) {
  const auto draw = [&](const char* name, const std::string& path, view::Surround surround) {
    if (path.empty()) return;
    if (!source.newest()) throw WorldError(fmt::format("{}: no cloud to draw", path));
    write_image(path, view::render_screen(source, flags.settings, flags.size, surround));
    output.add_file(name, path);
  };
  draw("snapshot", flags.snapshot, view::Surround::nothing);
  if (screenshot_too) draw("screenshot", flags.screenshot, view::Surround::panel);
}

namespace {

struct ViewPathFlags {
  std::string path;
  ScanChanges changes;
  ScanJobSettings job;
  FlagsOfScans of_scans;
  ViewFlags view;
  std::string web;  ///< [ADDRESS:]PORT; empty: in a window
};

view::StillScan still_scan(CheckedJob job) {
  return {std::move(job.scan.frames), std::move(job.scan.colour), std::move(job.checked.findings)};
}

/// The number of scans of a recording, and how fast they follow each other.
void add_timeline(view::ViewSource& source, const ScanFiles& files) {
  source.scans = window_count(files);
  if (source.scans < 2) return;

  // Times of frames count from the first one.
  const RecordingReader& recording = *files.recording;
  if (recording.count() < 2) return;

  Frame last;
  recording.read(recording.count() - 1, last);
  const std::chrono::duration<double> time = last.stamp.host_time.time_since_epoch();
  const auto frames = static_cast<double>(recording.count());
  source.seconds_per_scan =
      time.count() * frames / (frames - 1) / static_cast<double>(source.scans);
}

view::ViewSource source_of_scan(const std::string& path, const ScanChanges& changes,
                                const ScanJobSettings& settings, const std::string& save_to,
                                Output& output) {
  require_valid(settings.reconstruct.clean);

  CheckedJob job =
      checked_scan(load_checkable(path, changes, false, output), path, settings, output);
  const EngineSetup setup = job.setup;
  const auto response = job.gamma.response;
  const auto blind =
      choose_gamma("blind", response, setup.sequence.strategy.layout(), job.scan.frames).response;

  // Each scan of a recording is checked before it is shown, as the first.
  const ScanFiles files = scan_files_in(path, changes);
  ScanChanges of_window = changes;
  of_window.recording = files.recording;
  const auto scan_at = [path, of_window, settings,
                        scanner = setup.scanner](std::size_t number) mutable {
    of_window.window = number;
    Scan scan = load_scan(scan_files_in(path, of_window));
    scan.scanner = scanner;
    CheckedJob other = checked_job(std::move(scan), settings, path);
    if (!settings.keep_refused) require_right(other.checked, path);
    return still_scan(std::move(other));
  };

  view::ViewSource source = view::still_source(still_scan(std::move(job)), setup, scan_at);
  if (files.recording) add_timeline(source, files);
  if (const auto& frame = wanted_frame(settings.reconstruct)) {
    source.frame = frame_after({}, *frame);
  }
  const char* const origin = settings.gamma == "scanner" ? "of the scanner" : "of the flag";
  source.gammas = {{origin, response}, {"none", std::nullopt}, {"from the frames", blind}};
  source.save = [save_to](const view::ShownCloud& cloud, const EngineSetup& used) {
    return save_in_new_folder(cloud.frames, used, save_to, remarks_about(cloud.findings));
  };

  return source;
}

/// The window draws in the camera's frame, and tells coordinates in the file's or the wanted one.
view::ViewSource source_of_cloud(const std::string& path, const ReconstructSettings& settings,
                                 Output& output) {
  StoredCloud stored = loaded_cloud(path, output);
  std::shared_ptr<const FramePose> frame = stored.cloud.frame;
  if (const auto& wanted = wanted_frame(settings)) frame = frame_after(frame, *wanted);
  move_to_camera(stored.cloud, stored.uncertainty ? &*stored.uncertainty : nullptr);

  view::ViewSource source =
      view::still_source(std::move(stored.cloud), std::move(stored.uncertainty));
  source.frame = frame;
  return source;
}

bool is_scan(const std::string& path) {
  return fs::is_directory(path) || is_recording(path);
}

/// A page instead of a window: loops the frames as live does.
void serve_page(const ViewPathFlags& flags, Output& output) {
  throw_if(!is_scan(flags.path), "--web shows scan folders and recordings; '{}' is neither",
           flags.path);

  LiveFlags replay;
  replay.headless = true;
  replay.gamma = flags.job.gamma;
  replay.settings = flags.job.reconstruct;

  replay.source.source = "replay:" + flags.path;
  replay.source.loop = true;
  replay.source.sequence = flags.changes.sequence;
  replay.source.scanner = flags.changes.scanner;
  if (fs::is_directory(flags.path)) replay.source.rate = 60;  // it has no timestamps

  replay.publish = {"web:" + flags.web};
  replay.view = flags.view;
  live(replay, output);
}

void view_path(const ViewPathFlags& flags, Output& output) {
  if (!flags.web.empty()) return serve_page(flags, output);
  require_good(flags.view);

  // Flags of scans would be ignored for a cloud.
  const bool scan = is_scan(flags.path);
  if (!scan && fs::exists(flags.path)) flags.of_scans.refuse_for_cloud(flags.path);

  // 1. Without a path: choose in the window.
  if (flags.path.empty()) {
    LiveFlags choices;
    choices.settings = flags.job.reconstruct;
    choices.view = flags.view;
    return studio(choices, output);
  }

  // 2. Draw pictures, if any are wanted.
  view::ViewSource source =
      view_source_of(flags.path, flags.changes, flags.job, flags.view, output);
  output.document = described("path", flags.path, "files", nlohmann::json::object());
  if (scan) output.document["findings"] = source.newest().findings;
  write_pictures(source, flags.view, true, output);

  if (!output.document["files"].empty()) return;

  // 3. Otherwise open a window, from which files beside this one can be opened.
  const fs::path beside = fs::absolute(flags.path / fs::path()).parent_path().parent_path();
  source.openable = [beside] { return viewable_in(beside); };
  source.open = [&flags, &output](const std::string& path) {
    return view_source_of(path, {}, {.reconstruct = flags.job.reconstruct}, flags.view, output);
  };

  view::run_viewer(std::move(source), {.view = flags.view.settings, .size = flags.view.size});
}

}  // namespace

view::ViewSource view_source_of(const std::string& path, const ScanChanges& changes,
                                const ScanJobSettings& job, const ViewFlags& view, Output& output) {
  view::ViewSource source = is_scan(path) ? source_of_scan(path, changes, job, view.save_to, output)
                                          : source_of_cloud(path, job.reconstruct, output);

  source.wording = &with_flags;
  source.title = path;
  return source;
}

std::vector<std::string> viewable_in(const fs::path& folder) {
  std::vector<std::pair<fs::file_time_type, std::string>> found;
  std::error_code none;

  // A folder that cannot be read gives an empty list.
  for (const auto& entry : fs::directory_iterator(folder, none)) {
    const bool file = is_cloud_file(entry.path()) || lower_case_extension(entry.path()) == ".slip";
    if (file || fs::exists(entry.path() / "scan.yaml", none)) {
      found.emplace_back(entry.last_write_time(none), entry.path().lexically_normal().string());
    }
  }

  // Newest first: reversed iterators sort in descending order.
  std::sort(found.rbegin(), found.rend());

  std::vector<std::string> paths;
  for (auto& [time, path] : found) paths.push_back(std::move(path));

  return paths;
}

void add_view(const Commands& program) {
  const auto [command, flags] = program.add(
      view_path, "view", "view a cloud or a scan in a window, or draw it into a picture");
  command.add_file("path", flags.path,
                   "a scan folder, a recording, a cloud or a mesh: .ply .pcd .xyz .stl .obj .glb; "
                   "default: choose in the window");

  command.add("--web", flags.web,
              "serve a web page at [ADDRESS:]PORT instead of a window, see live --publish web:");

  add_view_flags(command.app, flags.view);

  // All options added from here on are about scans.
  const std::size_t before = command.app.get_options().size();
  command.add("--minimum-modulation", flags.job.reconstruct.minimum_modulation,
              "minimum modulation of a valid pixel, grey levels of 255");
  add_scan_input_flags(command.app, flags.changes, flags.job);
  add_clean_flags(command.app, flags.job.reconstruct);
  add_anyway_flag(command.app, flags.job.keep_refused);
  flags.of_scans = flags_of_scans(command.app, before);
  add_frame_flag(command.app, flags.job.reconstruct);

  command.common(
      {"--snapshot", "--screenshot", "--size", "--colour", "--web", "--scanner", "--raw"});
  command.examples(
      {"view scan", "view cloud.ply --colour depth --snapshot cloud.png --size 1920x1080"},
      "Drag to turn, with the right button to move, wheel to zoom; Tab hides the panel, Esc "
      "and Enter close the window.");
}

}  // namespace slipstream::app
