#include "app/cloud_input.h"

#include <fmt/format.h>

#include "app/finding_output.h"
#include "app/stopwatch.h"
#include "slipstream/base/error.h"

namespace slipstream::app {
namespace {

/// Puts into the scan the response that its phases are corrected for, both in the check and in the
/// cloud. Two cameras under one projector match whatever phase it shows.
GammaChoice gamma_of(Scan& scan, const ScanInputFlags& flags) {
  GammaChoice choice = choose_response(scan, flags.gamma);
  if (scan.further_cameras.empty()) return choice;
  return {.source = "two cameras", .sentence = "two cameras, free of gamma"};
}

StoredCloud cloud_of_scan(const std::string& path, CloudInputFlags flags, Output& output) {
  set_clean(flags.settings, flags.clean);
  Scan scan = load(path, flags.input, false, output);
  const SoundScan sound = sound_scan(scan, path, flags, output);
  nlohmann::json& findings = output.document["findings"];
  if (findings.is_null()) findings = nlohmann::json::array();
  for (const auto& finding : app::json_of(sound.checked.findings)) findings.push_back(finding);
  Engine engine(sound.setup);
  StoredCloud result;
  result.organised = true;
  Maps maps;
  engine.cloud_and_maps(scan.frames, result.cloud, maps);
  if (engine.setup().scanner.photometry.noise_variance) {
    result.uncertainty = engine.uncertainty(result.cloud, maps, scan.frames);
  }
  return result;
}

}  // namespace

void add_cloud_input_flags(CLI::App& subcommand, CloudInputFlags& flags) {
  add_anyway_flag(subcommand, flags.anyway);
  add_point_flags(subcommand, flags.settings);
  add_clean_flags(subcommand, flags.clean);
  add_scan_input_flags(subcommand, flags.input);
}

SoundScan sound_scan(Scan& scan, const std::string& name, const CloudInputFlags& flags,
                     Output& output) {
  Stopwatch watch;
  SoundScan sound;
  sound.gamma = gamma_of(scan, flags.input);
  sound.setup = setup_for(scan, flags.settings);
  sound.choosing = watch.lap();
  scan.further_cameras.empty() ? require_reconstructible(sound.setup) : require_valid(sound.setup);
  sound.checked = check_and_repair(scan, {.minimum_modulation = flags.settings.minimum_modulation});
  refuse_or_warn(sound.checked, name, flags.anyway, output);
  if (!sound.checked.repairs.empty()) sound.gamma = gamma_of(scan, flags.input);  // may be another
  sound.setup.scanner.photometry.response = sound.gamma.response;
  sound.checking = watch.lap();
  return sound;
}

StoredCloud organised_cloud(const std::string& path, const CloudInputFlags& flags, Output& output) {
  if (!is_cloud_file(path)) return cloud_of_scan(path, flags, output);
  StoredCloud stored = read_cloud(path);
  if (!stored.organised) {
    throw Error(
        fmt::format("{}: its points are not in the order of pixels, by which they are named; "
                    "measure the scan, or an organised .pcd",
                    path));
  }
  return stored;
}

}  // namespace slipstream::app
