#include "app/board_flags.h"
#include "app/live.h"
#include "app/process.h"
#include "slipstream/calibrate/pose_guide.h"
#include "slipstream/codes/registry.h"
#include "slipstream/frames/colour_channels.h"
#include "slipstream/frames/scan_camera.h"
#include "slipstream/io/image_file.h"
#include "slipstream/live/cyclic_scans.h"

namespace slipstream::app {
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
  const SourceFlags& source = flags.source;
  const bool sees_monitor = is_camera(source);
  const int poses = flags.poses.value_or(0);
  require_in_range(poses >= 0 && poses <= most_poses, "--poses", poses,
                   "1 to 1000, or no number to stop automatically");
  require_in_range(flags.settle >= 0 && flags.settle <= 10000, "--settle", flags.settle,
                   "0 to 10000 ms");
  if (flags.monitor) require_sees_monitor(source, *flags.monitor);
  throw_if(flags.poses && !sees_monitor,
           "--poses: {} has no moving board; `slipstream camera serve --boards 12` serves one as a "
           "camera",
           source.source);
  throw_if(
      !flags.monitor && source.camera.trigger == "Software",
      "--trigger Software: no trigger source; add --monitor, or name the camera's trigger line");
  throw_if(flags.poses && source.sequence.axes == "both",
           "--axis both: poses always use both axes; drop --axis");
  throw_if(flags.poses && source.sequence.exposures,
           "--exposures: board poses use a single exposure; use --exposure");
  throw_if(fs::exists(flags.output) &&
               (fs::is_regular_file(flags.output) || !fs::is_empty(flags.output)),
           "{}: already exists; name another", flags.output);
}

/// `projector`: its size in pixels, if known.
SourceRequest request_for(const CaptureFlags& flags, std::optional<Size> projector) {
  SourceRequest request = request_from(flags.source);
  request.scans = flags.poses ? 2 : 1;
  request.as_taken = !flags.poses;
  request.loop = true;  // a single recorded cycle counts as static
  if (!request.sequence.strategy && scheme_of(request.source) != "replay") {
    request.sequence.strategy = default_strategy().name();
  }
  if (projector && !request.sequence.projector) request.sequence.projector = projector;
  return request;
}

/// The pattern pictures of each scan, for a projector driven by this program.
std::vector<std::vector<Image<std::uint8_t>>> pictures_of(const Sequence& sequence,
                                                          bool both_axes) {
  if (!both_axes) return {pictures_to_show(sequence)};
  std::vector<std::vector<Image<std::uint8_t>>> pictures;
  for (const PatternSet& set : along_both_axes(sequence)) {
    pictures.push_back(patterns_in_8_bits(set, sequence.projector));
  }
  return pictures;
}

std::unique_ptr<ScanCamera> scan_camera(const CaptureFlags& flags, const NamedSource& opened,
                                        PatternSink* projector) {
  const Sequence& sequence = opened.sequence;
  if (projector == nullptr) {
    return std::make_unique<CyclicScans>(*opened.frames, sequence, flags.poses ? 2 : 1);
  }
  StepSettings steps{.settling = std::chrono::milliseconds(static_cast<int>(flags.settle)),
                     .triggered = flags.source.camera.trigger == "Software"};
  if (flags.source.sequence.exposures) {
    for (const double ms : sequence.exposures) steps.exposures.push_back(ms / 1e3);
  }
  return std::make_unique<ShownScans>(*projector, *opened.frames,
                                      pictures_of(sequence, flags.poses.has_value()), steps);
}

/// Warns if the source's state has changed since the last call.
std::function<void()> news_of(const FrameSource& source, Output& output) {
  return [&source, &output, told = std::string()]() mutable {
    const std::string state = source.state();
    if (state != std::exchange(told, state)) {
      output.warn(state.empty() ? "the camera is back" : state);
    }
  };
}

std::string headline_of(const PoseProgress& progress, int wanted) {
  const std::string of = wanted > 0 ? fmt::format(" of {}", wanted) : "";
  return fmt::format("{}{}: {}", progress.taken.size(), of, progress.verdict.words);
}

/// The headline, and how to hold the board for the next pose.
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
           fmt::format("{} taken; boards cover {:.0f} % of the camera's picture",
                       progress.taken.size(), 100 * needs.covered),
           "blue: not covered yet; arrows: edges already tilted towards the camera (green), still "
           "to do (orange)"}};
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
  throw_if(opened.sequence.projector == Size{},
           "--projector is missing: give the projector's size in pixels, e.g. 1280x800");
  const CalibrationBoard board = board_from(flags.board);
  const RunEnd end(std::nullopt);
  const auto tell_news = news_of(*opened.frames, output);
  PoseState told = PoseState::taken;
  const auto tell = [&](const PoseProgress& progress) {
    if (desktop.show) desktop.show(guide_of(progress, *flags.poses));
    if (told == progress.verdict.state) return;
    told = progress.verdict.state;
    output.say("{}", line_of(progress, *flags.poses));
  };
  const auto ends = [&] {
    tell_news();
    return end.reached() || desktop.closed();
  };
  const auto save = [](const fs::path& folder, const Scan& scan) {
    save_scan(folder, scan.frames, scan.sequence, std::nullopt);
  };
  const std::size_t taken =
      take_guided_poses(camera, flags.output, board, opened.sequence,
                        {.save = save, .wanted = *flags.poses, .told = tell, .ends = ends})
          .size();
  opened.frames->stop();
  if (!flags.screenshot.empty() && desktop.picture) {
    write_image(flags.screenshot, desktop.picture());
  }
  throw_if(taken == 0, "no pose was taken");
  calibrate_taken(flags, output);
  output.add("poses_taken", taken, "folder", flags.output);
}

