#include "app/capture.h"

#include <chrono>
#include <cstdint>
#include <functional>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/capture_exposure.h"
#include "app/guided_poses.h"
#include "app/process.h"
#include "app/rig_guard.h"
#include "base/numbers.h"
#include "codes/guard_sequence.h"
#include "frames/colour_channels.h"
#include "frames/mosaic.h"
#include "io/image_file.h"
#include "io/replay_source.h"
#include "io/scan_folder.h"
#include "live/cyclic_scans.h"
#include "simulate/turned_scene.h"
#include "slipstream/scan_files.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_world.h"

namespace slipstream::app {
namespace {

void require_good(const CaptureFlags& flags) {
  constexpr int most_poses = 1000;
  const SourceFlags& source = flags.source;

  if (flags.automatic) require_automatic_possible(flags);

  const int poses = flags.poses.value_or(0);
  require_in_range(poses >= 0 && poses <= most_poses, "--poses", poses,
                   "1 to 1000, or no number to stop automatically");
  require_in_range(flags.settle >= 0 && flags.settle <= 10000, "--settle", flags.settle,
                   "0 to 10000 ms");

  if (flags.monitor) require_sees_monitor(source, *flags.monitor);
  throw_if(flags.poses && scheme_of(source.source) == "replay",
           "--poses: {} has no moving board; use a camera, or virtual", source.source);
  throw_if(
      !flags.monitor && source.camera.trigger == "Software",
      "--trigger Software: no trigger source; add --monitor, or name the camera's trigger line");

  // A board pose is two scans of one exposure.
  throw_if(flags.poses && source.sequence.axes == "both",
           "--axis both: poses always use both axes; drop --axis");
  throw_if(flags.poses && source.sequence.exposures,
           "--exposures: board poses use a single exposure; use --exposure");

  // Views of an object that turns.
  throw_if(flags.turntable.views && scheme_of(source.source) == "replay",
           "--turntable: {} shows no object that turns; use a camera, or virtual", source.source);
  throw_if(flags.turntable.views && lower_case_extension(flags.output) == ".slip",
           "{}: --turntable needs a folder; a recording holds one scan", flags.output);

  throw_if(fs::exists(flags.output) &&
               (fs::is_regular_file(flags.output) || !fs::is_empty(flags.output)),
           "{}: already exists; name another", flags.output);
}

/// `projector`: its size in pixels, if known.
SourceRequest request_for(const CaptureFlags& flags, std::optional<Size> projector) {
  SourceRequest request = request_from(flags.source);

  // A pose is two scans, along x and along y; a single scan keeps colour pictures whole.
  request.scans = flags.poses ? 2 : 1;
  const bool is_saved = !flags.poses && !flags.output.empty();
  request.as_taken = is_saved;
  request.loop = true;  // a single recorded cycle counts as static

  // Without a choice of patterns the default ones are shown; a replay has its own.
  if (!request.sequence.strategy && scheme_of(request.source) != "replay") {
    request.sequence.strategy = default_strategy().name();
  }

  if (projector && !request.sequence.projector) request.sequence.projector = projector;

  // A folder keeps the mosaic of a colour sensor, from which clouds get their colours.
  request.camera.keep_mosaic = is_saved && lower_case_extension(flags.output) != ".slip";
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

/// The virtual scanner, and a board held in front of it in one pose after another.
NamedSource virtual_boards(const CaptureFlags& flags, const SourceRequest& request) {
  constexpr int several = 12, still_cycles = 6;
  const VirtualWorld& world = *request.world;
  NamedSource boards{.sequence = sequence_for(request.sequence, world.scanner),
                     .scanner_name = "the virtual scanner"};

  const int poses = *flags.poses == 0 ? several : *flags.poses;
  boards.frames = std::make_unique<VirtualCamera>(
      shown_boards(flags.board, poses, still_cycles, world, boards.sequence),
      request.rate == 0.0 ? std::nullopt : request.rate);

  return boards;
}

/// The guard of a scan whose patterns this program shows in grey, if a folder can hold it.
std::optional<Sequence> chosen_guard(const CaptureFlags& flags, const NamedSource& opened,
                                     const PatternSink* projector) {
  const bool is_possible = projector != nullptr && !flags.poses && !opened.in_colour &&
                           lower_case_extension(flags.output) != ".slip" &&
                           can_be_guarded(opened.sequence);
  if (!is_possible || flags.no_guard) return std::nullopt;
  return guard_sequence(opened.sequence);
}

/// `guard`: patterns to show after those of a scan.
std::unique_ptr<ScanCamera> scan_camera(const CaptureFlags& flags, const NamedSource& opened,
                                        PatternSink* projector,
                                        const std::optional<Sequence>& guard) {
  const Sequence& sequence = opened.sequence;

  // The projector loops the patterns by itself, and the camera finds where a cycle begins.
  if (projector == nullptr) {
    return std::make_unique<CyclicScans>(*opened.frames, sequence, flags.poses ? 2 : 1);
  }

  // This program shows each pattern and takes a frame of it.
  StepSettings steps{.settling = std::chrono::milliseconds(static_cast<int>(flags.settle)),
                     .triggered = flags.source.camera.trigger == "Software"};
  if (flags.source.sequence.exposures) {
    for (const double ms : sequence.exposures) steps.exposures.push_back(ms / 1e3);
  }

  auto pictures = pictures_of(sequence, flags.poses.has_value());
  if (guard) pictures.push_back(pictures_to_show(*guard));
  return std::make_unique<ShownScans>(*projector, *opened.frames, std::move(pictures), steps);
}

/// Writes the guard beside a saved scan and compares both; its findings are added.
void add_guard(ScanFiles& files, Scan scan, FrameSet frames, const Sequence& guard,
               CheckedScan& checked, Output& output) {
  save_guard(files, frames, guard);
  if (!scan.scanner || any_wrong(checked.findings)) return;

  scan.guard.push_back(merged({.frames = std::move(frames), .sequence = guard}));
  GuardResult result = compared_with_guard(scan, {}, output);
  std::ranges::move(result.findings, std::back_inserter(checked.findings));
}

/// The grey levels of a colour sensor's raw frames.
FrameSet grey_frames(const FrameViews& raw, const std::string& name) {
  std::vector<Frame> frames = frames_of(raw, name);
  for (Frame& frame : frames) make_grey(frame);
  return frame_set_of(std::move(frames));
}

void take_scan(const CaptureFlags& flags, const CaptureRig& rig, Output& output) {
  const NamedSource& opened = rig.opened;
  const std::string& mosaic = flags.source.camera.mosaic;
  const bool is_raw = !mosaic.empty() && lower_case_extension(flags.output) != ".slip";

  // 1. Take the frames of one scan, and of its guard.
  std::vector<FrameSet> taken = still_frames(rig, output);
  Scan scan{
      .frames = std::move(taken.front()), .sequence = opened.sequence, .scanner = opened.scanner};
  opened.frames->stop();

  scan.sequence.marker = false;  // null: not among the frames
  if (scan.scanner) {
    scan.scanner =
        completed(*scan.scanner, opened.scanner_name, scan.frames.size(), scan.sequence.projector);
  }

  // 2. Check the scan as reconstruct will see it: colours unmixed, exposures merged.
  const bool several = frame_count(scan.sequence) > frame_count(scan.sequence.strategy);
  Scan whole = scan;
  if (opened.in_colour && scan.scanner && scan.scanner->photometry.colour_mixture) {
    whole.frames = unmixed(scan.frames, *scan.scanner->photometry.colour_mixture, opened.white);
  }
  if (is_raw) whole.frames = grey_frames(scan.frames, flags.output);
  if (several) whole = merged(std::move(whole));

  CheckedScan checked = check_and_repair(whole);

  // 3. Save the frames as taken: only unmerged grey frames can be saved in the repaired order.
  if (!several && !opened.in_colour && !is_raw) scan = whole;  // its frames are in order
  ScanFiles files = save_scan(flags.output, scan.frames, scan.sequence,
                              {.scanner = scan.scanner,
                               .in_colour = opened.in_colour,
                               .white = opened.white,
                               .temperatures = temperatures_of(*opened.frames)});
  if (is_raw) {
    files.mosaic = mosaic;
    write_scan_files(files.path / "scan.yaml", files);
  }
  if (rig.guard) {
    if (is_raw) taken.back() = grey_frames(taken.back(), flags.output);
    add_guard(files, std::move(whole), std::move(taken.back()), *rig.guard, checked, output);
  }

  output.say("{}: {} frames of {} with {}", flags.output, scan.frames.count(),
             text_of(scan.frames.size()), scan.sequence.strategy.name());
  refuse_or_warn(checked, flags.output, true, output);

  output.document.update(described("scan", flags.output, "frames", scan.frames.count(), "width",
                                   scan.frames.size().width, "height", scan.frames.size().height,
                                   "findings", checked.findings));
}

/// Takes poses while a window shows the guide; closing it ends them.
void take_poses_in_window(const CaptureFlags& flags, Output& output) {
#ifdef SLIPSTREAM_VIEW
  GuidedPoses poses(flags, output);

  const RunEnd end(std::nullopt);
  const auto last = view::run_viewer({.title = "slipstream capture",
                                      .newest = [] { return view::ShownCloud{}; },
                                      .guide = [&poses] { return poses.newest(); }},
                                     {.size = flags.size,
                                      .ends = [&] { return end.reached() || poses.over(); },
                                      .keep_last = !flags.screenshot.empty()});

  if (last) write_image(flags.screenshot, *last);
  poses.finish();
#endif
}

/// Takes a scan in each position of the table.
void take_turns(const CaptureFlags& flags, Output& output) {
  const double step = turn_step(flags.turntable);
  const CaptureFlags chosen = flags.automatic ? with_chosen_exposures(flags, output) : flags;
  const nlohmann::json document = output.document;  // with the chosen exposures
  const bool is_virtual = scheme_of(flags.source.source) == "virtual";

  for (int view = 1; view <= *flags.turntable.views; ++view) {
    // The virtual table turns by itself.
    const bool by_hand = !is_virtual || !flags.turntable.command.empty();
    if (view > 1 && by_hand) turn_table(flags.turntable, view, output);

    CaptureFlags of_view = chosen;
    of_view.output = folder_of_view(flags.turntable, flags.output, view);
    const CaptureRig rig = open_rig(of_view, output, (view - 1) * step);
    take_scan(of_view, rig, output);
  }

  output.document = document;
  tell_views(flags.turntable, flags.output, output);
}

void capture(const CaptureFlags& flags, Output& output) {
  require_good(flags);
  if (flags.turntable.views) return take_turns(flags, output);
  if (flags.poses && !flags.headless) {
    require_desktop();
    return take_poses_in_window(flags, output);
  }

  if (flags.automatic) {
    const CaptureFlags chosen = with_chosen_exposures(flags, output);
    return take_scan(chosen, open_rig(chosen, output), output);
  }

  const CaptureRig rig = open_rig(flags, output);
  if (!flags.poses) return take_scan(flags, rig, output);

  const RunEnd end(std::nullopt);
  take_poses(
      flags, rig, {}, [&] { return end.reached() || rig.projector.closed(); }, output);
}

}  // namespace

CaptureRig open_rig(const CaptureFlags& flags, Output& output, double turn) {
  require_good(flags);
  CaptureRig rig{.projector = open_projector(flags.monitor)};
  PatternSink* const projector = rig.projector.sink;
  SourceRequest request =
      request_for(flags, projector != nullptr ? projector->size() : std::nullopt);
  if (flags.turntable.views && request.world) {
    VirtualWorld& world = *request.world;
    world.scene = turned_scene(world.scene, world.scanner, turn * degree);
    world.photometry.seed += static_cast<std::uint64_t>(std::abs(turn) * 1e3);
  }

  const bool boards = flags.poses && scheme_of(request.source) == "virtual";
  rig.opened = boards ? virtual_boards(flags, request) : open(request, output);
  rig.opened.frames->start();

  rig.guard = chosen_guard(flags, rig.opened, projector);
  rig.camera = scan_camera(flags, rig.opened, projector, rig.guard);
  return rig;
}

std::vector<FrameSet> still_frames(const CaptureRig& rig, Output& output) {
  const auto& [projector, opened, camera, guard] = rig;
  constexpr double patience = 10;  // s
  const RunEnd end(patience);
  const auto tell_news = news_of(*opened.frames, output);

  bool seen = false;
  while (!end.reached() && !projector.closed()) {
    tell_news();
    const std::optional<Glimpse> glimpse = camera->look(std::chrono::milliseconds(200));
    seen |= glimpse.has_value();

    if (!glimpse || !glimpse->still) continue;
    if (auto frames = camera->take()) return *std::move(frames);
  }

  // The patience is 10 s: either the scene moves, or no whole cycle of patterns arrives.
  if (end.seconds() < patience) throw Error("stopped before a scan was taken");
  throw WorldError(seen
                       ? "the scene does not stand still; use `slipstream record` for moving scenes"
                       : fmt::format("no complete pattern cycle from {} within {:g} s; check the "
                                     "trigger and that the projector shows patterns",
                                     opened.scanner_name, patience));
}

void add_monitor_flags(const FlagGroup& command, CaptureFlags& flags) {
  command.add("--monitor", flags.monitor,
              "show the patterns on this monitor, numbered as in `project --list`; default: the "
              "projector loops them by itself");
  command.add("--settle", flags.settle,
              "with --monitor: delay from showing a pattern to taking its frame, ms");
  command.add("--rate", flags.source.rate, "frames per second of a free-running camera");
}

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
  add_monitor_flags(command, flags);
  command.add("--no-guard", flags.no_guard,
              "with --monitor: do not take the guard, six frames along the other axis by which "
              "reconstruct and check see whether the rig has moved since calibration");

