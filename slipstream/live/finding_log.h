#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "slipstream/check/finding.h"

namespace slipstream {

/// A finding of a live scan, from the frame on at which it was first told.
struct LiveFinding {
  Finding finding;          ///< as it was told first
  std::uint64_t begin = 0;  ///< sequence of the newest frame that was looked at then
  /// That of the first look that did not find it again; none while it lasts.
  std::optional<std::uint64_t> end{};

  friend bool operator==(const LiveFinding&, const LiveFinding&) = default;
};

/// When what began and ended, look by look. Findings of one `what` are the same one, though its
/// numbers change. Nothing is allocated while all is right.
class FindingLog {
 public:
  /// The oldest that have ended are forgotten where there would be more.
  static constexpr std::size_t most = 256;

  /// What a look has found takes the place of what the one before did.
  void replace(std::vector<Finding> findings, std::uint64_t sequence);

  /// By the newest look.
  [[nodiscard]] const std::vector<Finding>& current() const { return current_; }
  /// All, in the order in which they began.
  [[nodiscard]] const std::vector<LiveFinding>& told() const { return told_; }

 private:
  std::vector<Finding> current_;
  std::vector<LiveFinding> told_;
};

}  // namespace slipstream