/// The frames of one scan, taken once the scene is still.
FrameSet still_frames(ScanCamera& camera, const NamedSource& opened, CaptureDesktop& desktop,
                      Output& output) {
  constexpr double patience = 10;  // s
  const RunEnd end(patience);
  const auto tell_news = news_of(*opened.frames, output);
  bool seen = false;
  while (!end.reached() && !desktop.closed()) {
    tell_news();
    const std::optional<Glimpse> glimpse = camera.look(std::chrono::milliseconds(200));
    seen |= glimpse.has_value();
    if (!glimpse || !glimpse->still) continue;
    if (auto frames = camera.take()) return std::move(frames->front());
  }
  if (end.seconds() < patience) throw Error("stopped before a scan was taken");
  throw WorldError(seen
                       ? "the scene does not stand still; use `slipstream record` for moving scenes"
                       : fmt::format("no complete pattern cycle from {} within {:g} s; check the "
                                     "trigger and that the projector shows patterns",
                                     opened.scanner_name, patience));
}

void take_scan(const CaptureFlags& flags, const NamedSource& opened, ScanCamera& camera,
               CaptureDesktop& desktop, Output& output) {
  Scan scan{.frames = still_frames(camera, opened, desktop, output),
            .sequence = opened.sequence,
            .scanner = opened.scanner};
  opened.frames->stop();
  scan.sequence.marker = false;  // null: not among the frames
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
  if (!several && !opened.in_colour)
    scan = std::move(whole);  // frames out of order are put in order
  save_scan(flags.output, scan.frames, scan.sequence, scan.scanner, std::nullopt, opened.in_colour,
            opened.white);
  output.say("{}: {} frames of {} with {}", flags.output, scan.frames.count(),
             text_of(scan.frames.size()), scan.sequence.strategy.name());
  refuse_or_warn(checked, flags.output, true, output);
  output.document = described("scan", flags.output, "frames", scan.frames.count(), "width",
                              scan.frames.size().width, "height", scan.frames.size().height,
                              "findings", checked.findings);
}

void capture(const CaptureFlags& flags, Output& output) {
  require_good(flags);
  CaptureDesktop desktop = open_desktop(
      {.monitor = flags.monitor, .guides = flags.poses && !flags.headless, .size = flags.size});
  PatternSink* const projector = desktop.projector;
  const NamedSource opened =
      open(request_for(flags, projector != nullptr ? projector->size() : std::nullopt), output);
  opened.frames->start();
  const std::unique_ptr<ScanCamera> camera = scan_camera(flags, opened, projector);
  flags.poses ? take_poses(flags, opened, *camera, desktop, output)
              : take_scan(flags, opened, *camera, desktop, output);
}

}  // namespace

#ifndef SLIPSTREAM_VIEW
CaptureDesktop open_desktop(const DesktopWishes& wishes) {
  if (wishes.monitor) throw Error("--monitor: this build has no monitor support");
  if (wishes.guides) throw Error("this build has no window support; add --headless");
  return {};
}
#endif

void add_capture(const Commands& program) {
  const auto [command, flags] =
      program.add(capture, "capture",
                  "take a scan, or calibrate with --poses, with camera and projector in step");
  SourceFlags& source = flags.source;
  required(command.add_output(
      "-o,--output", flags.output,
      "scan folder or recording (.slip); with --poses: folder for poses, scanner.yaml and report",
      output_folder_type));
  required(command.add("--source", source.source, source_forms()));
  command.add("--monitor", flags.monitor,
              "show the patterns on this monitor, numbered as in `project --list`; default: the "
              "projector loops them by itself");
  command.add("--settle", flags.settle,
              "with --monitor: delay from showing a pattern to taking its frame, ms");
  command
      .add("--poses", flags.poses,
           "take this many board poses, each automatically when it is good, then calibrate; "
           "without a number: until enough")
      ->expected(0, 1)
      ->default_str("0");
  command.add("--headless", flags.headless, "no window; print a line whenever the advice changes");
  command.add("--size", flags.size, "size of the guide window, pixels");
  command.add_output("--screenshot", flags.screenshot, "final picture of the guide window: .png");
  command.add("--rate", source.rate, "frames per second of a free-running camera");
  command.add_file("--scanner", source.scanner, "scanner file to store with the scan");
  add_board_flags(command.app, flags.board);
  add_source_flags(command.app, source, true);
  command.common({"--output", "--source", "--monitor", "--poses", "--corners", "--spacing",
                  "--scanner", "--exposure", "--strategy", "--steps"});
  command.examples(
      {"capture --source aravis: --monitor 1 --exposure 15 --poses --corners 13x9 --spacing 15 -o "
       "poses",
       "capture --source aravis: --monitor 1 --exposure 15 --scanner poses/scanner.yaml -o scan"},
      "Ctrl-C or Esc stops; the poses taken so far are calibrated.");
}

}  // namespace slipstream::app
