#include "slipstream/check/finding.h"

#include <algorithm>

#include <fmt/format.h>

namespace slipstream {

std::string text_of(const Finding& finding) {
  std::string numbers;
  for (const Evidence& evidence : finding.evidence) {
    numbers +=
        fmt::format("{}{} = {:.3g}", numbers.empty() ? "" : ", ", evidence.name, evidence.value);
  }
  std::string text = finding.what;
  if (!numbers.empty()) text += fmt::format(" ({})", numbers);
  if (!finding.likely.empty()) text += fmt::format("; likely {}", finding.likely);
  if (!finding.advice.empty()) text += fmt::format("; {}", finding.advice);
  return text;
}

bool any_wrong(std::span<const Finding> findings) {
  return std::any_of(findings.begin(), findings.end(),
                     [](const Finding& finding) { return finding.gravity == Gravity::wrong; });
}

std::vector<Finding> without_cause(std::vector<Finding> findings, std::string_view words) {
  std::erase_if(findings,
                [&](const Finding& finding) { return finding.likely.starts_with(words); });
  return findings;
}

}  // namespace slipstream
