#include "app/scan_flags.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "app/flag_group.h"
#include "slipstream/capture/frame_set.h"
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

/// The numbers of "2,0,1"; empty where it is anything else.
template <class Number>
std::vector<Number> numbers_of(std::string_view text) {
  std::vector<Number> numbers;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (true) {
    Number number = 0;
    const auto [after, error] = std::from_chars(at, end, number);
    if (error != std::errc()) return {};
    numbers.push_back(number);
    if (after == end) return numbers;
    if (*after != ',') return {};
    at = after + 1;
  }
}

std::vector<double> exposures_from(const std::string& text) {
  std::vector<double> exposures = numbers_of<double>(text);
  if (exposures.empty()) {
    throw Error(
        fmt::format("--exposures {} are no numbers with commas between, as 1,4,16 are", text));
  }
  return exposures;
}

std::vector<std::filesystem::path> in_order(const std::vector<std::filesystem::path>& pictures,
                                            const std::string& text,
                                            const std::filesystem::path& folder) {
  const std::vector<int> order = numbers_of<int>(text);
  if (!is_order_of(order, static_cast<int>(pictures.size()))) {
    throw Error(
        fmt::format("{}: --order {} is no order of its {} pictures; name each of 0 to {} "
                    "once, with commas between",
                    folder.string(), text, pictures.size(), pictures.size() - 1));
  }
  std::vector<std::filesystem::path> ordered;
  ordered.reserve(order.size());
  for (const int place : order) ordered.push_back(pictures[static_cast<std::size_t>(place)]);
  return ordered;
}

}  // namespace

void add_pattern_flags(CLI::App& subcommand, ScanFlags& flags) {
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
  group.add("--exposures", flags.exposures,
            "all patterns once for each, as 1,4,16: relative, or in ms; merged to one scan");
}

void add_scan_flags(CLI::App& subcommand, ScanFlags& flags) {
  add_pattern_flags(subcommand, flags);
  const FlagGroup group{subcommand, "What the patterns are"};
  group.add("--order", flags.order,
            "which picture shows each pattern, counted from 0, as 2,0,1; else as they are named");
}

SequenceChanges changes_from(const ScanFlags& flags) {
  SequenceChanges changes{.strategy = flags.strategy,
                          .settings = flags.settings,
                          .alpha_p = flags.alpha_p,
                          .beta_p = flags.beta_p};
  if (flags.exposures) changes.exposures = exposures_from(*flags.exposures);
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
  if (flags.order) files.frames = in_order(files.frames, *flags.order, folder);
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