  command
      .add("--poses", flags.poses,
           "take this many board poses, each automatically when it is good, then calibrate; "
           "without a number: until enough")
      ->expected(0, 1)
      ->default_str("0");

  command
      .add("--auto", flags.automatic,
           "choose the exposures by scans of the scene, and take the scan with them, all within "
           "this many seconds; without a number: 20")
      ->expected(0, 1)
      ->default_str("20");

  add_turntable_flags(command, flags.turntable);
  command.add(
      "--turn-command", flags.turntable.command,
      "with --turntable: command that turns the table before each further view, with {step} "
      "in degrees and {view}; default: wait for Enter. Not from a rig file");
  command.exclude("--turntable", {"--poses"});
  for (const char* const flag : {"--turn-step", "--turn-command"}) {
    command.app.get_option(flag)->needs("--turntable");
  }

  command.add("--headless", flags.headless, "no window; print a line whenever the advice changes");
  command.add("--size", flags.size, "size of the guide window, pixels");
  command.add_output("--screenshot", flags.screenshot, "final picture of the guide window: .png");

  command.add_file("--scanner", source.scanner, "scanner file to store with the scan");

  add_board_flags(command.app, flags.board);
  add_source_flags(command.app, source, true);

  command.common({"--output", "--source", "--monitor", "--poses", "--corners", "--spacing",
                  "--scanner", "--exposure", "--strategy", "--steps"});
  command.examples(
      {"capture --source aravis: --monitor 1 --exposure 15 --poses --corners 13x9 --spacing 15 -o "
       "poses",
       "capture --source aravis: --monitor 1 --exposure 15 --scanner poses/scanner.yaml -o scan",
       "capture --source aravis: --monitor 1 --scanner poses/scanner.yaml --turntable 12 -o views"},
      "Ctrl-C, or Esc and Enter, stops; the poses taken so far are calibrated.");
}

}  // namespace slipstream::app
