#include "app/loaded_scan.h"

#include "app/process.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/saved_scan.h"
#include "slipstream/reconstruct/coordinate_map.h"

namespace slipstream::app {
namespace {

ScanFiles files_of(const ScanName& name, const ScanFlags& input, const ReconstructFlags& flags) {
  if (flags.from.empty()) return scan_files_in(name.path, input);
  return {.path = name.path, .frames = {name.path}, .scanner = input.scanner};
}

void load_map(const ReconstructFlags& flags, LoadedScan& loaded) {
  const ScanFlags& given = flags.cloud;
  throw_if(!given.scanner, "--from needs the scanner's file: --scanner");
  const std::string& path = loaded.result.name.path;
  const Image<double> map = read_map(path);
  EngineSetup& setup = loaded.result.sound.setup;
  setup.sequence = changed({}, given.sequence);
  setup.settings = flags.cloud.settings;
  setup.scanner = completed(read_scanner(*given.scanner), given.scanner->string(), map.size(),
                            setup.sequence.projector);
  loaded.coordinates =
      naming(path, [&] { return coordinates_of_map(map, flags.from, projector_length(setup)); });
  throw_if(flags.modulation && flags.scans.size() > 1, "--from-modulation needs a single map");
  throw_if(!flags.modulation && flags.command->count("--min-modulation") > 0,
           "with --from, --min-modulation needs --from-modulation");
  if (flags.modulation) loaded.modulation = converted<float>(read_map(*flags.modulation));
}

/// Checks a scan of two cameras without a projector; the setup's scanner is then the pair.
SoundScan sound_pair(Scan& scan, const ScanName& name, const fs::path& file, CloudFlags flags,
                     Output& output) {
  const Scanner pair =
      completed(read_camera_pair(file), file.string() + ", the second camera as the projector",
                scan.frames.size(), scan.further_cameras.front().frames.size());
  PhotometricCalibration& known = flags.photometry;
  known.ambient = known.ambient ? known.ambient : pair.photometry.ambient;
  if (!known.noise_variance) {
    known.noise_variance = pair.photometry.noise_variance;
    known.noise_gain = pair.photometry.noise_gain;
  }
  SoundScan sound = sound_scan(scan, text_of(name), flags, output, Wanted::maps);
  sound.setup.scanner = pair;
  sound.setup.scanner.photometry = known;
  output.say("{}: two cameras, no projector: the calibration is not checked with the frames",
             text_of(name));
  return sound;
}

/// Returns the file of two cameras without a projector, if the scan has no scanner but that.
std::optional<fs::path> read_scan(const ScanFlags& input, const ReconstructFlags& flags,
                                  LoadedScan& loaded) {
  const auto& [path, window] = loaded.result.name;
  const bool cameras = !flags.one_camera, only_maps = flags.files.only_maps() && !flags.uncertainty;
  loaded.scan = load_checkable(path, input, cameras, loaded.result.words);
  const Scan& scan = loaded.scan;
  std::optional<fs::path> pair;
  if (!only_maps && !scan.scanner && !scan.further_cameras.empty()) {
    pair = scan_files_in(path, input).scanner;
  }
  throw_if(!only_maps && !scan.scanner && !pair,
           "{}: no scanner is known; name its file with --scanner or in scan.yaml", path);
  // Without a fringe order the frames give a phase, but no points.
  const bool only_phase = flags.files.coordinate.empty() && scan.further_cameras.empty() &&
                          !has_coordinate(scan.sequence.strategy);
  loaded.result.warnings = scan.warnings;
  loaded.result.wanted = only_maps && (!scan.scanner || only_phase) ? Wanted::maps : Wanted::points;
  return pair;
}

}  // namespace

LoadedScan loaded_scan(const ScanName& name, const ReconstructFlags& flags, const Manifest* before,
                       OpenedRecording& opened, const Output& output) {
  LoadedScan loaded;
  ReconstructedScan& result = loaded.result;
  result.name = name;
  result.words = output.held();
  result.entry = entry_for(name, flags.settings);
  Stopwatch watch;
  try {
    ScanFlags input = flags.cloud;
    input.window = name.window;
    input.recording = opened.at(name.path);
    if (before != nullptr) {
      const std::uint32_t sum = checksum_of(files_of(name, input, flags));
      result.entry["input"] = fmt::format("{:08x}", sum);
      const auto outputs = files_of_scan(flags.files, name).written();
      result.done_before = why_not_done(*before, name, result.entry, outputs).empty();
      if (result.done_before) return loaded;
    }
    if (!flags.from.empty()) {
      load_map(flags, loaded);
      result.read = watch.lap();
      return loaded;
    }
    const std::optional<fs::path> pair = read_scan(input, flags, loaded);
    result.read = watch.lap();
    result.sound =
        pair ? sound_pair(loaded.scan, name, *pair, flags.cloud, result.words)
             : sound_scan(loaded.scan, text_of(name), flags.cloud, result.words, result.wanted);
  } catch (const Error& error) {
    result.failure = error.what();
  } catch (const WorldError& error) {  // an unreadable file fails only its own scan
    if (flags.scans.size() == 1) throw;
    result.failure = error.what();
  }
  return loaded;
}

}  // namespace slipstream::app
