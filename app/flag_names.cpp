#include "app/flag_names.h"

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "base/printable.h"

namespace slipstream::app {
namespace {

/// Names of earlier versions, and those of now.
constexpr std::pair<std::string_view, std::string_view> former_names[] = {
    {"min-modulation", "minimum-modulation"},
    {"min-component", "smallest-component"},
    {"max-sigma", "largest-sigma"},
    {"fill", "widest-gap"},
    {"smooth", "smoothing"},
    {"ambient", "ambient-light"}};

/// The flag of a name in a text of the library; two differ from their settings.
std::string flag_named(std::string_view name) {
  if (name == "excluded") return "--exclude";
  if (name == "least_alpha") return "--least-reflectivity";
  return flag_of(name);
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
  if (rest.empty()) return flag_named(name);

  const bool has_value = rest.size() > 1 && rest.front() == ' ';
  if (!has_value) return std::nullopt;
  return flag_named(name) + std::string(rest);
}

}  // namespace

std::string flag_of(std::string_view name) {
  std::string flag = "--" + std::string(name);
  std::ranges::replace(flag, '_', '-');
  return flag;
}

std::string with_former_name(const std::string& flag) {
  for (const auto& [former, now] : former_names) {
    if (flag == "--" + std::string(now)) return flag + ",--" + std::string(former);
  }
  return flag;
}

bool is_former_name(std::string_view name) {
  return present_name(name) != name;
}

std::string present_name(std::string_view name) {
  for (const auto& [former, now] : former_names) {
    if (name == former) return std::string(now);
  }
  return std::string(name);
}

std::string with_flags(std::string_view text) {
  return with_names(text, named_in);
}

}  // namespace slipstream::app
