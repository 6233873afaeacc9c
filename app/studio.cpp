#include "app/studio.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/board_flags.h"
#include "app/capture.h"
#include "app/guided_poses.h"
#include "app/live_session.h"
#include "app/process.h"
#include "app/session_settings.h"
#include "base/numbers.h"
#include "io/file.h"
#include "io/file_names.h"
#include "io/result_files.h"
#include "slipstream/camera.h"
#include "slipstream/strategy.h"
#include "view/opengl.h"

namespace slipstream::app {
namespace {

constexpr const char* by_itself = "cable or virtual";

enum Choice : std::size_t { camera, projector, patterns, scanner, corners, spacing };

struct Studio {
  LiveFlags flags;  ///< all that the choices leave open
  Output& output;
  std::string first_patterns;  ///< those of the flags
  std::shared_ptr<view::ViewSteps> steps = std::make_shared<view::ViewSteps>();
  std::future<std::vector<CameraDescription>> cameras{};  ///< being searched for

  [[nodiscard]] std::string& chosen(Choice choice) const { return steps->choices[choice].value; }
};

/// "monitor 1: NAME, 1280x800".
std::vector<std::string> projectors() {
  std::vector<std::string> names{by_itself};
  const opengl::WindowSystem system;
  for (const auto& monitor : system.monitors()) {
    names.push_back(
        fmt::format("monitor {}: {}, {}", names.size() - 1, monitor.name, text_of(monitor.size)));
  }
  return names;
}

/// The flags of the source, as chosen.
void set_source(const Studio& studio, SourceFlags& source, std::optional<int>& monitor) {
  source.source = studio.chosen(camera);

  // The first choice is the projector by itself, the others are monitors.
  const std::vector<std::string>& names = studio.steps->choices[projector].options;
  const auto place = std::ranges::find(names, studio.chosen(projector)) - names.begin();
  monitor = place > 0 ? std::optional(static_cast<int>(place) - 1) : std::nullopt;

  // Other patterns than the flags' come with their own settings.
  const std::string& label = studio.chosen(patterns);
  if (label != studio.first_patterns) {
    source.sequence.known = Sequence{.strategy = strategy_labelled(label)};
    source.sequence.strategy = source.sequence.known->strategy.name();
    source.sequence.settings.clear();
  } else if (is_camera(source) && !source.sequence.strategy) {
    source.sequence.strategy = default_strategy().name();
  }

  source.loop = true;
  constexpr double virtual_rate = 60;  // otherwise as fast as possible: no processor is left
  if (source.source == "virtual" && !source.rate) source.rate = virtual_rate;

  const std::string& file = studio.chosen(scanner);
  source.scanner = file.empty() ? std::nullopt : std::optional<fs::path>(file);
}

view::ViewSource dressed(Studio& studio, view::ViewSource source) {
  source.steps = studio.steps;
  source.wording = &with_flags;

  source.openable = [&studio] { return viewable_in(studio.flags.view.save_to); };

  // A scanner file is chosen; anything else is shown.
  source.open = [&studio](const std::string& path) -> std::optional<view::ViewSource> {
    if (const std::string type = lower_case_extension(path); type == ".yaml" || type == ".xml") {
      read_scanner(path);  // throws if it is none
      studio.chosen(scanner) = path;
      return std::nullopt;
    }

    return view_source_of(path, {}, {.reconstruct = studio.flags.settings}, studio.flags.view,
                          studio.output);
  };

  return source;
}

view::ViewSource idle(Studio& studio) {
  return dressed(
      studio,
      {.title = "slipstream studio",
       // Draws nothing; fetches the list of cameras once it is ready.
       .newest =
           [&studio] {
             if (studio.cameras.valid() &&
                 studio.cameras.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
               try {
                 for (const auto& found : studio.cameras.get()) {
                   studio.steps->choices[camera].options.push_back(found.name);
                 }
               } catch (const std::exception& error) {
                 studio.steps->message = with_flags(error.what());
               }
             }
             return view::ShownCloud{};
           },
       .waits_for =
           "Choose camera, projector and patterns at the left, then press Live; virtual needs "
           "no hardware.\n\nWithout a scanner file, press Calibrate first and follow the "
           "guide.\n\nOr drop a scan, a recording, a cloud or a scanner file here."});
}

/// The source that `begin` opens; the idle one, with the reason, if it fails.
view::ViewStep step(Studio& studio, const char* name, char key, const char* help,
                    view::ViewSource (*begin)(Studio&)) {
  return {name, key, help, [&studio, begin] {
            studio.steps->message.clear();
            try {
              return dressed(studio, begin(studio));
            } catch (const std::exception& error) {
              studio.steps->message = with_flags(error.what());
              return idle(studio);
            }
          }};
}

view::ViewSource show_live(Studio& studio) {
  LiveFlags flags = studio.flags;
  set_source(studio, flags.source, flags.monitor);
  const auto session = std::make_shared<LiveSession>(std::move(flags), studio.output);
  session->start();

  view::ViewSource source = session->view_source();
  source.title = "slipstream studio: " + studio.chosen(camera);

  source.opens_saved = has_geometry(session->setup().scanner);
  source.save = [&studio, save = std::move(source.save)](const view::ShownCloud& cloud,
                                                         const EngineSetup& setup) {
    std::string folder = save(cloud, setup);
    studio.output.say("saved: {}", folder);
    return folder;
  };

  // A failed session keeps its last cloud and says why.
  source.newest = [session, &studio, newest = std::move(source.newest)] {
    if (const auto failure = session->pipeline().failure()) {
      try {
        std::rethrow_exception(failure);
      } catch (const std::exception& error) {
        studio.steps->message = with_flags(error.what());
      }
    }
    return newest();
  };

  return source;
}

/// Instructions of the poses, then the verdict; chooses the new scanner file.
std::optional<view::Guide> guide_of(GuidedPoses& poses, const std::string& folder, Studio& studio,
                                    view::Guide& last, bool& reported) {
  // The newest picture of the guide until the poses are over; then the verdict, once.
  if (auto newest = poses.newest()) return last = *std::move(newest);
  if (reported || !poses.over()) return std::nullopt;

  reported = true;

  try {
    last.headline = poses.finish();
    const std::string report = folder + "/report/report.html";
    studio.chosen(scanner) = folder + "/scanner.yaml";
    last.lines = {"scanner file: " + studio.chosen(scanner), "report: " + report,
                  "next: Live, then Capture"};
    last.colour = {128, 217, 140};
  } catch (const std::exception& error) {
    last.headline = with_flags(error.what());
    last.colour = {255, 128, 107};
    last.lines = {"Calibrate again, or take another scanner file."};
  }

  return last;
}

view::ViewSource calibrate(Studio& studio) {
  CaptureFlags flags;
  flags.source = studio.flags.source;

  set_source(studio, flags.source, flags.monitor);

  // The choices are texts, as the window edits them.
  const auto [columns, rows] = corners_from(studio.chosen(corners), "corners");
  flags.board.board.columns = columns;
  flags.board.board.rows = rows;

  const auto spaces = number_in<double>(studio.chosen(spacing));
  throw_if(!spaces, "square '{}': expected a length in mm", studio.chosen(spacing));

  flags.board.board.spacing = *spaces;
  flags.board.has_spacing = true;

  // Automatic end: as many poses as are enough.
  flags.poses = 0;

  flags.output =
      make_free_folder(path_named_by_time(studio.flags.view.save_to, "poses", "")).string();
  const auto poses = std::make_shared<GuidedPoses>(flags, studio.output);

  return {
      .title = "slipstream studio: calibrate",
      .newest = [] { return view::ShownCloud{}; },
      .guide = [poses, &studio, folder = flags.output, last = view::Guide{},
                reported =
                    false]() mutable { return guide_of(*poses, folder, studio, last, reported); }};
}

}  // namespace

void studio(const LiveFlags& flags, Output& output) {
  const std::vector<std::string> monitors = projectors();  // throws without a desktop

  // Choice 0 is the projector by itself; monitor n is choice n + 1.
  const auto monitor = static_cast<std::size_t>(flags.monitor.value_or(-1) + 1);
  throw_if(monitor >= monitors.size(), "--monitor {} does not exist", flags.monitor.value_or(0));

  const std::vector<std::string> labels =
      strategy_labels(default_sequence({1280, 800}, flags.source.sequence).strategy);

  const std::string& source = flags.source.source;
  Studio studio{.flags = flags, .output = output, .first_patterns = labels.front()};
  studio.flags.source.virtual_scanner.idle_step.setZero();  // renders one cycle, not seconds

  // The search for cameras takes a while, so it runs beside the window.
  studio.cameras = std::async(std::launch::async, list_cameras);

  auto& [choices, buttons, message] = *studio.steps;
  choices = {
      {.name = "camera",
       .help = "as for --source",
       .options =
           source == "virtual" ? std::vector{source} : std::vector<std::string>{source, "virtual"},
       .value = source},
      {.name = "projector",
       .help = "a monitor shows the patterns; otherwise the projector and the camera run "
               "in step by themselves",
       .options = monitors,
       .value = monitors[monitor]},
      {.name = "patterns",
       .help = "the projector shows them",
       .options = labels,
       .value = labels.front()},
      {.name = "scanner",
       .help = "scanner file, from Calibrate; may be dropped here. The virtual one needs "
               "none",
       .value = flags.source.scanner.value_or("").string()},
      {.name = "corners", .help = "inner corners of the chessboard", .value = "13x9"},
      {.name = "square mm", .help = "side of a square, as measured on the print", .value = "15"}};

  buttons = {
      step(studio, "Live (L)", 'L', "show live clouds, or pictures without a scanner file",
           show_live),
      step(studio, "Calibrate (C)", 'C', "hold a board in several poses, guided", calibrate)};

  const RunEnd end(std::nullopt);
  view::run_viewer(idle(studio), {.view = flags.view.settings,
                                  .size = flags.view.size,
                                  .ends = [&end] { return end.reached(); }});
}

void add_studio(const Commands& program) {
  const auto [command, flags] =
      program.add(studio, "studio", "one window from camera and projector to a cloud");
  add_live_flags(command, flags);

  for (const char* const of_a_run :
       {"--output", "--model", "--duration", "--frames", "--snapshot", "--screenshot"}) {
    command.app.remove_option(command.app.get_option(of_a_run));
  }

  command.common({"--source", "--monitor", "--scanner", "--strategy", "--steps", "--exposure",
                  "--size", "--save-to"});
  command.examples({"studio", "studio --source aravis: --monitor 1 --exposure 15"});
}

}  // namespace slipstream::app
