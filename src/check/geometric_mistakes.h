#pragma once

#include <vector>

#include "check/possible_mistakes.h"
#include "slipstream/scanner.h"
#include "slipstream/sequence.h"

namespace slipstream {

/// Mistakes of a scan whose coordinates are right: another axis, turned pictures, and scanner files
/// that are inverted, swapped or of another size.
std::vector<PossibleMistake> geometric_mistakes(const Scanner& scanner, const Sequence& sequence);

}  // namespace slipstream
