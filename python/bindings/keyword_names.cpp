#include <map>
#include <optional>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "base/printable.h"
#include "python/bindings/bindings.h"

namespace slipstream::python {
namespace {

/// The module's words for names of the library, if they differ.
const std::map<std::string_view, std::string_view> other_words{
    // Other names of the same thing in the module.
    {"ambient_light", "scanner.ambient"},
    {"camera_bits", "bits"},
    {"corners", "columns` and `rows"},
    {"dictionary", "marker_bits"},
    {"measured", "spacing` and `row_spacing"},
    {"print estimated", "print_deviation 0.01"},
    {"unwrap()", "unwrap_in_space()"},

    // Things that only the program does.
    {"calibrate_colour()", "slipstream calibrate colour"},
    {"feature", "slipstream live --feature"},
    {"gain", "slipstream live --gain"},
    {"gpu_list()", "slipstream gpu list"},
    {"hold", "slipstream project --hold"},
    {"limit", "slipstream record --limit"},
    {"one_camera", "slipstream reconstruct --one-camera"},
    {"output", "slipstream verify --output"},
    {"pixel_format", "slipstream live --pixel-format"},
    {"publish", "slipstream live --publish"},
    {"region", "slipstream live --region"},
    {"strobe", "slipstream live --strobe"},
    {"trigger", "slipstream live --trigger"},
    {"uniform", "slipstream calibrate gamma --uniform"},
    {"view()", "slipstream view"},
    {"windows", "slipstream reconstruct --windows"},
};

/// In place of a text between backquotes, with them; nullopt if it stays.
std::optional<std::string> words_for(std::string_view quoted) {
  const auto whole = other_words.find(quoted);
  if (whole != other_words.end()) return fmt::format("`{}`", whole->second);

  // A setting with a value.
  const std::string_view name = quoted.substr(0, quoted.find(' '));
  const auto found = other_words.find(name);
  if (found == other_words.end()) return std::nullopt;
  return fmt::format("`{}{}`", found->second, quoted.substr(name.size()));
}

}  // namespace

std::string with_keywords(std::string_view text) {
  return with_names(text, words_for);
}

}  // namespace slipstream::python
