#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/finding_output.h"
#include "app/scan_findings.h"
#include "app/scan_input.h"
#include "app/view_files.h"
#include "slipstream/error/error.h"
#include "slipstream/io/recording.h"
#include "slipstream/io/stored_cloud.h"
#include "slipstream/photometry/gamma_choice.h"
#include "slipstream/reconstruct/engine.h"
#include "slipstream/view/still_source.h"
#include "slipstream/view/viewer.h"

namespace slipstream::app {
namespace fs = std::filesystem;
namespace {

struct ViewPathFlags {
  std::string path;
  ScanInputFlags input;
  bool anyway = false;
  std::vector<const CLI::Option*> of_scans;  ///< flags that are of scans alone
  const CLI::App* command = nullptr;
  ViewFlags view;
};

view::ViewSource source_of_scan(const ViewPathFlags& flags, Output& output) {
  Scan scan = load(flags.path, flags.input, false, output);
  EngineSetup setup = setup_for(scan);
  const std::optional<MeasuredResponse> of_scanner = setup.scanner.photometry.response;
  choose_response(scan, flags.input);
  require_reconstructible(setup);
  CheckedScan checked = check_and_repair(scan);
  refuse_or_warn(checked, flags.path, flags.anyway, output);
  const auto response_by = [&](const std::string& how) {
    return choose_gamma(how, of_scanner, setup.sequence.strategy.layout(), scan.frames).response;
  };
  const auto given = response_by(flags.input.gamma), blind = response_by("blind");
  setup.scanner.photometry.response = given;
  view::ViewSource source = view::still_source(std::move(scan.frames), setup);
  source.findings = std::move(checked.findings);
  source.gammas = {{"as given", given}, {"none", std::nullopt}, {"blind", blind}};
  source.save = [view = flags.view](const view::ShownCloud& cloud, const EngineSetup& used) {
    return save_in_new_folder(cloud, used, view);
  };
  return source;
}

void view_path(const ViewPathFlags& flags, Output& output) {
  require_good(flags.view);
  const bool scan = fs::is_directory(flags.path) || is_recording(flags.path);
  const bool of_rig = flags.command->count("--rig") > 0;  // which says more than a cloud needs
  for (const CLI::Option* option : flags.of_scans) {
    if (scan || of_rig || option->count() == 0 || !fs::exists(flags.path)) continue;
    throw Error(fmt::format("{}: {} is of scans", flags.path, option->get_name()));
  }
  view::ViewSource source =
      scan ? source_of_scan(flags, output) : view::still_source(read_cloud(flags.path).cloud);
  source.title = flags.path;
  output.document = {{"path", flags.path}, {"files", nlohmann::json::object()}};
  if (scan) output.document["findings"] = app::json_of(source.findings);
  write_snapshot(source, flags.view, output);
  write_screenshot(source, flags.view, output);
  if (output.document["files"].empty()) {
    view::run_viewer(source,
                     {.view = view_settings_from(flags.view), .size = size_from(flags.view)});
  }
}

}  // namespace

void add_view(CLI::App& program, Command& chosen) {
  const auto [command, flags] = add_command(
      program, chosen, view_path, "view", "look at a cloud or a scan, in a window or as a picture");
  command.add("path", flags.path, "a cloud or a mesh, a scan folder or a recording")->required();
  add_view_flags(command.app, flags.view);
  const std::size_t before = command.app.get_options().size();
  add_scan_input_flags(command.app, flags.input);
  add_anyway_flag(command.app, flags.anyway);
  const std::vector<CLI::Option*> options = command.app.get_options();
  flags.command = &command.app;
  flags.of_scans.assign(options.begin() + static_cast<std::ptrdiff_t>(before), options.end());
  command.app.footer(
      "Examples:\n  slipstream view scan\n  slipstream view cloud.ply --colour depth --snapshot "
      "cloud.png --size 1920x1080\nDrag to turn, with the right button to move, wheel to zoom; "
      "Tab hides the panel, Esc closes.");
}

}  // namespace slipstream::app
