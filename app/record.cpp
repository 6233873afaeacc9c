#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/findings.h"
#include "app/output.h"
#include "app/process.h"
#include "app/scan_flags.h"
#include "app/source_flags.h"
#include "slipstream/base/error.h"
#include "slipstream/check/scan_check.h"
#include "slipstream/io/recorder.h"
#include "slipstream/io/saved_scan.h"

namespace slipstream::app {
namespace {

struct RecordFlags {
  std::string file;
  SourceFlags source;
  std::optional<std::int64_t> frames;
  std::optional<double> duration;  ///< s
};

void require_valid(const RecordFlags& flags) {
  if (flags.frames && *flags.frames < 1) {
    throw Error(fmt::format("--frames {} is out of range; at least 1", *flags.frames));
  }
  require_duration(flags.duration);
}

/// What is amiss with the first whole cycle of what was recorded. It is told and no more: the
/// recording stays, for there may be no second one.
std::vector<Finding> findings_of_recording(const std::string& file, Output& output) {
  std::vector<Finding> findings;
  try {
    findings = check_scan(load_scan(file), {.moving = true}).findings;
  } catch (const Error& error) {
    output.warn(fmt::format("what was recorded cannot be checked: {}", error.what()));
  }
  warn_of(findings, output);
  return findings;
}

void record(const RecordFlags& flags, Output& output) {
  require_valid(flags);
  SourceRequest request = request_from(flags.source);
  request.as_taken = true;
  const NamedSource opened = open_source(request);
  if (!opened.warning.empty()) output.warn(opened.warning);
  FrameSource& source = *opened.frames;
  Recorder recorder(flags.file, {.format = source.format(),
                                 .frame_rate = request.rate.value_or(0),
                                 .sequence = opened.sequence,
                                 .scanner = opened.scanner,
                                 .in_colour = opened.in_colour,
                                 .white = opened.white});
  source.start();
  Progress progress("frames", flags.frames.value_or(0));
  const RunEnd end(flags.duration);
  const std::int64_t frames = record_frames(
      source, recorder, [&](std::int64_t taken) { return end.reached() || taken == flags.frames; },
      [&] {
        if (flags.frames) progress.advance();
      },
      [&](const std::string& state) { output.warn(state.empty() ? "the camera is back" : state); });
  const double seconds = end.seconds();
  progress.finish();
  source.stop();
  recorder.finish();

  const SourceCounters counters = source.counters();
  const Recorder::Counts counts = recorder.counts();
  if (counts.written == 0) {
    throw WorldError(fmt::format("{}: no frame came that could be recorded", flags.file));
  }
  const double rate = seconds > 0 ? static_cast<double>(frames) / seconds : 0;
  output.say("{}: {} frames of {}, {:.1f} per second", flags.file, counts.written,
             text_of(source.format().size), rate);
  if (counters.lost > 0) output.warn(fmt::format("{} frames did not arrive", counters.lost));
  if (counts.lost > 0) {
    output.warn(fmt::format("{} frames came faster than the disk took them", counts.lost));
  }
  nlohmann::json findings = app::json_of(findings_of_recording(flags.file, output));
  output.document = {{"recording", flags.file},           {"findings", std::move(findings)},
                     {"frames", counts.written},          {"lost", counters.lost},
                     {"not_written", counts.lost},        {"resent_packets", counters.resent},
                     {"reconnects", counters.reconnects}, {"seconds", seconds},
                     {"frames_per_second", rate}};
}

}  // namespace

void add_record(CLI::App& program, Command& chosen) {
  const auto [command, flags] = add_command(program, chosen, record, "record",
                                            "frames of a camera to disk, lossless, to be replayed");
  SourceRequest& request = flags.source.request;
  command.add_output("-o,--output", flags.file, "the recording")->required();
  command.add("--source", request.source, source_forms())->required()->default_str("");
  command.add("--frames", flags.frames, "so many; until Ctrl-C without");
  command.add("--duration", flags.duration, "so long, s");
  command.add("--rate", request.rate,
              "frames per second; 0: as fast as it goes; else the source's own");
  command.add("--loop", request.loop, "a replay begins again at its end");
  command.add_file("--scanner", request.scanner, "scanner file, which is kept in the recording");
  add_camera_flags(command.app, request.camera);
  add_pattern_flags(command.app, request.sequence);
  add_marker_flag(command.app, request.sequence);
  add_virtual_flags(command.app, flags.source.world);
  command.app.footer(
      "Example:\n  slipstream record --source aravis: -o scan.slip --frames 1000 --strategy pmp "
      "--steps 4 --scanner scanner.yaml\nCtrl-C finishes the file.");
}

}  // namespace slipstream::app
