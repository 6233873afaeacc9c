#pragma once

#include <string>
#include <string_view>

namespace slipstream {

/// The numbers of a run's statistics in the text form of Prometheus: "slipstream_" and the names on
/// the way to each, counts that only grow as counters that end in "_total". Of a list of what has
/// names these are labels, of a list of numbers their places; of any other its length is told.
/// Throws Error for what is no JSON.
std::string metrics_of(std::string_view statistics);

}  // namespace slipstream
