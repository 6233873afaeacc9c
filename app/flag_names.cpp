#include "app/flag_names.h"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "slipstream/cleaner.h"
#include "slipstream/engine.h"
#include "slipstream/scanner.h"
#include "slipstream/setting.h"

namespace slipstream::app {
namespace {

using NameMap = std::map<std::string, std::string, std::less<>>;

/// The options of settings by their names. Settings of virtual worlds are left out: the library
/// names them nowhere, and some are called like other settings.
NameMap make_option_names() {
  // These have no description.
  NameMap options{{"excluded", "exclude"}, {"least_alpha", "least-reflectivity"}};

  const auto add = [&options](const Setting& setting, const auto&) {
    const bool is_offered = *setting.option != '\0';
    if (is_offered && !setting.option_clears) options.emplace(setting.name, setting.option);
  };

  const ReconstructSettings settings;
  ReconstructSettings::for_each_setting(settings, add);
  CleanSettings::for_each_setting(settings.clean, add);
  const PhotometricCalibration photometry;
  PhotometricCalibration::for_each_setting(photometry, add);
  return options;
}

std::string flag_by_description(std::string_view name) {
  static const NameMap options = make_option_names();
  const auto found = options.find(name);
  return found == options.end() ? flag_of(name) : "--" + found->second;
}

/// "slipstream calibrate gamma" of "calibrate_gamma".
std::string command_of(std::string_view operation) {
  std::string words(operation);
  std::ranges::replace(words, '_', ' ');
  return "slipstream " + words;
}

/// The flag or command that a text between backquotes stands for; nullopt if it is neither a
/// setting nor an operation.
std::optional<std::string> named_in(std::string_view quoted) {
  constexpr std::string_view letters = "abcdefghijklmnopqrstuvwxyz0123456789_";
  const std::string_view name = quoted.substr(0, quoted.find_first_not_of(letters));
  const std::string_view rest = quoted.substr(name.size());

  // A name begins with a letter; a command is already in the program's words.
  const bool is_name = !name.empty() && name.front() >= 'a' && name.front() <= 'z';
  const bool is_command = name == "slipstream" || rest.find(" --") != rest.npos;
  if (!is_name || is_command) return std::nullopt;

  if (rest == "()") return command_of(name);
  if (rest.empty()) return flag_by_description(name);

  const bool has_value = rest.size() > 1 && rest.front() == ' ';
  if (!has_value) return std::nullopt;
  return flag_by_description(name) + std::string(rest);
}

}  // namespace

std::string flag_of(std::string_view name) {
  std::string flag = "--" + std::string(name);
  std::ranges::replace(flag, '_', '-');
  return flag;
}

std::string with_flags(std::string_view text) {
  std::string shown;

  while (!text.empty()) {
    // 1. Copy the text up to the next backquote.
    const std::size_t begin = std::min(text.find('`'), text.size());
    shown += text.substr(0, begin);
    text.remove_prefix(begin);
    if (text.empty()) break;

    // 2. Replace the text between this backquote and the next if it names something. Otherwise copy
    // only this backquote: the next one may begin a name.
    const std::size_t end = text.find('`', 1);
    const auto named = end == text.npos ? std::nullopt : named_in(text.substr(1, end - 1));
    shown += named.value_or("`");
    text.remove_prefix(named ? end + 1 : 1);
  }

  return shown;
}

}  // namespace slipstream::app
