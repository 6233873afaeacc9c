#include "slipstream/live_statistics.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

namespace slipstream {
namespace {

std::string text_of_cleaned(const ValidityCounts& cleaned) {
  const std::size_t points = cleaned[static_cast<std::size_t>(Validity::valid)];
  std::string text = points == 0 ? "" : fmt::format("\nnewest cloud: {} points", points);

  std::string removed;
  for (std::size_t i = 1; i < validity_count; ++i) {
    if (cleaned[i] == 0) continue;
    removed += fmt::format("{}{}: {}", removed.empty() ? "\nremoved from the newest cloud, " : ", ",
                           name_of(static_cast<Validity>(i)), cleaned[i]);
  }

  return text + removed;
}

}  // namespace

std::string text_of(const LiveStatistics& statistics) {
  const LiveStatistics::Frames& frames = statistics.frames;
  std::string text = fmt::format(
      "{} frames in {:.1f} s: {} lost, {} overwritten, {} repeated\n"
      "{} clouds, {:.1f} per second{}; {} windows lost, {} skipped, {} "
      "resynchronisations\n"
      "capture to cloud: median {:.2f} ms, 99 % below {:.2f} ms, maximum {:.2f} ms{}",
      frames.captured, statistics.seconds, frames.lost, frames.overwritten, frames.repeated,
      statistics.clouds, statistics.clouds_per_second,
      statistics.backend.empty() ? "" : ", backend " + statistics.backend, statistics.windows_lost,
      statistics.windows_skipped, statistics.resynchronisations, statistics.latency.p50,
      statistics.latency.p99, statistics.latency.max, text_of_cleaned(statistics.cleaned));

  if (statistics.track) text += fmt::format("\n{}", text_of(*statistics.track));
  if (statistics.model) text += fmt::format("\n{}", text_of(*statistics.model));

  return text;
}

}  // namespace slipstream
