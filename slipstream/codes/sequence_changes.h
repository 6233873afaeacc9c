#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "slipstream/codes/sequence.h"

namespace slipstream {

/// What is said of a sequence over what is known of it: flags over a file, or over a default.
struct SequenceChanges {
  std::optional<std::string> strategy{};  ///< by name: replaces the one known whole
  std::map<std::string, std::optional<std::string>> settings{};  ///< alone they change it
  std::optional<std::vector<double>> period_pixels{};  ///< of `periods`, in projector pixels
  std::optional<double> stripe_pixels{};               ///< of `stripes`, likewise
  std::optional<std::string> axes{};                   ///< see set_axes
  std::optional<double> alpha_p{};
  std::optional<double> beta_p{};
  std::optional<Size> projector{};
  std::optional<std::vector<double>> exposures{};
  bool marker = false;  ///< a marker ends each cycle, whatever was known
  bool binary = false;  ///< shown a bit at a time, whatever was known
  std::optional<int> motion{};
  /// Takes the place of what is known, but for a projector that it does not say.
  std::optional<Sequence> known{};
};

/// Those after which a sequence is that one, whatever was known.
SequenceChanges changes_to(const Sequence& sequence);

/// The sequence with those changes. Throws Error for a strategy, a setting or a light that there is
/// not.
Sequence changed(const Sequence& known, const SequenceChanges& changes);

/// The default strategy for that projector, with those changes. Throws Error where the projector
/// cannot show it.
Sequence default_sequence(Size projector, const SequenceChanges& changes);

}  // namespace slipstream
