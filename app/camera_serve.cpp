#include <chrono>
#include <cstdio>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "app/board_flags.h"
#include "app/commands.h"
#include "app/process.h"
#include "app/scan_flags.h"
#include "app/source_flags.h"
#include "slipstream/base/error.h"
#include "slipstream/devices/virtual_gige_camera.h"
#include "slipstream/io/scanner_file.h"
#include "slipstream/simulate/boards.h"
#include "slipstream/simulate/virtual_camera.h"

namespace slipstream::app {
namespace {

struct ServeFlags {
  std::string address = "127.0.0.1";
  std::string serial = "SLIPSTREAM";
  double rate = 120;
  int cycles = 16;
  std::optional<double> duration;  ///< s
  double packet_loss = 0;
  std::optional<std::string> write_scanner;
  std::optional<int> boards;
  BoardFlags board;
  int still = 8;
  VirtualFlags scene;
  SequenceChanges scan;
};

/// What a person does who calibrates: the board in one pose after another, under patterns along x
/// and then along y.
Reel boards_for(const ServeFlags& flags, const VirtualWorld& world, const Sequence& sequence) {
  constexpr int most_cycles = 1000;
  if (flags.still < 1 || flags.still > most_cycles) {
    throw Error(fmt::format("--still {} is out of range; 1 to {}", flags.still, most_cycles));
  }
  const Body sheet = sheet_of(board_from(flags.board), world.scanner);
  const auto poses = poses_of(sheet, *flags.boards, world.scanner);
  Progress progress("boards", *flags.boards);
  Reel reel = moved_board(world, misprinted(sheet, world.photometry.physics), poses,
                          along_both_axes(sequence), flags.still, [&] { progress.advance(); });
  progress.finish();
  return reel;
}

void require_good(const ServeFlags& flags) {
  require_duration(flags.duration);
  if (!(flags.packet_loss >= 0 && flags.packet_loss <= 1)) {
    throw Error(fmt::format("--packet-loss {} is out of range; 0 to 1", flags.packet_loss));
  }
  constexpr int most_cycles = 1000;
  if (flags.cycles < 1 || flags.cycles > most_cycles) {
    throw Error(fmt::format("--cycles {} is out of range; 1 to {}", flags.cycles, most_cycles));
  }
  if (flags.scene.bits != 8) {
    throw Error(fmt::format("--camera-bits {}: a camera that is served has 8", flags.scene.bits));
  }
}

void serve_camera(const ServeFlags& flags, Output& output) {
  require_good(flags);
  const VirtualWorld world = world_from(flags.scene);
  const Sequence sequence = sequence_for(flags.scan, world.scanner);
  std::vector<Reel> reels;
  if (flags.boards) reels.push_back(boards_for(flags, world, sequence));
  reels.push_back(
      reel_of(virtual_frames(world.scanner, world.scene, pattern_set(cycle_of(sequence)),
                             world.photometry, flags.cycles)));
  VirtualGigeCamera camera(std::move(reels), flags.address, flags.serial);
  camera.set_frame_rate(flags.rate);
  camera.set_packet_loss(flags.packet_loss);
  if (flags.write_scanner) write_scanner(*flags.write_scanner, world.scanner);

  const RunEnd end(flags.duration);
  output.say("serving {} of {} at {} as aravis:{} or aravis:Aravis-Fake-{}; Ctrl-C ends it",
             sequence.strategy.name(), text_of(world.scanner.camera.size), flags.address,
             flags.address, flags.serial);
  if (flags.boards) {
    output.say(
        "a board is moved through {} poses until a client has seen them all; the next sees "
        "the scene",
        *flags.boards);
  }
  std::fflush(stdout);  // who reads it through a pipe waits for it to connect
  while (!end.reached()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  output.say("{} frames were sent in {:.1f} s", camera.sent(), end.seconds());
  output.document = {{"address", flags.address},
                     {"serial", flags.serial},
                     {"frames", camera.sent()},
                     {"seconds", end.seconds()}};
}

}  // namespace

void add_camera_serve(CLI::App& camera, Command& chosen) {
  const auto [command, flags] =
      add_command(camera, chosen, serve_camera, "serve",
                  "the virtual scanner as a GigE Vision camera of this machine, until Ctrl-C");
  command.add("--address", flags.address, "of the network interface to serve on");
  command.add("--serial", flags.serial, "the camera's name to clients");
  command.add("--rate", flags.rate, "frames per second until a client asks for another");
  command.add("--cycles", flags.cycles,
              "scans that are rendered before and then served over and over");
  command.add("--boards", flags.boards,
              "before the scene: a calibration board that is moved through so many poses, under "
              "patterns along x and then y, until a client has seen them all");
  command.add("--still", flags.still, "cycles that the board stays in a pose");
  command.add("--duration", flags.duration, "so long, s");
  command.add("--packet-loss", flags.packet_loss, "share of the packets to lose, 0 to 1");
  command.add_file("--scanner", flags.scene.scanner,
                   "scanner file to imitate; an example where not given");
  command.add_scanner_output("--write-scanner", flags.write_scanner,
                             "scanner file to write, to reconstruct with");
  add_virtual_flags(command.app, flags.scene);
  add_board_flags(command.app, flags.board);
  add_pattern_flags(command.app, flags.scan);
  add_marker_flag(command.app, flags.scan);
  command.app.footer(
      "Example:\n  slipstream camera serve --strategy pmp --steps 4 --rate 150 --move 0.2 0 0");
}

}  // namespace slipstream::app
