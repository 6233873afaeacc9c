#include <chrono>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/frame_sources.h"
#include "app/progress.h"
#include "app/stop_signal.h"
#include "slipstream/error/error.h"
#include "slipstream/io/recorder.h"
#include "slipstream/io/scanner_file.h"

namespace slipstream::app {
namespace {

using std::chrono::steady_clock;
using namespace std::chrono_literals;

struct RecordFlags {
  std::string file;
  SourceRequest source;
  std::optional<std::int64_t> frames;
  std::optional<double> duration;  ///< s
};

void require_valid(const RecordFlags& flags) {
  if (flags.frames && *flags.frames < 1) {
    throw Error(fmt::format("--frames {} is out of range; at least 1", *flags.frames));
  }
  if (flags.duration && !(*flags.duration > 0 && std::isfinite(*flags.duration))) {
    throw Error(fmt::format("--duration {} is out of range; above 0 s", *flags.duration));
  }
  if (flags.source.scanner) (void)read_scanner(*flags.source.scanner);
}

struct Taken {
  std::int64_t frames = 0;
  double seconds = 0;
};

/// Hands the frames on until there are as many as wanted, or the time is over, or somebody says so,
/// or the recording fails.
Taken take_frames(FrameSource& source, Recorder& recorder, const RecordFlags& flags,
                  Output& output) {
  const StopSignal stop;
  Progress progress("frames", flags.frames.value_or(0));
  // A source without a pace waits for the disk; one with a pace of its own cannot.
  const auto patience = source.has_own_pace() ? 0ms : 60000ms;
  Taken taken;
  std::string state;
  Frame frame(source.format());
  const steady_clock::time_point start = steady_clock::now();
  const auto seconds = [&] {
    return std::chrono::duration<double>(steady_clock::now() - start).count();
  };
  while (!stop.raised() && (!flags.frames || taken.frames < *flags.frames) &&
         (!flags.duration || seconds() < *flags.duration) && recorder.error().empty()) {
    const Arrival arrival = source.next(frame, 100ms);
    if (arrival == Arrival::ended) break;
    if (const std::string now = source.state(); now != state) {
      state = now;
      output.warn(state.empty() ? "the camera is back" : state);
    }
    if (arrival != Arrival::frame) continue;
    recorder.record(frame, patience);
    ++taken.frames;
    if (flags.frames) progress.advance();
  }
  taken.seconds = seconds();
  return taken;
}

void record(const RecordFlags& flags, Output& output) {
  require_valid(flags);
  const OpenedSource opened = open_source(flags.source);
  if (!opened.warning.empty()) output.warn(opened.warning);
  FrameSource& source = *opened.frames;
  require_not_replayed(flags.source, flags.file);
  Recorder recorder(flags.file, {.format = source.format(),
                                 .frame_rate = flags.source.rate.value_or(0),
                                 .scan = opened.scan,
                                 .scanner = opened.scanner});
  source.start();
  const Taken taken = take_frames(source, recorder, flags, output);
  source.stop();
  recorder.finish();

  const SourceCounters counters = source.counters();
  const Recorder::Counts counts = recorder.counts();
  const double rate = taken.seconds > 0 ? static_cast<double>(taken.frames) / taken.seconds : 0;
  output.say("{}: {} frames of {}, {:.1f} per second", flags.file, counts.written,
             text_of(source.format().size), rate);
  if (counters.lost > 0) output.warn(fmt::format("{} frames did not arrive", counters.lost));
  if (counts.lost > 0) {
    output.warn(fmt::format("{} frames came faster than the disk took them", counts.lost));
  }
  output.document = {{"recording", flags.file},
                     {"frames", counts.written},
                     {"lost", counters.lost},
                     {"not_written", counts.lost},
                     {"resent_packets", counters.resent},
                     {"reconnects", counters.reconnects},
                     {"seconds", taken.seconds},
                     {"frames_per_second", rate}};
}

}  // namespace

void add_record(CLI::App& program, SharedFlags& shared, Command& chosen) {
  CLI::App* command =
      program.add_subcommand("record", "frames of a camera to disk, lossless, to be replayed");
  const auto flags = std::make_shared<RecordFlags>();
  command->add_option("-o,--output", flags->file, "the recording")->required();
  command->add_option("--source", flags->source.source, source_forms())->required();
  command->add_option("--frames", flags->frames, "so many; until Ctrl-C without");
  command->add_option("--duration", flags->duration, "so long, s");
  command->add_option("--rate", flags->source.rate,
                      "frames per second; 0: as fast as it goes; else the source's own");
  command->add_flag("--loop", flags->source.loop, "a replay begins again at its end");
  command->add_option("--scanner", flags->source.scanner,
                      "scanner file, which is kept in the recording");
  add_camera_flags(*command, flags->source.camera);
  add_scan_flags(*command, flags->source.scan);
  add_virtual_flags(*command, flags->source.virtual_scanner);
  add_shared_flags(*command, shared);
  command->footer(
      "Example:\n  slipstream record --source aravis: -o scan.slip --frames 1000 --strategy pmp "
      "--steps 4 --scanner scanner.yaml\nCtrl-C finishes the file.");
  command->callback(
      [flags, &chosen] { chosen = [flags](Output& output) { record(*flags, output); }; });
}

}  // namespace slipstream::app
