#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "app/board_flags.h"
#include "app/commands.h"
#include "app/process.h"
#include "app/source_flags.h"
#include "devices/virtual_gige_camera.h"
#include "io/recorder.h"
#include "reconstruct/gpu.h"
#include "simulate/looped_scene.h"
#include "simulate/rendered_reel.h"
#include "slipstream/recording.h"
#include "slipstream/scan_files.h"
#include "slipstream/virtual_world.h"

namespace slipstream::app {
namespace {

struct NoFlags {};

void list_connected(const NoFlags&, Output& output) {
  output.document = described("cameras", nlohmann::json::array());

  for (const CameraDescription& camera : list_cameras()) {
    output.say("{}  {} {} {}, {} {}", camera.name, camera.vendor, camera.model, camera.serial,
               camera.protocol, camera.address);
    output.add_to("cameras", "source", camera.name, "vendor", camera.vendor, "model", camera.model,
                  "serial", camera.serial, "protocol", camera.protocol, "address", camera.address);
  }

  if (output.document["cameras"].empty()) output.say("no camera answers");
}

void list_gpus(const NoFlags&, Output& output) {
  const std::vector<GpuDescription> devices = gpu_devices();
  output.list("devices");

  for (std::size_t i = 0; i < devices.size(); ++i) {
    const GpuDescription& device = devices[i];
    constexpr double mebibyte = 1 << 20;
    output.say("gpu:{}  {}, {:.0f} MiB, {}{}", i, device.name,
               static_cast<double>(device.memory) / mebibyte, device.driver,
               device.software ? "; software, on the processor's cores" : "");
    output.add_to("devices", "backend", fmt::format("gpu:{}", i), "name", device.name, "driver",
                  device.driver, "software", device.software, "memory_bytes", device.memory);
  }

  // Without a device, opening one gives the reason.
  if (!devices.empty()) return;
  try {
    Gpu::open(std::nullopt);
  } catch (const WorldError& why) {
    output.say("{}", why.what());
  }
}

#ifdef SLIPSTREAM_CAMERAS
struct ServeFlags {
  std::string address = "127.0.0.1";
  std::string serial = "SLIPSTREAM";
  double rate = 120;
  int cycles = 16;
  std::optional<double> duration;  ///< s
  double packet_loss = 0;
  Wiring wiring = Wiring::in_step;
  std::optional<std::string> write_scanner;
  std::optional<int> boards;
  BoardFlags board;
  int still = 8;
  VirtualFlags scene;
  SequenceChanges scan;
};

void require_good(const ServeFlags& flags) {
  require_duration(flags.duration);
  require_in_range(flags.packet_loss >= 0 && flags.packet_loss <= 1, "--packet-loss",
                   flags.packet_loss, "0 to 1");

  require_in_range(flags.still >= 1 && flags.still <= 1000, "--still", flags.still, "1 to 1000");
  require_in_range(flags.cycles >= 1 && flags.cycles <= 1000, "--cycles", flags.cycles,
                   "1 to 1000");

  throw_if(flags.scene.bits != 8, "--camera-bits {}: the served camera has 8 bits",
           flags.scene.bits.value_or(0));
}

void serve_camera(const ServeFlags& flags, Output& output) {
  require_good(flags);
  const VirtualWorld world = world_from(flags.scene);
  const Sequence sequence = sequence_for(flags.scan, world.scanner);

  // The boards go first; the scene follows for the next client.
  VirtualGigeCamera::Reels reels;
  if (flags.boards) {
    reels.push_back(shown_boards(flags.board, *flags.boards, flags.still, world, sequence));
  }

  reels.push_back(std::make_shared<RenderedReel>(
      looped_scene(world.scanner, world.scene, pattern_set(cycle_of(sequence)), world.photometry,
                   flags.cycles, FirstRest::until_rendered),
      progress_of("rendering the scene")));

  VirtualGigeCamera camera(reels, flags.address, flags.serial);
  camera.set_frame_rate(flags.rate);
  camera.set_packet_loss(flags.packet_loss);
  camera.set_wiring(flags.wiring);

  if (flags.write_scanner) write_scanner(*flags.write_scanner, world.scanner);

  const RunEnd end(flags.duration);
  output.say("serving {} of {} at {} as aravis:{} or aravis:Aravis-Fake-{}; press Ctrl-C to stop",
             sequence.strategy.name(), text_of(world.scanner.camera.size), flags.address,
             flags.address, flags.serial);

  if (flags.boards) {
    output.say(
        "showing a board in {} poses until a client has seen them all; the next client sees the "
        "scene",
        *flags.boards);
  }

  while (!end.reached()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    for (const auto& reel : reels) static_cast<void>(reel->at(0));  // throws if rendering failed
  }

  output.say("sent {} frames in {:.1f} s", camera.sent(), end.seconds());
  output.document = described("address", flags.address, "serial", flags.serial, "frames",
                              camera.sent(), "seconds", end.seconds());
}

void add_camera_serve(const Commands& camera) {
  const auto [command, flags] = camera.add(
      serve_camera, "serve", "serve the virtual scanner as a GigE Vision camera until Ctrl-C");

  command.add("--address", flags.address, "address of the network interface to serve on");
  command.add("--serial", flags.serial, "camera name shown to clients");
  command.add("--rate", flags.rate, "frames per second until a client changes it");

  // How frames and patterns stay in step.
  command.add_named("--wired", flags.wiring, wiring_named, "in-step",
                    "wire between the projector and the camera's Line1: trigger (to the camera: "
                    "the projector leads at --rate), strobe (to the projector: the camera leads), "
                    "or in-step (none is needed)");

  command.add("--cycles", flags.cycles, "number of scans to render in advance and serve in a loop");
  command.add(
      "--boards", flags.boards,
      "first show a calibration board in this many poses, each under patterns along x, then y");
  command.add("--still", flags.still, "pattern cycles per pose");

  command.add("--duration", flags.duration, "stop after this many seconds");
  command.add("--packet-loss", flags.packet_loss, "share of packets to drop, 0 to 1");

  command.add_file("--scanner", flags.scene.scanner_file,
                   "scanner file to imitate; default: an example");
  command.add_output("--write-scanner", flags.write_scanner,
                     "scanner file to write, for reconstruction: .yaml or .xml",
                     scanner_output_type);

  add_virtual_flags(command.app, flags.scene);
  add_board_flags(command.app, flags.board);
  add_pattern_flags(command.app, flags.scan, true);

  command.common(
      {"--scene", "--strategy", "--steps", "--rate", "--boards", "--address", "--serial"});
  command.examples({"camera serve --strategy pmp --steps 4 --rate 150 --move 0.2 0 0"});
}
#endif

struct RecordFlags {
  std::string file;
  SourceFlags source;
  std::optional<std::int64_t> frames;
  std::optional<double> duration;  ///< s
  FileLimit limit;
};

/// Checks the first complete cycle of a recording. Only reports: the recording is kept, as it may
/// be impossible to repeat.
std::vector<Finding> findings_of_recording(const std::string& file, Output& output) {
  std::vector<Finding> findings;

  try {
    findings = check_scan(load_scan(file), {.moving = true}).findings;
  } catch (const Error& error) {
    output.warn(fmt::format("cannot check the recording: {}", error.what()));
  }

  output.warn(findings);
  return findings;
}

/// A recording that has ended.
struct Recorded {
  std::int64_t frames = 0;
  double seconds = 0;
  SourceCounters source{};
  Recorder::Status file{};
};

/// Tells how many frames are in the file, which were lost, and faults of the first cycle.
void tell_recorded(const RecordFlags& flags, const Recorded& recorded, Size size, Output& output) {
  const auto& [frames, seconds, counters, counts] = recorded;

  const double rate = seconds > 0 ? static_cast<double>(frames) / seconds : 0;
  output.say("{}: {} frames of {}, {:.1f} per second", flags.file, counts.written, text_of(size),
             rate);

  // Frames lost, in transit or at the disk.
  if (!counts.limited.empty()) output.say("{}", counts.limited);
  if (counters.lost > 0) output.warn(fmt::format("{} frames were lost", counters.lost));
  if (counts.lost > 0) {
    output.warn(fmt::format("{} frames were dropped because the disk was too slow", counts.lost));
  }

  output.document =
      described("recording", flags.file, "findings", findings_of_recording(flags.file, output),
                "frames", counts.written, "limit_reached", !counts.limited.empty(), "lost",
                counters.lost, "not_written", counts.lost, "resent_packets", counters.resent,
                "reconnects", counters.reconnects, "seconds", seconds, "frames_per_second", rate);
}

void record(const RecordFlags& flags, Output& output) {
  const std::int64_t wanted = flags.frames.value_or(1);
  throw_if(wanted < 1, "--frames {} is out of range; at least 1", wanted);

  require_duration(flags.duration);
  SourceRequest request = request_from(flags.source);
  request.as_taken = true;

  const NamedSource opened = open(request, output);
  FrameSource& source = *opened.frames;
  Recorder recorder(flags.file,
                    {.format = source.format(),
                     .frame_rate = request.rate.value_or(0),
                     .sequence = opened.sequence,
                     .scanner = opened.scanner,
                     .in_colour = opened.in_colour,
                     .white = opened.white},
                    Recorder::default_memory, flags.limit);

  source.start();
  Progress progress("frames", flags.frames.value_or(0));
  const RunEnd end(flags.duration);

  // Ends at the number of frames, after --duration, or at Ctrl-C.
  const std::int64_t frames = record_frames(
      source, recorder, [&](std::int64_t taken) { return end.reached() || taken == flags.frames; },
      [&] {
        if (flags.frames) progress.advance();
      },
      [&](const std::string& state) { output.warn(state.empty() ? "the camera is back" : state); });

  // The time ends here: completing the file is not recording.
  const double seconds = end.seconds();
  progress.finish();
  source.stop();
  recorder.finish();

  const Recorded recorded{frames, seconds, source.counters(), recorder.status()};
  if (recorded.file.written == 0) {
    throw WorldError(fmt::format("{}: received no frame to record", flags.file));
  }

  tell_recorded(flags, recorded, source.format().size, output);
}

}  // namespace

void add_camera(const Commands& program) {
  const Commands camera = program.add_group("camera", "list cameras, or serve a virtual one");
  camera.add(list_connected, "list", "list the cameras that answer, by their --source names");
#ifdef SLIPSTREAM_CAMERAS
  add_camera_serve(camera);
#endif
}

void add_gpu(const Commands& program) {
  const Commands gpu = program.add_group("gpu", "list GPUs for --backend gpu");
  gpu.add(list_gpus, "list", "list Vulkan devices by number");
}

void add_record(const Commands& program) {
  const auto [command, flags] =
      program.add(record, "record", "record a camera's frames to disk, lossless, for replay");

  SourceFlags& source = flags.source;
  required(command.add_output("-o,--output", flags.file, "the recording"));
  required(command.add("--source", source.source, source_forms()));

  command.add("--frames", flags.frames, "number of frames; default: until Ctrl-C");
  command.add("--duration", flags.duration, "stop after this many seconds");
  add_limit_flag(command.app, flags.limit);

  command.add_settings(source);
  command.add_file("--scanner", source.scanner, "scanner file to store in the recording");
  add_source_flags(command.app, source, true);

  command.common({"--output", "--source", "--frames", "--duration", "--rate", "--strategy",
                  "--steps", "--scanner", "--exposure"});
  command.examples({"record --source aravis: -o scan.slip --frames 1000 --strategy pmp --steps 4 "
                    "--scanner scanner.yaml"},
                   "Ctrl-C stops recording and completes the file.");
}

}  // namespace slipstream::app
