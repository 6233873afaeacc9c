#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/board_flags.h"
#include "app/commands.h"
#include "app/process.h"
#include "app/source_flags.h"
#include "app/turntable.h"
#include "base/numbers.h"
#include "base/stopwatch.h"
#include "codes/guard_sequence.h"
#include "io/file.h"
#include "io/file_names.h"
#include "io/image_file.h"
#include "io/scan_folder.h"
#include "simulate/turned_scene.h"
#include "simulate/virtual_files.h"
#include "slipstream/named_scenes.h"
#include "slipstream/scan_files.h"
#include "slipstream/virtual_world.h"

namespace slipstream::app {
namespace {

struct SimulateFlags {
  std::string folder;
  VirtualFlags devices;
  SequenceChanges scan;
  std::optional<int> boards;  ///< poses of a board; empty: a scene
  BoardFlags board;
  bool unquantised = false, in_colour = false, primaries = false;
  int further_cameras = 0;
  bool guard = false;
  double paint = 0;
  TurntableFlags turntable;
};

/// Takes pictures of the scene under each of the projector's colours.
void write_primaries(const SimulateFlags& flags, const VirtualWorld& world, Output& output) {
  const FrameSet frames = take_colour_scan(world.scanner, world.scene, primary_patterns({}),
                                           world.photometry, {usual_mixture, flags.paint})
                              .frames;

  std::vector<fs::path> pictures;
  for (const char* const name : primary_names) {
    pictures.push_back(fs::path(flags.folder) / fmt::format("{}.png", name));
    output.list("pictures").push_back(pictures.back().string());
  }

  make_folder(flags.folder);
  write_colour_frames(pictures, frames);

  output.say("wrote pictures under black, red, green and blue to {}", flags.folder);
}

/// Takes scans of the board along x and y in each pose into folders board01/x, board01/y and so on.
void simulate_boards(const SimulateFlags& flags, const VirtualWorld& world,
                     const Sequence& sequence, Output& output) {
  const fs::path folder = flags.folder;
  const CalibrationBoard board = board_from(flags.board);
  const Scanner& scanner = world.scanner;

  // Both axes must be resolved by the projector, as a pose needs both.
  for (const Axis axis : {Axis::x, Axis::y}) {
    require_resolved(sequence.strategy, axis, scanner.projector.size);
  }

  const Body sheet = sheet_of(board, scanner);
  const int count = *flags.boards;
  std::vector<Eigen::Isometry3d> poses = poses_of(sheet, count, scanner);

  // Nearer to the middle, so that further cameras see the whole board, too.
  for (Eigen::Isometry3d& pose : poses) {
    if (flags.further_cameras == 0) break;
    pose.translation() = (pose.translation() + working_volume(scanner).centre) / 2;
  }

  Progress progress("boards", (1 + flags.further_cameras) * count);
  const Body printed = misprinted(sheet, world.photometry.physics);
  const std::vector<std::string> names =
      save_board_scans(folder, sequence, world, printed, poses, [&] { progress.advance(); });

  // The same poses for further cameras, in folders beside this one.
  std::vector<std::string> further_folders;
  for (int number = 2; number < 2 + flags.further_cameras; ++number) {
    further_folders.push_back(numbered(folder, number).string());
    VirtualWorld posed = world, camera;
    std::vector<Eigen::Isometry3d> seen;
    for (const Eigen::Isometry3d& pose : poses) {
      posed.scene = {printed};
      posed.scene.front().pose = pose;
      camera = seen_from_second(posed, number);
      seen.push_back(camera.scene.front().pose);
    }
    save_board_scans(further_folders.back(), sequence, camera, printed, seen,
                     [&] { progress.advance(); });
  }

  progress.finish();
  output.say("took a board ({}, {}x{}), spacing {:g} mm, in {} poses of {}, into {}",
             name_of(board.kind), board.columns, board.rows, board.spacing, count,
             text_of(scanner.camera.size), folder.string());
  if (!further_folders.empty()) {
    output.say("those of further cameras: {}", fmt::join(further_folders, ", "));
  }
  const auto second_folder =
      further_folders.empty() ? std::nullopt : std::optional(further_folders.front());

  output.document =
      described("folder", folder.string(), "second_folder", second_folder, "poses", names, "width",
                scanner.camera.size.width, "height", scanner.camera.size.height);
}

/// Takes a guard of the same scene after the scan, with other noise.
void add_simulated_guard(ScanFiles& files, const Sequence& sequence, VirtualWorld world) {
  const Sequence guard = guard_sequence(sequence);
  ++world.photometry.seed;
  save_guard(files,
             take_scan(world.scanner, world.scene, pattern_set(guard), world.photometry).frames,
             guard);
}

/// Takes a scan of the object in each position of the table, with its own noise.
void simulate_turns(const SimulateFlags& flags, const VirtualWorld& world, const Sequence& sequence,
                    Output& output) {
  const double step = turn_step(flags.turntable);
  const int views = *flags.turntable.views;
  Progress progress("views", views);

  for (int view = 0; view < views; ++view) {
    VirtualWorld turned = world;
    turned.scene = turned_scene(world.scene, world.scanner, view * step * degree);
    turned.photometry.seed += static_cast<std::uint64_t>(view);
    save_virtual_scan(
        folder_of_view(flags.turntable, flags.folder, view + 1), sequence, turned,
        take_scan(turned.scanner, turned.scene, pattern_set(sequence), turned.photometry));
    progress.advance();
  }
  progress.finish();

  const TurnAxis axis = turntable_axis(world.scanner);
  tell_views(flags.turntable, flags.folder, output);
  describe(output.document, "axis_direction", axis.direction, "axis_point_mm", axis.point);
}

void simulate(const SimulateFlags& flags, Output& output) {
  VirtualWorld world = world_from(flags.devices);
  const Sequence sequence = sequence_for(flags.scan, world.scanner);

  if (flags.unquantised) world.photometry.bits.reset();

  throw_if(flags.paint != 0 && !flags.in_colour && !flags.primaries,
           "--paint needs --colour or --primaries");
  const bool is_one_scan = !flags.boards && !flags.primaries && flags.further_cameras == 0 &&
                           !flags.guard && !flags.turntable.views;
  throw_if(!is_one_scan && lower_case_extension(flags.folder) == ".slip",
           "{}: --boards, --primaries, --second-camera, --guard and --turntable need a folder; a "
           "recording holds one scan",
           flags.folder);
  throw_if(flags.guard && !can_be_guarded(sequence),
           "--guard needs patterns along one axis, and a projector of 64 pixels or more across it");

  if (flags.boards) {
    return simulate_boards(flags, world, sequence, output);
  }

  if (flags.primaries) return write_primaries(flags, world, output);
  if (flags.turntable.views) return simulate_turns(flags, world, sequence, output);

  require_valid(world.photometry);
  output.tell_wait("rendering the frames");
  Stopwatch watch;

  if (flags.in_colour) world.scanner.photometry.colour_mixture = usual_mixture;
  const VirtualScan virtual_scan =
      flags.in_colour
          ? take_colour_scan(world.scanner, world.scene, pattern_set(sequence), world.photometry,
                             {usual_mixture, flags.paint})
          : take_scan(world.scanner, world.scene, pattern_set(sequence), world.photometry);
  const double seconds = watch.lap();

  const fs::path folder = flags.folder;
  tell_replaced(folder, output);
  ScanFiles files = save_virtual_scan(folder, sequence, world, virtual_scan);

  for (int number = 2; number < 2 + flags.further_cameras; ++number) {
    files.further_cameras.push_back(folder / folder_of_camera(static_cast<std::size_t>(number)));
    const VirtualWorld seen = seen_from_second(world, number);
    save_virtual_scan(files.further_cameras.back(), sequence, seen,
                      take_scan(seen.scanner, seen.scene, pattern_set(sequence), seen.photometry));
    write_scan_files(folder / "scan.yaml", files);
  }

  if (flags.guard) add_simulated_guard(files, sequence, world);

  output.say("took {} frames of {} ({}) in {:.2f} s, into {}", virtual_scan.frames.count(),
             text_of(world.scanner.camera.size),
             flags.devices.mesh.value_or(flags.devices.scene).string(), seconds, folder.string());
  output.document = described("scan", folder.string(), "frames", virtual_scan.frames.count(),
                              "width", world.scanner.camera.size.width, "height",
                              world.scanner.camera.size.height, "render_s", seconds);
}

/// Adds --boards, which excludes scene flags and --axis, and the board flags, which need it. Call
/// after the scene flags are added.
void add_boards_flags(CLI::App& simulate, SimulateFlags& flags) {
  CLI::Option* boards = simulate.add_option(
      "--boards", flags.boards,
      "scan a calibration board in this many poses, along x and y, instead of a scene");

  boards->group("Board");

  // The board takes the scene's place, and each pose is scanned along both axes, in grey.
  FlagGroup{simulate}.exclude(
      "--boards",
      {"--scene", "--mesh", "--mesh-size", "--reflectivity", "--move", "--turn", "--vibrate",
       "--breathe", "--axis", "--colour", "--primaries", "--paint", "--guard", "--turntable"});

  add_board_flags(simulate, flags.board);

  for (CLI::Option* option : simulate.get_options()) {
    if (option->get_group() == "Board" && option != boards) option->needs(boards);
  }
}

void add_simulate_flags(CLI::App& command, SimulateFlags& flags) {
  const FlagGroup group{command, "Devices"};
  group.add_file("--scanner", flags.devices.scanner_file,
                 "scanner file to imitate; default: an example");

  group.add("--unquantised", flags.unquantised, "64-bit float frames, neither rounded nor clipped");
  group.app
      .add_flag("--second-camera", flags.further_cameras,
                "add a second camera on the other side of the projector, and given again a third "
                "and so on; their scans go into second/, camera-3/ and so on, boards into folders "
                "beside the first, with -2, -3 and so on in their names")
      ->group(group.name);
  group.add("--colour", flags.in_colour,
            "colour camera and projector: three patterns per picture, with 20 % crosstalk between "
            "channels");

  group.add("--primaries", flags.primaries,
            "take colour pictures of the scene under black, red, green and blue instead");
  group.add("--guard", flags.guard,
            "also take a guard: six frames along the other axis, by which reconstruct and check "
            "see whether the rig has moved since calibration; into guard/");
  group.exclude("--colour", {"--second-camera", "--unquantised", "--primaries", "--guard"});
  group.exclude("--primaries", {"--second-camera", "--unquantised", "--guard"});
  group.exclude("--guard", {"--second-camera"});

  add_turntable_flags(group, flags.turntable);
  group.exclude("--turntable", {"--second-camera", "--colour", "--primaries", "--guard"});
  command.get_option("--turn-step")->needs("--turntable");

  group.add("--paint", flags.paint,
            "with --colour or --primaries: coloured surfaces that absorb up to this share of a "
            "channel's light");
}

}  // namespace

void add_simulate(const Commands& program) {
  const auto [command, flags] =
      program.add(simulate, "simulate", "take a scan with the virtual scanner, with ground truth");
  required(command.add_output("folder", flags.folder,
                              "output folder, or a recording if it ends in .slip",
                              output_folder_type));

  add_virtual_flags(command.app, flags.devices);
  add_simulate_flags(command.app, flags);
  add_pattern_flags(command.app, flags.scan);
  add_boards_flags(command.app, flags);

  command.common({"--scene", "--mesh", "--strategy", "--steps", "--high", "--low", "--camera",
                  "--world", "--exposures", "--boards"});
  command.examples(
      {"simulate scan --scene statue --strategy dual-frequency --steps 3 --high 16 --low 1"});
}

}  // namespace slipstream::app
