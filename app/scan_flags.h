#pragma once

#include <map>
#include <optional>
#include <string>

#include <CLI/App.hpp>

#include "slipstream/image/size.h"
#include "slipstream/pattern/axis.h"
#include "slipstream/pattern/pattern_set.h"
#include "slipstream/strategy/strategy.h"

namespace slipstream::app {

/// The flags that say what patterns a scan is made of, as far as they were given.
struct ScanFlags {
  std::optional<std::string> strategy;
  std::map<std::string, std::optional<double>> settings;  ///< by the setting's name
  std::optional<std::string> axis;
  std::optional<std::string> projector;  ///< "1824x1140"
  std::optional<double> alpha_p;
  std::optional<double> beta_p;
};

/// Adds --strategy, a flag for each setting of the registry, --axis, --projector, --alpha-p and
/// --beta-p.
void add_scan_flags(CLI::App& subcommand, ScanFlags& flags);

/// The strategy that the flags say, over `otherwise` (what scan.yaml said, or a default): another
/// --strategy replaces it whole, settings alone change it.
Strategy strategy_from(const ScanFlags& flags, const Strategy& otherwise);
Axis axis_from(const ScanFlags& flags, Axis otherwise);
PatternLight light_from(const ScanFlags& flags, PatternLight otherwise);
Size projector_from(const ScanFlags& flags, Size otherwise);

/// "1824x1140". Throws Error, naming the flag, for anything else.
Size size_from(const std::string& text, const std::string& flag);

/// "1824x1140".
std::string text_of(Size size);

}  // namespace slipstream::app
