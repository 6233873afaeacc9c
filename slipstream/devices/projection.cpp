#include "slipstream/devices/projection.h"

#include <cmath>
#include <optional>
#include <thread>

#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream::monitor {
namespace {

using Clock = std::chrono::steady_clock;

Clock::duration from_seconds(double seconds) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

/// Keeps each pattern on for its refreshes, which are counted one by one: the rate that a monitor
/// tells is rounded.
class Pace {
 public:
  Pace(PatternSink& sink, double refresh_hz, int hold)
      : sink_(sink), refresh_(from_seconds(1 / refresh_hz)), hold_(hold) {}

  /// Puts pattern n on when the one before has had its time; returns when that was, or nothing
  /// where it is `over` before.
  template <class Over>
  std::optional<Clock::time_point> next(std::size_t n, const Over& over) {
    late_ = false;
    for (int again = 1; started_ && again < hold_; ++again) {
      if (over()) return std::nullopt;
      refresh(shown_);
    }
    refresh(n);
    started_ = true;
    shown_ = n;
    return last_;
  }
  [[nodiscard]] bool late() const { return late_; }
  [[nodiscard]] std::uint64_t refreshes() const { return refreshes_; }
  /// Whether showing waits for the monitor.
  [[nodiscard]] bool waits() const { return 2 * unpaced_ <= refreshes_; }

 private:
  /// Showing waits for the next refresh, so it is begun half a refresh before. Drivers without a
  /// screen do not wait: then the clock alone says when.
  void refresh(std::size_t n) {
    const Clock::time_point due = last_ + refresh_;
    if (started_) std::this_thread::sleep_until(due - refresh_ / 2);
    sink_.show(n);
    const auto now = Clock::now();
    const bool waited = !started_ || now > due - refresh_ / 4;
    late_ |= started_ && now > due + refresh_ / 2;
    unpaced_ += waited ? 0 : 1;
    last_ = waited ? now : due;
    ++refreshes_;
  }

  PatternSink& sink_;
  Clock::duration refresh_;
  int hold_;
  bool started_ = false, late_ = false;
  std::uint64_t refreshes_ = 0, unpaced_ = 0;
  std::size_t shown_ = 0;
  Clock::time_point last_{};
};

}  // namespace

ProjectionReport project_patterns(PatternSink& sink, std::size_t count,
                                  const ProjectionSettings& settings) {
  if (count == 0) throw Error("no pattern to be shown; one or more are wanted");
  if (settings.hold < 1) {
    throw Error(fmt::format("a pattern cannot stay for {} refreshes; 1 or more", settings.hold));
  }
  if (!(settings.refresh_hz > 0)) {
    throw Error(fmt::format("a projector of {} Hz shows nothing; above 0", settings.refresh_hz));
  }
  ProjectionReport report;
  Pace pace(sink, settings.refresh_hz, settings.hold);
  Clock::time_point first;
  const auto over = [&] { return settings.ends && settings.ends(); };
  while (!over()) {
    const auto n = static_cast<std::size_t>(report.shown % count);
    const std::optional<Clock::time_point> time = pace.next(n, over);
    if (!time) break;
    const PatternSwap swap{report.shown, static_cast<int>(n), *time};
    if (report.shown == 0) first = swap.time;
    ++report.shown;
    if (pace.late()) ++report.late;
    report.seconds = std::chrono::duration<double>(swap.time - first).count();
    if (settings.on_swap) settings.on_swap(swap);
  }
  report.refreshes = pace.refreshes();
  report.waits_for_refresh = pace.waits();
  return report;
}

int refreshes_for_rate(double rate, double refresh_hz) {
  const double wanted = rate > 0 ? refresh_hz / rate : 0;
  const double whole = std::round(wanted);
  if (!(whole >= 1) || std::abs(wanted - whole) > 0.02 * whole || whole > 1e6) {
    throw Error(
        fmt::format("{:g} patterns per second are not {:g} Hz, the monitor's, divided by a "
                    "whole number; as {:g} or {:g}",
                    rate, refresh_hz, refresh_hz, refresh_hz / 2));
  }
  return static_cast<int>(whole);
}

int refreshes_for(std::optional<double> rate, std::optional<int> hold, double refresh_hz) {
  if (rate && hold) throw Error("--rate and --hold exclude each other");
  if (hold && *hold < 1) {
    throw Error(fmt::format("--hold {} is out of range; 1 or more refreshes", *hold));
  }
  if (!rate) return hold.value_or(1);
  if (refresh_hz <= 0) {
    throw Error(fmt::format(
        "--rate {}: the monitor does not say how often it refreshes; use --hold", *rate));
  }
  return refreshes_for_rate(*rate, refresh_hz);
}

}  // namespace slipstream::monitor
