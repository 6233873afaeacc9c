#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "app/board_flags.h"
#include "app/commands.h"
#include "app/findings.h"
#include "app/process.h"
#include "app/scan_flags.h"
#include "app/source_flags.h"
#include "app/windows.h"
#include "slipstream/base/error.h"
#include "slipstream/calibrate/pose_guide.h"
#include "slipstream/codes/pattern_set.h"
#include "slipstream/codes/registry.h"
#include "slipstream/frames/colour_channels.h"
#include "slipstream/frames/scan_camera.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/saved_scan.h"
#include "slipstream/live/cyclic_scans.h"

namespace slipstream::app {
namespace fs = std::filesystem;
namespace {

struct CaptureFlags {
  std::string output;
  SourceFlags source;
  std::optional<int> monitor;
  double settle = 100;  ///< ms
  std::optional<int> poses;
  BoardFlags board;
  bool headless = false;
  Size size{1280, 800};
  std::string screenshot;
};

void require_good(const CaptureFlags& flags) {
  constexpr int most_poses = 1000;
  if (flags.poses && (*flags.poses < 0 || *flags.poses > most_poses)) {
    throw Error(
        fmt::format("--poses {} is out of range; 1 to {}, or no number until there are "
                    "enough",
                    *flags.poses, most_poses));
  }
  if (!(flags.settle >= 0 && flags.settle <= 10000)) {
    throw Error(fmt::format("--settle {} is out of range; 0 to 10000 ms", flags.settle));
  }
  const SourceRequest& request = flags.source.request;
  const std::string scheme = scheme_of(request.source);
  if (flags.monitor && (scheme == "virtual" || scheme == "replay")) {
    throw Error(fmt::format("--monitor {}: {} sees no monitor; leave it out", *flags.monitor,
                            request.source));
  }
  if (flags.monitor && request.camera.pixel_format == PixelFormat::rgb8) {
    throw Error(
        "--pixel-format RGB8: --monitor shows patterns in grey; Mono8 takes them, or "
        "`slipstream project --colour` shows them in colour");
  }
  if (flags.poses && (scheme == "virtual" || scheme == "replay")) {
    throw Error(
        fmt::format("--poses: nobody moves a board before {}; `slipstream camera serve "
                    "--boards 12` serves one as a camera",
                    request.source));
  }
  if (!flags.monitor && request.camera.trigger == "Software") {
    throw Error("--trigger Software: nothing says when; give --monitor too, or the camera's line");
  }
  if (flags.poses && request.sequence.axes == "both") {
    throw Error("--axis both: poses are taken along both axes as it is; leave it out");
  }
  if (flags.poses && request.sequence.exposures) {
    throw Error("--exposures: the poses of a board are taken with one, --exposure");
  }
  if (fs::exists(flags.output) &&
      (fs::is_regular_file(flags.output) || !fs::is_empty(flags.output))) {
    throw Error(fmt::format("{}: is there already; name another", flags.output));
  }
}

/// `projector`: its pixels, where they are known.
SourceRequest request_for(const CaptureFlags& flags, std::optional<Size> projector) {
  SourceRequest request = request_from(flags.source);
  request.scans = flags.poses ? 2 : 1;
  request.as_taken = !flags.poses;
  request.loop = true;  // a single recorded cycle stands still before itself
  if (!request.sequence.strategy && scheme_of(request.source) != "replay") {
    request.sequence.strategy = default_strategy().name();
  }
  if (projector && !request.sequence.projector) request.sequence.projector = projector;
  return request;
}

/// The pictures of each scan, for a projector that is fed here.
std::vector<std::vector<Image<std::uint8_t>>> pictures_of(Sequence sequence, bool both_axes) {
  sequence.marker = false;
  require_shown(sequence);
  std::vector<PatternSet> sets{pattern_set(sequence)};
  if (both_axes) sets = along_both_axes(sequence);
  std::vector<std::vector<Image<std::uint8_t>>> pictures;
  for (const PatternSet& set : sets) {
    pictures.push_back(patterns_in_8_bits(set, sequence.projector));
  }
  return pictures;
}

/// Those of --exposures; none where it is not given.
std::vector<double> exposures_in_seconds(const CaptureFlags& flags, const Sequence& sequence) {
  std::vector<double> seconds;
  if (!flags.source.request.sequence.exposures) return seconds;
  for (const double ms : sequence.exposures) seconds.push_back(ms / 1e3);
  return seconds;
}

std::unique_ptr<ScanCamera> scan_camera(const CaptureFlags& flags, const NamedSource& opened,
                                        PatternSink* projector) {
  const Sequence& sequence = opened.sequence;
  if (projector != nullptr) {
    const StepSettings steps{.settling = std::chrono::milliseconds(static_cast<int>(flags.settle)),
                             .triggered = flags.source.request.camera.trigger == "Software",
                             .exposures = exposures_in_seconds(flags, sequence)};
    return std::make_unique<ShownScans>(*projector, *opened.frames,
                                        pictures_of(sequence, flags.poses.has_value()), steps);
  }
  return std::make_unique<CyclicScans>(*opened.frames, sequence, flags.poses ? 2 : 1);
}

/// What is amiss with the source, told where it changes.
class SourceNews {
 public:
  explicit SourceNews(const FrameSource& source) : source_(source) {}

