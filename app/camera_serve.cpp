#include "app/camera_serve.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include <fmt/format.h>

#include "app/scan_flags.h"
#include "app/stop_signal.h"
#include "app/virtual_flags.h"
#include "slipstream/camera/virtual_gige_camera.h"
#include "slipstream/error/error.h"
#include "slipstream/io/scanner_file.h"
#include "slipstream/simulate/virtual_camera.h"

namespace slipstream::app {
namespace {

using std::chrono::steady_clock;

struct ServeFlags {
  std::string address = "127.0.0.1";
  std::string serial = "SLIPSTREAM";
  double rate = 120;
  int cycles = 16;
  std::optional<double> duration;  ///< s
  double packet_loss = 0;
  std::optional<std::string> write_scanner;
  VirtualFlags scene;
  ScanFlags scan;
};

void serve(const ServeFlags& flags, Output& output) {
  if (!(flags.packet_loss >= 0 && flags.packet_loss <= 1)) {
    throw Error(fmt::format("--packet-loss {} is out of range; 0 to 1", flags.packet_loss));
  }
  constexpr int most_cycles = 1000;
  if (flags.cycles < 1 || flags.cycles > most_cycles) {
    throw Error(fmt::format("--cycles {} is out of range; 1 to {}", flags.cycles, most_cycles));
  }
  if (flags.scene.bits != 8) {
    throw Error(fmt::format("--bits {}: a camera that is served has 8", flags.scene.bits));
  }
  const Scanner scanner = virtual_scanner(flags.scene);
  const Size projector = projector_from(flags.scan, scanner.projector.size);
  if (projector != scanner.projector.size) {
    throw Error(fmt::format("--projector {} is not that of the scanner, {}", text_of(projector),
                            text_of(scanner.projector.size)));
  }
  const Strategy strategy = strategy_from(flags.scan, DualFrequency{});
  const Axis axis = axis_from(flags.scan, Axis::x);
  require_resolved(strategy, length_along(axis, scanner.projector.size));
  Photometry photometry = flags.scene.photometry;
  photometry.bits = flags.scene.bits;
  VirtualGigeCamera camera(virtual_frames(scanner, virtual_scene(flags.scene, scanner),
                                          pattern_set(strategy, axis, light_from(flags.scan, {})),
                                          photometry, flags.cycles),
                           flags.address, flags.serial);
  camera.set_frame_rate(flags.rate);
  camera.set_packet_loss(flags.packet_loss);
  if (flags.write_scanner) write_scanner(*flags.write_scanner, scanner);

  const StopSignal stop;
  output.say("serving {} of {} at {} as aravis:{} or aravis:Aravis-Fake-{}; Ctrl-C ends it",
             name_of(strategy), text_of(scanner.camera.size), flags.address, flags.address,
             flags.serial);
  std::fflush(stdout);  // who reads it through a pipe waits for it to connect
  const steady_clock::time_point start = steady_clock::now();
  const auto seconds = [&] {
    return std::chrono::duration<double>(steady_clock::now() - start).count();
  };
  while (!stop.raised() && !(flags.duration && seconds() >= *flags.duration)) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  output.say("{} frames were sent in {:.1f} s", camera.sent(), seconds());
  output.document = {{"address", flags.address},
                     {"serial", flags.serial},
                     {"frames", camera.sent()},
                     {"seconds", seconds()}};
}

}  // namespace

void add_camera_serve(CLI::App& camera, SharedFlags& shared, Command& chosen) {
  CLI::App* command = camera.add_subcommand(
      "serve", "the virtual scanner as a GigE Vision camera of this machine, until Ctrl-C");
  const auto flags = std::make_shared<ServeFlags>();
  command->add_option("--address", flags->address, "of the network interface to serve on")
      ->capture_default_str();
  command->add_option("--serial", flags->serial, "the camera's name to clients")
      ->capture_default_str();
  command->add_option("--rate", flags->rate, "frames per second until a client asks for another")
      ->capture_default_str();
  command
      ->add_option("--cycles", flags->cycles,
                   "scans that are rendered before and then served over and over")
      ->capture_default_str();
  command->add_option("--duration", flags->duration, "so long, s");
  command->add_option("--packet-loss", flags->packet_loss, "share of the packets to lose, 0 to 1")
      ->capture_default_str();
  command->add_option("--scanner", flags->scene.scanner,
                      "scanner file to imitate; an example where not given");
  command->add_option("--write-scanner", flags->write_scanner,
                      "scanner file to write, to reconstruct with");
  add_virtual_flags(*command, flags->scene);
  add_scan_flags(*command, flags->scan);
  add_shared_flags(*command, shared);
  command->footer(
      "Example:\n  slipstream camera serve --strategy pmp --steps 4 --rate 150 --motion 0.2 0 0");
  command->callback(
      [flags, &chosen] { chosen = [flags](Output& output) { serve(*flags, output); }; });
}

}  // namespace slipstream::app
