#include "slipstream/live/live_statistics.h"

#include <fmt/format.h>

namespace slipstream {

namespace {

std::string text_of_cleaned(const ValidityCounts& cleaned) {
  std::string text;
  for (std::size_t i = 1; i < validity_count; ++i) {
    if (cleaned[i] == 0) continue;
    text += fmt::format("{}{}: {}", text.empty() ? "\nleft out of the newest cloud, " : ", ",
                        name_of(static_cast<Validity>(i)), cleaned[i]);
  }
  return text;
}

}  // namespace

std::string text_of(const LiveStatistics& statistics) {
  const LiveStatistics::Frames& frames = statistics.frames;
  std::string text = fmt::format(
      "{} frames in {:.1f} s: {} lost, {} overwritten, {} repeated\n"
      "{} clouds, {:.1f} per second{}; {} windows without one, {} resynchronisations\n"
      "capture to cloud: {:.2f} ms half of the time, {:.2f} ms for 99 of 100, {:.2f} at most{}",
      frames.captured, statistics.seconds, frames.lost, frames.overwritten, frames.repeated,
      statistics.clouds, statistics.clouds_per_second,
      statistics.backend.empty() ? "" : ", backend " + statistics.backend, statistics.windows_lost,
      statistics.resynchronisations, statistics.latency.p50, statistics.latency.p99,
      statistics.latency.max, text_of_cleaned(statistics.cleaned));
  if (statistics.track) text += fmt::format("\n{}", text_of(*statistics.track));
  if (statistics.model) text += fmt::format("\n{}", text_of(*statistics.model));
  return text;
}

}  // namespace slipstream
