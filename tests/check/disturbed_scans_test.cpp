#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "slipstream/check.h"
#include "slipstream/engine.h"
#include "tests/check/mistakes.h"
#include "tests/check/random_scans.h"

namespace slipstream::disturbed_scans_test {

/// What goes wrong while a scan is taken, for one of so many frames.
std::vector<Mistake> disturbances(const Scan& scan, int frame) {
  const int count = scan.frames.count();
  const int next = (frame + 1) % count, before = (frame + count - 1) % count;
  std::vector<int> swapped = all_frames(count);
  std::swap(swapped[static_cast<std::size_t>(frame)], swapped[static_cast<std::size_t>(next)]);
  const int half = scan.frames.size().height / 2;
  std::vector<Mistake> list{
      {"swapped", taken_in_order(swapped), {}},
      {"repeated", copied(frame, next), {}},
      {"black", pixels({frame}, [](double, int, int) { return 0; }), {}},
      {"half lost",
       pixels({frame}, [half](double level, int, int row) { return row < half ? level : 0; }),
       {}},
      {"half stale", copied(before, frame, 0.5), {}},
      {"flicker", pixels({frame}, [](double level, int, int) { return 1.05 * level; }), {}},
      {"other axis",
       [](Scan& s) { s.sequence.axis = s.sequence.axis == Axis::x ? Axis::y : Axis::x; },
       {}}};
  if (scan.sequence.strategy.settings().contains("high")) {
    const double high = scan.sequence.strategy.settings().at("high").number();
    const double step = scan.sequence.strategy.layout().bands.size() > 1 &&
                                order_source(scan.sequence.strategy.layout()) == OrderSource::bands
                            ? scan.sequence.strategy.settings().at("low").number()
                            : 1;
    list.push_back({"wrong --high", with_setting("high", high + step), {}});
  }
  return list;
}

struct Shown {
  std::size_t points = 0, wrong = 0;
};

/// Points of the cloud that are off by more than five standard deviations and 1 mm.
Shown shown_points(const Scan& scan, const Image<double>& truth) {
  Engine engine(setup_for(scan));
  Cloud cloud;
  Maps maps;
  engine.cloud_and_maps(scan.frames, cloud, maps);
  const Uncertainty uncertainty = engine.uncertainty(cloud, maps, scan.frames);
  Shown shown;
  for (std::size_t i = 0; i < truth.pixel_count(); ++i) {
    if (cloud.validity.begin()[i] != Validity::valid) continue;
    ++shown.points;
    const double error = std::abs(static_cast<double>(cloud.z.begin()[i]) - truth.begin()[i]);
    if (!(error <= 1) && !(error <= 5 * static_cast<double>(uncertainty.z.begin()[i])))
      ++shown.wrong;
  }
  return shown;
}

/// Whether the frames of a scan say nothing of each other: three unknowns in three frames, so that
/// a frame brighter by 5 percent makes the frames of another place.
/// docs/reference/scan-validation.md says so.
bool is_without_redundancy(const Scan& scan) {
  return scan.frames.count() == 3 && scan.sequence.strategy.layout().bands.size() == 1 &&
         order_source(scan.sequence.strategy.layout()) == OrderSource::bands;
}

/// The disturbed scans so far.
struct Tally {
  int disturbed = 0, silent = 0;
  std::map<std::string, Shown> shown{};  ///< of those without a finding, by disturbance
};

Tally& tally() {
  static Tally all;
  return all;
}

constexpr int scan_count = 60;

/// Right scan `number`; they come one after the other from one seed.
RandomScan right_scan(int number) {
  static std::optional<RandomScans> scans;
  static int next = -1;

  if (number != next) {
    scans.emplace(42, std::vector<int>{8});
    for (next = 0; next < number; ++next) scans->next();
  }
  ++next;
  return scans->next();
}

/// One right scan with each disturbance; `scan_count` itself: the share over all scans before.
class DisturbedScans : public testing::TestWithParam<int> {};

TEST_P(DisturbedScans, ShowHardlyAWrongPointWithoutAFinding) {
  const int number = GetParam();
  if (number == scan_count) {
    Shown all;
    for (const auto& [name, shown] : tally().shown) {
      fmt::print("{}: {} points without a finding, {} wrong\n", name, shown.points, shown.wrong);
      all.points += shown.points;
      all.wrong += shown.wrong;
    }
    fmt::print("{} disturbed scans, {} reported; the others have {} points, {} wrong\n",
               tally().disturbed, tally().disturbed - tally().silent, all.points, all.wrong);

    ASSERT_GT(all.points, 0U) << "the share is of the cases before; run the whole suite";
    EXPECT_LE(1000 * all.wrong, all.points);
    return;
  }

  const RandomScan right = right_scan(number);
  for (const Mistake& disturbance : disturbances(right.scan, number % right.scan.frames.count())) {
    Scan scan = right.scan;
    disturbance.make(scan);
    const bool is_silent = check_scan(scan).findings.empty();
    ++tally().disturbed;
    if (!is_silent) continue;
    ++tally().silent;
    if (disturbance.name == "flicker" && is_without_redundancy(scan)) continue;

    const Shown shown = shown_points(scan, right.truth.depth);
    EXPECT_LE(1000 * shown.wrong, shown.points)
        << right.name << ", " << disturbance.name << ", scan " << number << " of seed 42";
    tally().shown[disturbance.name].points += shown.points;
    tally().shown[disturbance.name].wrong += shown.wrong;
  }
}

INSTANTIATE_TEST_SUITE_P(Seed, DisturbedScans, testing::Range(0, scan_count + 1));

}  // namespace slipstream::disturbed_scans_test