  void tell(Output& output) {
    const std::string state = source_.state();
    if (state == told_) return;
    output.warn(state.empty() ? "the camera is back" : state);
    told_ = state;
  }

 private:
  const FrameSource& source_;
  std::string told_;
};

std::string headline_of(const PoseProgress& progress, int wanted) {
  const std::string of = wanted > 0 ? fmt::format(" of {}", wanted) : "";
  return fmt::format("{}{}: {}", progress.taken.size(), of, progress.verdict.words);
}

/// The headline, and how to hold the board next once this pose is over.
std::string line_of(const PoseProgress& progress, int wanted) {
  const PoseState state = progress.verdict.state;
  const bool over = state == PoseState::taken || state == PoseState::known;
  const std::string& advice = progress.needs.advice;
  return headline_of(progress, wanted) + (over && !advice.empty() ? "; next: " + advice : "");
}

view::Guide guide_of(const PoseProgress& progress, int wanted) {
  const PoseNeeds& needs = progress.needs;
  return {drawn_guide(progress.pictures.mean, progress.verdict, needs, progress.taken),
          headline_of(progress, wanted),
          colour_of(progress.verdict.state),
          {needs.enough ? "enough poses: calibrating" : "next: " + needs.advice,
           fmt::format("{} taken; boards covered {:.0f} % of the camera's picture",
                       progress.taken.size(), 100 * needs.covered),
           "blue: no board was here yet; arrows: the edge that was nearer once (green), or has yet "
           "to be (orange)"}};
}

void calibrate_taken(const CaptureFlags& flags, Output& output) {
  const fs::path folder = flags.output;
  CalibrateGeometryFlags calibration;
  calibration.boards.folder = folder;
  calibration.boards.board = flags.board;
  calibration.scanner = folder / "scanner.yaml";
  calibration.report = folder / "report";
  calibrate_boards(calibration, output);
}

void take_poses(const CaptureFlags& flags, const NamedSource& opened, ScanCamera& camera,
                CaptureDesktop& desktop, Output& output) {
  if (opened.sequence.projector == Size{}) {
    throw Error("--projector is missing: the pixels of what shows the patterns, as 1280x800");
  }
  const CalibrationBoard board = board_from(flags.board);
  const RunEnd end(std::nullopt);
  SourceNews news(*opened.frames);
  PoseState told = PoseState::taken;
  const auto tell = [&](const PoseProgress& progress) {
    if (desktop.show) desktop.show(guide_of(progress, *flags.poses));
    if (told == progress.verdict.state) return;
    told = progress.verdict.state;
    output.say("{}", line_of(progress, *flags.poses));
    std::fflush(stdout);  // who reads it through a pipe moves the board by it
  };
  const auto ends = [&] {
    news.tell(output);
    return end.reached() || desktop.closed();
  };
  GuidedPosesSettings settings;
  settings.wanted = *flags.poses;
  settings.told = tell;
  settings.ends = ends;
  const std::size_t taken =
      take_guided_poses(camera, flags.output, board, opened.sequence, settings).size();
  opened.frames->stop();
  if (!flags.screenshot.empty() && desktop.picture) {
    write_image(flags.screenshot, desktop.picture());
  }
  if (taken == 0) throw Error("no pose was taken");
  calibrate_taken(flags, output);
  output.document["poses_taken"] = taken;
  output.document["folder"] = flags.output;
}

/// The frames of one scan, once nothing moves.
FrameSet still_frames(ScanCamera& camera, const NamedSource& opened, CaptureDesktop& desktop,
                      Output& output) {
  constexpr double patience = 10;  // s
  const RunEnd end(patience);
  SourceNews news(*opened.frames);
  bool seen = false;
  while (!end.reached() && !desktop.closed()) {
    news.tell(output);
    const std::optional<Glimpse> glimpse = camera.look(std::chrono::milliseconds(200));
    seen |= glimpse.has_value();
    if (!glimpse || !glimpse->still) continue;
    if (auto frames = camera.take()) return std::move(frames->front());
  }
  if (end.seconds() < patience) throw Error("ended before a scan was taken");
  throw WorldError(
      seen ? "what the camera sees does not stand still; `slipstream record` keeps what moves"
           : fmt::format("no whole cycle of patterns came from {} in {:g} s; is it triggered, or "
                         "the projector showing?",
                         opened.scanner_name, patience));
}

void take_scan(const CaptureFlags& flags, const NamedSource& opened, ScanCamera& camera,
               CaptureDesktop& desktop, Output& output) {
  Scan scan{.frames = still_frames(camera, opened, desktop, output),
            .sequence = opened.sequence,
            .scanner = opened.scanner};
  opened.frames->stop();
  scan.sequence.marker = false;  // none of the frames is one
  if (scan.scanner) {
    scan.scanner =
        completed(*scan.scanner, opened.scanner_name, scan.frames.size(), scan.sequence.projector);
  }
  const bool several = frame_count(scan.sequence) > frame_count(scan.sequence.strategy);
  Scan whole = scan;
  if (opened.in_colour && scan.scanner && scan.scanner->photometry.colour_mixture) {
    whole.frames = unmixed(scan.frames, *scan.scanner->photometry.colour_mixture, opened.white);
  }
  if (several) whole = merged(std::move(whole));
  const CheckedScan checked = check_and_repair(whole);
  if (!several && !opened.in_colour) scan = std::move(whole);  // slipped frames are put in order
  save_scan(flags.output, scan.frames, scan.sequence, scan.scanner, std::nullopt, opened.in_colour,
            opened.white);
  output.say("{}: {} frames of {} with {}", flags.output, scan.frames.count(),
             text_of(scan.frames.size()), scan.sequence.strategy.name());
  refuse_or_warn(checked, flags.output, true, output);
  output.document = {{"scan", flags.output},
                     {"frames", scan.frames.count()},
                     {"width", scan.frames.size().width},
                     {"height", scan.frames.size().height},
                     {"findings", app::json_of(checked.findings)}};
}

void capture(const CaptureFlags& flags, Output& output) {
  require_good(flags);
  CaptureDesktop desktop = open_desktop(
      {.monitor = flags.monitor, .guides = flags.poses && !flags.headless, .size = flags.size});
  PatternSink* const projector = desktop.projector;
  const NamedSource opened =
      open_source(request_for(flags, projector != nullptr ? projector->size() : std::nullopt));
  if (!opened.warning.empty()) output.warn(opened.warning);
  opened.frames->start();
  const std::unique_ptr<ScanCamera> camera = scan_camera(flags, opened, projector);
  if (flags.poses) {
    take_poses(flags, opened, *camera, desktop, output);
  } else {
    take_scan(flags, opened, *camera, desktop, output);
  }
}

}  // namespace

#ifndef SLIPSTREAM_VIEW
CaptureDesktop open_desktop(const DesktopWishes& wishes) {
  if (wishes.monitor) throw Error("--monitor: this build shows nothing on monitors");
  if (wishes.guides) throw Error("this build has no windows; add --headless");
  return {};
}
#endif

void add_capture(CLI::App& program, Command& chosen) {
  const auto [command, flags] =
      add_command(program, chosen, capture, "capture",
                  "take a scan, or with --poses a calibration, with camera and projector in step");
  SourceRequest& request = flags.source.request;
  command
      .add("-o,--output", flags.output,
           "a scan folder, or a recording (.slip); with --poses the folder of the poses, their "
           "scanner.yaml and report")
      ->required();
  command.add("--source", request.source, source_forms())->required()->default_str("");
  command.add("--monitor", flags.monitor,
              "shows the patterns on that monitor, by its number in `project --list`; without, "
              "the projector shows them over and over by itself");
  command.add("--settle", flags.settle,
              "with --monitor: ms from when a pattern is shown until a frame may begin");
  command
      .add("--poses", flags.poses,
           "so many poses of a board, each taken by itself when it is good, then calibrates; "
           "without a number until there are enough")
      ->expected(0, 1)
      ->default_str("0");
  command.add("--headless", flags.headless, "no window: a line whenever the verdict changes");
  add_size_flag(command, flags.size, "of the window that guides, pixels");
  command.add_output("--screenshot", flags.screenshot, "that window as it was last: .png");
  command.add("--rate", request.rate, "frames per second of a camera that runs freely");
  command.add_file("--scanner", request.scanner, "scanner file, which is kept with the scan");
  add_board_flags(command.app, flags.board);
  add_camera_flags(command.app, request.camera);
  add_pattern_flags(command.app, request.sequence);
  add_marker_flag(command.app, request.sequence);
  add_virtual_flags(command.app, flags.source.world);
  command.app.footer(
      "Examples:\n  slipstream capture --source aravis: --monitor 1 --exposure 15 --poses "
      "--corners 13x9 --spacing 15 -o poses\n  slipstream capture --source aravis: --monitor 1 "
      "--exposure 15 --scanner poses/scanner.yaml -o scan\nCtrl-C or Esc ends it; the poses taken "
      "until then are calibrated.");
}

}  // namespace slipstream::app
