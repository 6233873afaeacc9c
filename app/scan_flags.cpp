#include "app/scan_flags.h"

#include <algorithm>
#include <charconv>
#include <string_view>

#include <fmt/format.h>

#include "slipstream/error/error.h"

namespace slipstream::app {
namespace {

/// low_steps to --low-steps.
std::string flag_of(std::string setting) {
  std::replace(setting.begin(), setting.end(), '_', '-');
  return "--" + setting;
}

}  // namespace

void add_scan_flags(CLI::App& subcommand, ScanFlags& flags) {
  const std::string group = "What the patterns are";
  subcommand
      .add_option("--strategy", flags.strategy,
                  fmt::format("{}", fmt::join(strategy_names(), ", ")))
      ->group(group);
  for (const SettingDescription& setting : strategy_settings()) {
    subcommand
        .add_option(flag_of(setting.name), flags.settings[setting.name],
                    fmt::format("{} [{}]", setting.help, setting.strategies))
        ->group(group);
  }
  subcommand
      .add_option("--axis", flags.axis, "x: the pattern varies along projector columns; y: rows")
      ->group(group);
  subcommand.add_option("--projector", flags.projector, "projector pixels, as 1824x1140")
      ->group(group);
  subcommand
      .add_option("--alpha-p", flags.alpha_p, "amplitude of the patterns, grey levels of 255")
      ->group(group);
  subcommand.add_option("--beta-p", flags.beta_p, "darkest grey level of the patterns")
      ->group(group);
}

Strategy strategy_from(const ScanFlags& flags, const Strategy& otherwise) {
  const bool replaced = flags.strategy && *flags.strategy != name_of(otherwise);
  StrategySettings settings = replaced ? StrategySettings{} : settings_of(otherwise);
  for (const auto& [name, value] : flags.settings) {
    if (value) settings[name] = *value;
  }
  return make_strategy(flags.strategy.value_or(std::string(name_of(otherwise))), settings);
}

Axis axis_from(const ScanFlags& flags, Axis otherwise) {
  return flags.axis ? axis_named(*flags.axis) : otherwise;
}

PatternLight light_from(const ScanFlags& flags, PatternLight otherwise) {
  const PatternLight light{.alpha_p = flags.alpha_p.value_or(otherwise.alpha_p),
                           .beta_p = flags.beta_p.value_or(otherwise.beta_p)};
  require_valid(light);
  return light;
}

Size projector_from(const ScanFlags& flags, Size otherwise) {
  return flags.projector ? size_from(*flags.projector, "--projector") : otherwise;
}

Size size_from(const std::string& text, const std::string& flag) {
  constexpr int largest = 65536;
  Size size;
  const char* const end = text.data() + text.size();
  const auto [middle, bad_width] = std::from_chars(text.data(), end, size.width);
  bool good = bad_width == std::errc() && middle != end && *middle == 'x';
  if (good) {
    const auto [rest, bad_height] = std::from_chars(middle + 1, end, size.height);
    good = bad_height == std::errc() && rest == end;
  }
  good = good && size.width >= 1 && size.height >= 1 && size.width <= largest &&
         size.height <= largest;
  if (!good) {
    throw Error(fmt::format("{} '{}' is not a size; give width x height in pixels, as 1824x1140",
                            flag, text));
  }
  return size;
}

std::string text_of(Size size) {
  return fmt::format("{}x{}", size.width, size.height);
}

}  // namespace slipstream::app
