#include "python/bindings/settings_help.h"

#include <sstream>
#include <string>
#include <string_view>

namespace slipstream::python {

std::string reconstruct_help() {
  const ReconstructSettings usual;

  return keyword_help("backend", "str", "fused",
                      "fused, gpu or gpu:NUMBER, lut, closed-form, equation or intensity-ratio") +
         keyword_help("cue_rule", "str", name_of(usual.cue_rule),
                      "how a cue in the frames gives the fringe order: consensus, likelihood or "
                      "published") +
         keyword_help("raw", "bool", false, "no cleaning, any depth") + described_help(usual) +
         described_help(usual.clean);
}

std::string with_settings(const std::string& entries, const std::string& docstring) {
  constexpr std::string_view place = "{settings}\n";
  const std::size_t at = docstring.find(place);
  const std::size_t line_start = docstring.rfind('\n', at) + 1;
  const std::string indent = docstring.substr(line_start, at - line_start);

  std::string filled = docstring.substr(0, line_start);
  std::istringstream lines(entries);
  for (std::string line; std::getline(lines, line);) filled += indent + line + '\n';

  return filled + docstring.substr(at + place.size());
}

}  // namespace slipstream::python
