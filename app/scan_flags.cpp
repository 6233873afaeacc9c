#include "app/scan_flags.h"

#include <algorithm>
#include <filesystem>
#include <string_view>

#include <fmt/format.h>

#include "app/flag_group.h"
#include "slipstream/error/error.h"
#include "slipstream/image/size_text.h"
#include "slipstream/strategy/registry.h"

namespace slipstream::app {
namespace {

/// low_steps to --low-steps.
std::string flag_of(std::string setting) {
  std::replace(setting.begin(), setting.end(), '_', '-');
  return "--" + setting;
}

}  // namespace

void add_scan_flags(CLI::App& subcommand, ScanFlags& flags) {
  const FlagGroup group{subcommand, "What the patterns are"};
  group.add("--strategy", flags.strategy, fmt::format("{}", fmt::join(strategy_names(), ", ")));
  for (const SettingDescription& setting : strategy_settings()) {
    group.add(flag_of(setting.name), flags.settings[setting.name],
              fmt::format("{} [{}]", setting.help, setting.strategies));
  }
  group.add("--axis", flags.axis, "x: the pattern varies along projector columns; y: rows");
  group.add("--projector", flags.projector, "projector pixels, as 1824x1140");
  group.add("--alpha-p", flags.alpha_p, "amplitude of the patterns, grey levels of 255");
  group.add("--beta-p", flags.beta_p, "darkest grey level of the patterns");
}

SequenceChanges changes_from(const ScanFlags& flags) {
  SequenceChanges changes{.strategy = flags.strategy,
                          .settings = flags.settings,
                          .alpha_p = flags.alpha_p,
                          .beta_p = flags.beta_p};
  if (flags.axis) changes.axis = axis_named(*flags.axis);
  if (flags.projector) changes.projector = size_from(*flags.projector, "--projector");
  return changes;
}

void amend(ScanFiles& files, const std::filesystem::path& folder, const ScanFlags& flags) {
  if (!flags.strategy && !std::filesystem::exists(folder / "scan.yaml")) {
    throw Error(fmt::format("{}: no scan.yaml in it; say what the pictures are with --strategy",
                            folder.string()));
  }
  files.sequence = changed(files.sequence, changes_from(flags));
}

ScanFiles describe(const std::filesystem::path& folder, const ScanFlags& flags) {
  ScanFiles files = scan_files_in(folder);
  amend(files, folder, flags);
  return files;
}

Size size_from(const std::string& text, const std::string& flag) {
  if (const std::optional<Size> size = size_of_text(text)) return *size;
  throw Error(fmt::format("{} '{}' is not a size; give width x height in pixels, as 1824x1140",
                          flag, text));
}

}  // namespace slipstream::app
