#include "app/frame_sources.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>
#include <system_error>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "slipstream/camera/open_camera.h"
#include "slipstream/error/error.h"
#include "slipstream/io/file.h"
#include "slipstream/io/replay_source.h"
#include "slipstream/io/scanner_file.h"
#include "slipstream/simulate/virtual_camera.h"

namespace slipstream::app {
namespace {

ScanDescription scan_from(const ScanFlags& flags, const ScanDescription& otherwise) {
  ScanDescription scan = otherwise;
  scan.strategy = strategy_from(flags, otherwise.strategy);
  scan.axis = axis_from(flags, otherwise.axis);
  scan.light = light_from(flags, otherwise.light);
  scan.projector = projector_from(flags, otherwise.projector);
  return scan;
}

/// Of what the flags name; else `otherwise`, the text that the source came with.
void set_scanner(OpenedSource& opened, const SourceRequest& request, const std::string& otherwise,
                 const std::string& name) {
  opened.scanner = otherwise;
  opened.scanner_name = name;
  if (!request.scanner) return;
  const std::vector<std::uint8_t> bytes = read_file(*request.scanner);
  opened.scanner.assign(bytes.begin(), bytes.end());
  opened.scanner_name = *request.scanner;
}

/// 0 is no rate: as fast as frames are asked for.
std::optional<double> pace_from(std::optional<double> rate) {
  return rate == 0.0 ? std::nullopt : rate;
}

OpenedSource open_virtual(const std::string& what, const SourceRequest& request) {
  /// Frames of the loop at least, and cycles: enough to see the scene move.
  constexpr int fewest_frames = 32, fewest_cycles = 4;
  if (!what.empty()) {
    throw Error(fmt::format("source virtual:{}: virtual takes nothing after it", what));
  }
  VirtualFlags flags = request.virtual_scanner;
  flags.scanner = request.scanner;
  flags.photometry.bits = flags.bits;
  const Scanner scanner = virtual_scanner(flags);
  ScanDescription otherwise;
  otherwise.strategy = DualFrequency{};
  otherwise.projector = scanner.projector.size;
  OpenedSource opened;
  opened.scan = scan_from(request.scan, otherwise);
  if (opened.scan.projector != scanner.projector.size) {
    throw Error(fmt::format("--projector {} is not that of the scanner, {}",
                            text_of(opened.scan.projector), text_of(scanner.projector.size)));
  }
  require_resolved(opened.scan.strategy, length_along(opened.scan.axis, scanner.projector.size));
  PatternSet patterns = pattern_set(opened.scan.strategy, opened.scan.axis, opened.scan.light);
  if (request.indexing == PatternIndexing::marker) patterns = with_marker(patterns);
  const int cycles = std::max(fewest_cycles, (fewest_frames - 1) / patterns.count + 1);
  opened.frames = std::make_unique<VirtualCamera>(
      virtual_frames(scanner, virtual_scene(flags, scanner), patterns, flags.photometry, cycles),
      pace_from(request.rate));
  set_scanner(opened, request, text_of(scanner), "the virtual scanner");
  opened.scanner = with_photometric_calibration(opened.scanner, photometric_truth(flags.photometry),
                                                opened.scanner_name);
  return opened;
}

OpenedSource open_replay(const std::string& path, const SourceRequest& request) {
  auto replay = std::make_unique<ReplaySource>(
      path, ReplaySettings{.rate = request.rate, .loop = request.loop});
  const RecordingHeader& header = replay->header();
  if (!header.scan && !request.scan.strategy) {
    throw Error(
        fmt::format("{}: does not say what patterns it shows; say so with --strategy", path));
  }
  OpenedSource opened;
  opened.scan = scan_from(request.scan, header.scan.value_or(ScanDescription{}));
  opened.warning = replay->warning();
  set_scanner(opened, request, header.scanner, path);
  opened.frames = std::move(replay);
  return opened;
}

/// Of a camera, which does not say what is projected.
OpenedSource open_camera_source(const std::string&, const SourceRequest& request) {
  if (!request.scan.strategy) {
    throw Error(fmt::format(
        "{}: a camera does not say what patterns it sees; say so with --strategy", request.source));
  }
  OpenedSource opened;
  opened.scan = scan_from(request.scan, {});
  const int cycle =
      frame_count(opened.scan.strategy) + (request.indexing == PatternIndexing::marker ? 1 : 0);
  opened.frames =
      open_camera(request.source, camera_settings(request.camera, pace_from(request.rate), cycle));
  set_scanner(opened, request, {}, request.source);
  return opened;
}

struct Scheme {
  std::string_view name;
  std::string_view form;
  OpenedSource (*open)(const std::string& what, const SourceRequest& request);
};

constexpr std::array schemes{
    Scheme{"virtual", "virtual", open_virtual},
    Scheme{"replay", "replay:PATH", open_replay},
    Scheme{"aravis", "aravis:NAME", open_camera_source},
    Scheme{"v4l2", "v4l2:NUMBER", open_camera_source},
};

}  // namespace

std::string source_forms() {
  std::vector<std::string_view> forms;
  for (const Scheme& scheme : schemes) forms.push_back(scheme.form);
  return fmt::format("{}", fmt::join(forms, ", "));
}

OpenedSource open_source(const SourceRequest& request) {
  const std::size_t colon = request.source.find(':');
  const std::string name = request.source.substr(0, colon);
  const std::string what =
      colon == std::string::npos ? std::string() : request.source.substr(colon + 1);
  const auto scheme =
      std::find_if(schemes.begin(), schemes.end(), [&](const Scheme& s) { return s.name == name; });
  if (scheme == schemes.end()) {
    throw Error(fmt::format("source '{}' is unknown; one of {}", request.source, source_forms()));
  }
  const double rate = request.rate.value_or(0);
  if (!(rate == 0 || (rate >= 1e-3 && rate <= 1e6))) {
    throw Error(
        fmt::format("--rate {} is out of range; 0 (as fast as it goes), or 0.001 to 1e6 Hz", rate));
  }
  return scheme->open(what, request);
}

void require_not_replayed(const SourceRequest& request, const std::string& file) {
  constexpr std::string_view scheme = "replay:";
  if (!request.source.starts_with(scheme)) return;
  std::error_code unknown;  // where `file` is not there yet
  if (std::filesystem::equivalent(request.source.substr(scheme.size()), file, unknown)) {
    throw Error(fmt::format("{}: is being replayed; record to another file", file));
  }
}

}  // namespace slipstream::app
