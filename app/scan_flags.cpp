#include "app/scan_flags.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "app/flag_group.h"
#include "slipstream/base/error.h"
#include "slipstream/base/number_text.h"
#include "slipstream/base/rectangle.h"
#include "slipstream/codes/registry.h"
#include "slipstream/io/limits.h"

namespace slipstream::app {
namespace {

/// low_steps to --low-steps.
std::string flag_of(std::string setting) {
  std::replace(setting.begin(), setting.end(), '_', '-');
  return "--" + setting;
}

std::vector<double> exposures_from(const std::string& text) {
  std::vector<double> exposures = numbers_in<double>(text, ',');
  if (exposures.empty()) {
    throw Error(
        fmt::format("--exposures {} are no numbers with commas between, as 1,4,16 are", text));
  }
  return exposures;
}

/// What is wrong with a setting that is no number; empty where nothing is.
std::string numbers_only(const std::string& text) {
  try {
    std::vector<double> numbers;
    SettingValue(text).read(numbers);
    return {};
  } catch (const Error& error) {
    return error.what();
  }
}

void add_sequence_flags(const FlagGroup& group, ScanFlags& flags) {
  group.add("--strategy", flags.strategy, fmt::format("{}", fmt::join(strategy_names(), ", ")));
  for (const SettingDescription& setting : strategy_settings()) {
    CLI::Option* const option = group.add(flag_of(setting.name), flags.settings[setting.name],
                                          fmt::format("{} [{}]", setting.help, setting.strategies));
    if (setting.is_switch) {
      option->expected(0, 1)->default_str("true");
    } else if (!setting.is_word) {
      option->check(numbers_only);
    }
  }
  group.add("--period-pixels", flags.period_pixels, "--periods, each in projector pixels");
  group.add("--stripe", flags.stripe_pixels, "--stripes as the width of one in projector pixels");
  group.add("--axis", flags.axis,
            "x: the pattern varies along projector columns; y: rows; both: first x, then y");
  group.add("--projector", flags.projector, "projector pixels, as 1824x1140");
  group.add("--alpha-p", flags.alpha_p, "amplitude of the patterns, grey levels of 255");
  group.add("--beta-p", flags.beta_p, "darkest grey level of the patterns");
  group.add("--exposures", flags.exposures,
            "all patterns once for each, as 1,4,16: relative, or in ms; merged to one scan");
  group.add(
      "--motion", flags.motion,
      "so many frames more than a cycle of one sinusoid, shown over and over, become a cloud: "
      "2 or 4 where things move");
}

}  // namespace

void add_pattern_flags(CLI::App& subcommand, ScanFlags& flags) {
  const FlagGroup group{subcommand, "What the patterns are"};
  add_sequence_flags(group, flags);
  group.add("--binary", flags.binary,
            "in pixels that are dark or bright alone, whose mean is the pattern: for a DMD that "
            "shows a bit at a time");
  const Sequence usual = default_sequence({1024, 1024}, {});
  subcommand.get_option("--strategy")->default_str(usual.strategy.name());
  subcommand.get_option("--axis")->default_str(std::string(name_of(usual.axis)));
  subcommand.get_option("--alpha-p")->default_str(fmt::format("{:g}", usual.light.alpha_p));
  subcommand.get_option("--beta-p")->default_str(fmt::format("{:g}", usual.light.beta_p));
}

void add_marker_flag(CLI::App& subcommand, ScanFlags& flags) {
  const FlagGroup group{subcommand, "What the patterns are"};
  group.add("--marker", flags.marker,
            "a dark frame ends each cycle, so that a camera that begins anywhere finds its place");
}

void add_scan_flags(CLI::App& subcommand, ScanFlags& flags) {
  const FlagGroup group{subcommand, "What the patterns are, where not as the scan says"};
  add_sequence_flags(group, flags);
  group.add("--order", flags.order,
            "which frame shows each pattern, counted from 0, as 2,0,1; or code,sinusoids where the "
            "code comes first; else as they come");
}

SequenceChanges changes_from(const ScanFlags& flags) {
  SequenceChanges changes{.strategy = flags.strategy,
                          .settings = flags.settings,
                          .stripe_pixels = flags.stripe_pixels,
                          .axes = flags.axis,
                          .alpha_p = flags.alpha_p,
                          .beta_p = flags.beta_p,
                          .marker = flags.marker,
                          .binary = flags.binary,
                          .motion = flags.motion};
  if (flags.period_pixels) {
    changes.period_pixels.emplace();
    SettingValue(*flags.period_pixels).read(*changes.period_pixels);
  }
  if (flags.exposures) changes.exposures = exposures_from(*flags.exposures);
  if (flags.projector) changes.projector = size_from(*flags.projector, "--projector");
  return changes;
}

ScanChanges scan_changes_from(const ScanFlags& flags) {
  ScanChanges changes{.sequence = changes_from(flags)};
  changes.order = flags.order.value_or("");
  return changes;
}

Size size_from(const std::string& text, const std::string& flag) {
  if (const std::optional<Size> size = size_of_text(text)) {
    const auto side = [](int pixels) { return static_cast<std::uint64_t>(pixels); };
    if (side(size->width) * side(size->height) <= largest_picture) return *size;
    throw Error(fmt::format("{} {}: at most {} pixels", flag, text, largest_picture));
  }
  throw Error(fmt::format("{} '{}' is not a size; give width x height in pixels, as 1824x1140",
                          flag, text));
}

}  // namespace slipstream::app
