#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace slipstream {

/// How much of a measurement a finding spoils.
enum class Gravity {
  doubtful,  ///< some of it may be wrong: it goes on with a warning
  wrong,     ///< none of it can be right: it is refused
};

/// A number that a finding rests on.
struct Evidence {
  std::string name;  ///< in words, with its unit
  double value = 0;

  friend bool operator==(const Evidence&, const Evidence&) = default;
};

/// Something about a scan, a scanner or a calibration that does not fit, as data: made by the
/// checks, told by the program.
struct Finding {
  Gravity gravity = Gravity::doubtful;
  std::string what{};  ///< what was seen: "the bands disagree about the phase"
  std::vector<Evidence> evidence{};
  std::string likely{};  ///< the cause that fits best: "frames 0 to 2 are rotated by one"
  std::string advice{};  ///< what to do about it: "try --order 2,0,1,3,4,5"

  friend bool operator==(const Finding&, const Finding&) = default;
};

/// One line for people: what, the evidence, the likely cause, what to do.
std::string text_of(const Finding& finding);

/// Whether any of them refuses.
bool any_wrong(std::span<const Finding> findings);

/// Those whose likely cause does not begin with these words.
std::vector<Finding> without_cause(std::vector<Finding> findings, std::string_view words);

}  // namespace slipstream
