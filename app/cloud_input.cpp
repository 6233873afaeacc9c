#include "app/cloud_input.h"

#include <fmt/format.h>

#include "app/finding_output.h"
#include "app/scan_findings.h"
#include "slipstream/error/error.h"
#include "slipstream/reconstruct/engine.h"

namespace slipstream::app {
namespace {

StoredCloud cloud_of_scan(const std::string& path, const CloudInputFlags& flags, Output& output) {
  ReconstructSettings settings = flags.settings;
  settings.clean = clean_settings_from(flags.clean);
  Scan scan = load(path, flags.input, false, output);
  choose_response(scan, flags.input);
  require_reconstructible(setup_for(scan, settings));
  const CheckedScan checked =
      check_and_repair(scan, {.minimum_modulation = settings.minimum_modulation});
  refuse_or_warn(checked, path, flags.anyway, output);
  nlohmann::json& findings = output.document["findings"];
  if (findings.is_null()) findings = nlohmann::json::array();
  for (const nlohmann::json& finding : app::json_of(checked.findings)) findings.push_back(finding);
  if (!checked.repairs.empty()) choose_response(scan, flags.input);
  Engine engine(setup_for(scan, settings));
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
