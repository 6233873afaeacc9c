#include "slipstream/live/finding_log.h"

#include <algorithm>
#include <utility>

namespace slipstream {

void FindingLog::replace(std::vector<Finding> findings, std::uint64_t sequence) {
  for (LiveFinding& told : told_) {
    const bool found = std::any_of(findings.begin(), findings.end(), [&](const Finding& finding) {
      return finding.what == told.finding.what;
    });
    if (!told.end && !found) told.end = sequence;
  }
  for (const Finding& finding : findings) {
    const bool lasts = std::any_of(told_.begin(), told_.end(), [&](const LiveFinding& told) {
      return !told.end && told.finding.what == finding.what;
    });
    if (!lasts) told_.push_back({finding, sequence});
  }
  while (told_.size() > most) {
    const auto ended = std::find_if(told_.begin(), told_.end(),
                                    [](const LiveFinding& told) { return told.end.has_value(); });
    if (ended == told_.end()) break;
    told_.erase(ended);
  }
  current_ = std::move(findings);
}

}  // namespace slipstream
