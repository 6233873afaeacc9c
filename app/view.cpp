#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/findings.h"
#include "app/live.h"
#include "app/scan_input.h"
#include "app/windows.h"
#include "slipstream/base/error.h"
#include "slipstream/io/cloud_file.h"
#include "slipstream/io/file.h"
#include "slipstream/io/recording.h"
#include "slipstream/reconstruct/engine.h"
#include "slipstream/response/gamma_choice.h"
#include "slipstream/view/view_source.h"
#include "slipstream/view/viewer.h"

namespace slipstream::app {
namespace fs = std::filesystem;
namespace {

struct ViewPathFlags {
  std::string path;
  CloudInputFlags cloud;
  std::vector<const CLI::Option*> of_scans;  ///< flags that are of scans alone
  const CLI::App* command = nullptr;
  ViewFlags view;
  std::string web;  ///< [ADDRESS:]PORT; empty: in a window
};

view::ViewSource source_of_scan(const ViewPathFlags& flags, Output& output) {
  const CloudInputFlags& asked = flags.cloud;
  require_valid(asked.settings.clean);
  Scan scan = load(flags.path, asked.input, false, output);
  const SoundScan sound = sound_scan(scan, flags.path, asked, output);
  const EngineSetup& setup = sound.setup;
  const auto given = sound.gamma.response;
  const auto blind =
      choose_gamma("blind", given, setup.sequence.strategy.layout(), scan.frames).response;
  view::ViewSource source = view::still_source(std::move(scan.frames), setup);
  source.findings = sound.checked.findings;
  source.gammas = {
      {fmt::format("of the {}", asked.input.gamma == "scanner" ? "scanner" : "flag"), given},
      {"none", std::nullopt},
      {"from the frames", blind}};
  source.save = [parent = flags.view.save_to, remarks = doubts(sound.checked.findings)](
                    const view::ShownCloud& cloud, const EngineSetup& used) {
    return save_in_new_folder(cloud.frames, used, parent, remarks);
  };
  return source;
}

/// Scan folders and files in a folder that can be viewed, by name.
std::vector<std::string> viewable_in(const fs::path& folder) {
  std::vector<std::string> paths;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none)) {
    const bool file = is_cloud_file(entry.path()) || lower_case_extension(entry.path()) == ".slip";
    if (file || fs::exists(entry.path() / "scan.yaml", none)) {
      paths.push_back(entry.path().lexically_normal().string());
    }
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

bool is_scan(const std::string& path) {
  return fs::is_directory(path) || is_recording(path);
}

view::ViewSource source_of_cloud(const std::string& path) {
  StoredCloud stored = read_cloud(path);
  return view::still_source(std::move(stored.cloud), std::move(stored.uncertainty));
}

view::ViewSource source_of(const ViewPathFlags& flags, Output& output) {
  view::ViewSource source =
      is_scan(flags.path) ? source_of_scan(flags, output) : source_of_cloud(flags.path);
  source.title = flags.path;
  return source;
}

/// Nothing yet, but files to open.
view::ViewSource source_of_nothing() {
  return {.title = "slipstream view",
          .newest = [] { return view::ShownCloud{}; },
          .waits_for = "Drop a scan folder or a cloud here, or choose one at the left."};
}

/// A page instead of a window: the frames over and over, as live does it.
void serve_page(const ViewPathFlags& flags, Output& output) {
  if (!is_scan(flags.path)) {
    throw Error(
        fmt::format("--web shows scan folders and recordings, which '{}' is not", flags.path));
  }
  const ScanInputFlags& input = flags.cloud.input;
  LiveFlags replay;
  replay.headless = true;
  replay.gamma = input.gamma;
  replay.settings.clean = flags.cloud.settings.clean;
  replay.source.request = {.source = "replay:" + flags.path,
                           .loop = true,
                           .sequence = input.changes.sequence,
                           .scanner = input.changes.scanner};
  if (fs::is_directory(flags.path)) replay.source.request.rate = 60;  // it has no times of its own
  replay.publish = {"web:" + flags.web};
  replay.view = flags.view;
  live(replay, output);
}

void view_path(const ViewPathFlags& flags, Output& output) {
  if (!flags.web.empty()) return serve_page(flags, output);
  require_good(flags.view);
  const bool scan = is_scan(flags.path);
  const bool of_rig = flags.command->count("--rig") > 0;  // which says more than a cloud needs
  for (const CLI::Option* option : flags.of_scans) {
    if (scan || of_rig || option->count() == 0 || !fs::exists(flags.path)) continue;
    throw Error(fmt::format("{}: {} is of scans", flags.path, option->get_name()));
  }
  view::ViewSource source = flags.path.empty() ? source_of_nothing() : source_of(flags, output);
  output.document = {{"path", flags.path}, {"files", nlohmann::json::object()}};
  if (scan) output.document["findings"] = app::json_of(source.findings);
  write_pictures(source, flags.view, true, output);
  if (!output.document["files"].empty()) return;
  const fs::path beside = fs::absolute(flags.path / fs::path()).parent_path().parent_path();
  source.openable = [beside = flags.path.empty() ? fs::current_path() : beside] {
    return viewable_in(beside);
  };
  source.open = [view = flags.view, settings = flags.cloud.settings,
                 &output](const std::string& path) {
    ViewPathFlags other;
    other.path = path;
    other.view = view;
    other.cloud.settings = settings;
    return source_of(other, output);
  };
  view::run_viewer(source, {.view = flags.view.settings, .size = flags.view.size});
}

}  // namespace

void add_view(CLI::App& program, Command& chosen) {
  const auto [command, flags] = add_command(
      program, chosen, view_path, "view", "look at a cloud or a scan, in a window or as a picture");
  command.add_file(
      "path", flags.path,
      "a scan folder, a recording, or a cloud or mesh: .ply .pcd .xyz .stl .obj .glb; chosen "
      "in the window without");
  command.add("--web", flags.web,
              "a page at this [ADDRESS:]PORT in place of a window, as live --publish web: has it");
  add_view_flags(command.app, flags.view);
  const std::size_t before = command.app.get_options().size();
  add_scan_input_flags(command.app, flags.cloud.input);
  add_clean_flags(command.app, flags.cloud.settings);
  add_anyway_flag(command.app, flags.cloud.anyway);
  const std::vector<CLI::Option*> options = command.app.get_options();
  flags.command = &command.app;
  flags.of_scans.assign(options.begin() + static_cast<std::ptrdiff_t>(before), options.end());
  command.app.footer(
      "Examples:\n  slipstream view scan\n  slipstream view cloud.ply --colour depth --snapshot "
      "cloud.png --size 1920x1080\nDrag to turn, with the right button to move, wheel to zoom; "
      "Tab hides the panel, Esc closes.");
}

}  // namespace slipstream::app
