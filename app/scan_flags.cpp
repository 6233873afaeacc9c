#include "app/scan_flags.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/base/numbers.h"
#include "slipstream/base/size.h"
#include "slipstream/codes/registry.h"
#include "slipstream/io/file.h"

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

std::vector<double> settings_in(const std::string& text) {
  std::vector<double> numbers;
  SettingValue(text).read(numbers);
  return numbers;
}

/// What is wrong with a setting that is no number; empty where nothing is.
std::string numbers_only(const std::string& text) {
  try {
    settings_in(text);
    return {};
  } catch (const Error& error) {
    return error.what();
  }
}

void add_sequence_flags(const FlagGroup& group, SequenceChanges& changes) {
  group.add("--strategy", changes.strategy, fmt::format("{}", fmt::join(strategy_names(), ", ")));
  for (const SettingDescription& setting : strategy_settings()) {
    const std::string flag = flag_of(setting.name),
                      help = fmt::format("{} [{}]", setting.help, setting.strategies);
    std::optional<std::string>& value = changes.settings[setting.name];
    if (setting.is_switch) {
      group.app.add_flag(fmt::format("{},!--no-{}", flag, flag.substr(2)), value, help)
          ->group(group.name);
    } else if (CLI::Option* const option = group.add(flag, value, help); !setting.is_word) {
      option->check(numbers_only);
    }
  }
  group.add_read<>(
      "--period-pixels",
      [&changes](const std::string& text) { changes.period_pixels = settings_in(text); },
      "--periods, each in projector pixels");
  group.add("--stripe", changes.stripe_pixels, "--stripes as the width of one in projector pixels");
  group.add("--axis", changes.axes,
            "x: the pattern varies along projector columns; y: rows; both: first x, then y");
  group.add_read<>(
      "--projector",
      [&changes](const std::string& text) { changes.projector = size_from(text, "--projector"); },
      "projector pixels, as 1824x1140");
  group.add("--alpha-p", changes.alpha_p, "amplitude of the patterns, grey levels of 255");
  group.add("--beta-p", changes.beta_p, "darkest grey level of the patterns");
  group.add_read<>(
      "--exposures",
      [&changes](const std::string& text) { changes.exposures = exposures_from(text); },
      "all patterns once for each, as 1,4,16: relative, or in ms; merged to one scan");
  group.add(
      "--motion", changes.motion,
      "so many frames more than a cycle of one sinusoid, shown over and over, become a cloud: "
      "2 or 4 where things move");
}

}  // namespace

void add_pattern_flags(CLI::App& subcommand, SequenceChanges& changes) {
  const FlagGroup group{subcommand, "What the patterns are"};
  add_sequence_flags(group, changes);
  group.add("--binary", changes.binary,
            "in pixels that are dark or bright alone, whose mean is the pattern: for a DMD that "
            "shows a bit at a time");
  const Sequence usual = default_sequence({1024, 1024}, {});
  subcommand.get_option("--strategy")->default_str(usual.strategy.name());
  subcommand.get_option("--axis")->default_str(std::string(name_of(usual.axis)));
  subcommand.get_option("--alpha-p")->default_str(fmt::format("{:g}", usual.light.alpha_p));
  subcommand.get_option("--beta-p")->default_str(fmt::format("{:g}", usual.light.beta_p));
}

void add_marker_flag(CLI::App& subcommand, SequenceChanges& changes) {
  const FlagGroup group{subcommand, "What the patterns are"};
  group.add("--marker", changes.marker,
            "a dark frame ends each cycle, so that a camera that begins anywhere finds its place");
}

void add_scan_flags(CLI::App& subcommand, ScanChanges& changes) {
  const FlagGroup group{subcommand, "What the patterns are, where not as the scan says"};
  add_sequence_flags(group, changes.sequence);
  group.add("--order", changes.order,
            "which frame shows each pattern, counted from 0, as 2,0,1; or code,sinusoids where the "
            "code comes first; else as they come");
}

bool is_pattern_switch(const std::string& word) {
  const std::vector<SettingDescription> settings = strategy_settings();
  return std::any_of(settings.begin(), settings.end(), [&](const SettingDescription& setting) {
    return setting.is_switch && flag_of(setting.name) == word;
  });
}

void add_size_flag(const FlagGroup& group, Size& size, const std::string& help) {
  const auto read = [&size](const std::string& text) { size = size_from(text, "--size"); };
  group.add_read<>("--size", read, help)->default_str(text_of(size));
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
