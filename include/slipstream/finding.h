#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace slipstream {

/// How much of a measurement a diagnostic affects.
enum class Gravity {
  doubtful,  ///< some points may be wrong: a warning
  wrong,     ///< no point can be right: the scan is refused
};

/// A measured number that supports a diagnostic.
struct Evidence {
  std::string name;  ///< in words, with its unit
  double value = 0;

  friend bool operator==(const Evidence&, const Evidence&) = default;
};

/// A diagnostic of a scan, a scanner or a calibration, as data. The checks make it, the program
/// prints it.
struct Finding {
  Gravity gravity = Gravity::doubtful;
  std::string what{};  ///< the symptom: "the bands disagree about the phase"
  std::vector<Evidence> evidence{};
  std::string likely{};  ///< the likely cause: "frames 0 to 2 are rotated by one"
  std::string advice{};  ///< the remedy: "try --order 2,0,1,3,4,5"

  friend bool operator==(const Finding&, const Finding&) = default;
};

/// One line of text: symptom, evidence, likely cause, remedy.
std::string text_of(const Finding& finding);

/// True if any diagnostic refuses the scan.
bool any_wrong(std::span<const Finding> findings);

/// Drops diagnostics whose likely cause begins with `words`.
std::vector<Finding> without_cause(std::vector<Finding> findings, std::string_view words);

}  // namespace slipstream
