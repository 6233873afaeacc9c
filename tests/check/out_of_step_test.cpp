// Frames that contain a share of the pattern before, as of a camera out of step.
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/statistics.h"
#include "slipstream/check.h"
#include "slipstream/engine.h"
#include "slipstream/virtual_world.h"
#include "tests/check/mistakes.h"
#include "tests/check/real_sets.h"
#include "tests/simulate/traced_scene.h"

namespace slipstream::out_of_step_test {

namespace fs = std::filesystem;

Scan virtual_scan(const std::string& scene, const Strategy& strategy) {
  const VirtualWorld world =
      virtual_world({.scene = scene, .camera = {320, 240}, .world = "bench"});
  return {.frames =
              scan_of_scene(scene, world.scanner, pattern_set(strategy, Axis::x), world.photometry)
                  .frames,
          .sequence = {strategy, Axis::x, {}, world.scanner.projector.size},
          .scanner = as_calibrated(world)};
}

/// What stands before each frame: a place in the scan.
using Before = std::vector<int>;

/// Each frame with a share of the one before, from `top` in the first row to `bottom` in the last.
Scan mixed(const Scan& scan, const Before& before, double top, double bottom) {
  const Pictures right = pictures_of(scan);
  Pictures wrong = right;
  for (std::size_t n = 0; n < right.size(); ++n) {
    const auto& last = right[static_cast<std::size_t>(before[n])];
    for (int row = 0; row < right[n].height(); ++row) {
      const double s = top + (bottom - top) * row / right[n].height();
      for (int column = 0; column < right[n].width(); ++column) {
        wrong[n](column, row) = static_cast<std::uint8_t>(
            std::lround((1 - s) * right[n](column, row) + s * last(column, row)));
      }
    }
  }
  Scan made = scan;
  made.frames = FrameSet(std::move(wrong));
  return made;
}

Cloud cloud_of(const Scan& scan) {
  Engine engine(setup_for(scan));
  Cloud cloud;
  engine.cloud(scan.frames, cloud);
  return cloud;
}

/// Median distance of the depths, mm.
double median_error(const Cloud& cloud, const Cloud& right) {
  std::vector<double> off;
  for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
    const double error = std::abs(static_cast<double>(cloud.z.begin()[i]) - right.z.begin()[i]);
    if (std::isfinite(error)) off.push_back(error);
  }
  return off.empty() ? 0 : quantile(off, 0.5);
}

bool names_out_of_step(const Finding& finding) {
  return std::ranges::count(finding.causes, CauseKind::out_of_step, &Cause::kind) > 0;
}

/// How scans with each share of the frame before are told.
struct Table {
  int made = 0, told = 0, refused = 0, named = 0, harmful = 0, missed = 0, missed_in_bands = 0;

  void add(const std::string& name, const Scan& wrong, const Cloud& right, bool in_bands) {
    const ScanFindings found = check_scan(wrong);
    const double error = median_error(cloud_of(wrong), right);
    const bool has_cause = std::ranges::any_of(found.findings, names_out_of_step);
    const bool is_refused = any_wrong(found.findings);
    ++made;
    told += found.findings.empty() ? 0 : 1;
    refused += is_refused ? 1 : 0;
    named += has_cause ? 1 : 0;
    if (error < 1) return;
    ++harmful;
    if (is_refused) return;
    ++(in_bands ? missed_in_bands : missed);
    fmt::print("{}: off by {:.1f} mm; {}\n", name, error,
               found.findings.empty() ? "silent" : text_of(found.findings.front()));
  }
};

Table table_of(const std::string& name, const Scan& scan, int percent_step) {
  const int count = scan.frames.count();
  EXPECT_TRUE(check_scan(scan).findings.empty()) << name;
  Before cycle, standing;
  for (int n = 0; n < count; ++n) {
    cycle.push_back((n + count - 1) % count);
    standing.push_back(std::max(0, n - 1));
  }
  Before bands = cycle;
  for (const Band& band : scan.sequence.strategy.layout().bands) {
    const auto run = step_run(band);
    if (run) bands[static_cast<std::size_t>(run->first)] = run->first + run->steps - 1;
  }
  const Cloud right = cloud_of(scan);
  Table table;
  for (int percent = 3; percent <= 50; percent += percent_step) {
    const double s = percent / 100.0;
    for (const bool by_row : {false, true}) {
      const std::string words = fmt::format("{}, {} %{}", name, percent, by_row ? " by row" : "");
      const double top = by_row ? 0 : s;
      table.add(words, mixed(scan, cycle, top, s), right, false);
      table.add(words + ", the first stood", mixed(scan, standing, top, s), right, false);
      table.add(words + ", in bands", mixed(scan, bands, top, s), right, true);
    }
  }
  fmt::print(
      "{}: {} made, {} told, {} refused, {} with the cause; {} off by 1 mm, {} + {} passed\n", name,
      table.made, table.told, table.refused, table.named, table.harmful, table.missed,
      table.missed_in_bands);
  return table;
}

// As in live.
TEST(OutOfStepWhatMayMove, IsToldFromWhatIsOutOfStep) {
  const Scan right = virtual_scan("statue", make_strategy("dual-frequency", {{"steps", 4}}));
  const Before cycle{7, 0, 1, 2, 3, 4, 5, 6};
  const CheckSettings settings{.moving = true};
  EXPECT_TRUE(check_scan(right, settings).findings.empty());
  for (const double share : {0.05, 0.1, 0.2, 0.3, 0.4, 0.5}) {
    const auto found = check_scan(mixed(right, cycle, share, share), settings).findings;
    const auto named = std::ranges::find_if(found, names_out_of_step);
    ASSERT_NE(named, found.end()) << share;
    EXPECT_NE(causes_of(*named).find("an object that moved"), std::string::npos);
  }
}

// One half takes all contrast where bits differ.
TEST(OutOfStepCode, IsNamedAtOneHalf) {
  const Scan right = virtual_scan("statue", make_strategy("gray", {{"bits", 7}}));
  const auto found = check_scan(mixed(right, {8, 0, 1, 2, 3, 4, 5, 6, 7}, 0.5, 0.5)).findings;
  EXPECT_TRUE(std::ranges::any_of(found, names_out_of_step)) << text_of(found.at(0));
}

// Each band repeats on its own, an odd number of steps.
TEST(OutOfStepBands, AreNamedWithTheirShare) {
  const Scan right = virtual_scan("statue", make_strategy("dual-frequency", {{"steps", 3}}));
  for (const double share : {0.15, 0.35}) {
    const auto found = check_scan(mixed(right, {2, 0, 1, 5, 3, 4}, share, share)).findings;
    const auto named = std::ranges::find_if(found, names_out_of_step);
    ASSERT_NE(named, found.end()) << share;
    EXPECT_NEAR(named->evidence.front().value, 100 * share, 0.4);
  }
}

// A camera that exposes too early: the share is of the pattern after.
TEST(OutOfStepTooEarly, IsNamedWithItsShareAndRemedy) {
  for (const Strategy& strategy :
       {make_strategy("dual-frequency", {{"steps", 5}, {"high", 12}}),
        make_strategy("gray-phase", {{"steps", 4}}), make_strategy("multi-frequency", {})}) {
    const Scan right = virtual_scan("statue", strategy);
    Before after;
    for (int n = 1; n <= right.frames.count(); ++n) after.push_back(n % right.frames.count());

    for (const double share : {0.05, 0.15}) {
      const auto found = check_scan(mixed(right, after, share, share)).findings;
      const auto named = std::ranges::find_if(found, names_out_of_step);
      ASSERT_NE(named, found.end()) << label_of(strategy) << ", " << share;
      EXPECT_NEAR(named->evidence.front().value, 100 * share, 2) << label_of(strategy);
      EXPECT_NE(remedies_of(*named).find("expose earlier"), std::string::npos);
    }
  }
}

/// A scene and a strategy, at each so many percent; an empty scene: the skull.
struct Stepped {
  int percent_step = 1;
  std::string scene{};
  Strategy strategy = GrayPhase{};
};

/// The scans of one scene and strategy; the shares over all scans are the last case.
class OutOfStep : public testing::TestWithParam<std::optional<Stepped>> {
 protected:
  static inline Table all;
};

// Shares from 3 to 50 percent. If each band repeats on its own, some shares move the coordinate by
// whole periods, so that all frames agree: docs/reference/scan-validation.md.
TEST_P(OutOfStep, IsRefusedWhereTheCloudIsOff) {
  if (!GetParam()) {
    ASSERT_GT(all.made, 0) << "shares are of the cases before; run the whole suite";
    EXPECT_LE(50 * all.missed_in_bands, all.harmful);
    // Within bands some shares are the same as another origin.
    EXPECT_GE(100 * all.named, 95 * all.told);
    return;
  }

  const auto& [percent_step, scene, strategy] = *GetParam();
  Scan scan;
  if (!scene.empty()) {
    scan = virtual_scan(scene, strategy);
  } else {
    const fs::path folder = shared_data() / "skull";
    if (!fs::exists(folder)) GTEST_SKIP() << folder << " is not there";
    scan = skull();
    scan.scanner->calibrated_depths = skull_depths;
  }

  const std::string name = scene.empty() ? "skull" : fmt::format("{}, {}", scene, strategy.name());
  const Table table = table_of(name, scan, percent_step);
  EXPECT_EQ(table.missed, 0);
  all.made += table.made;
  all.harmful += table.harmful;
  all.missed_in_bands += table.missed_in_bands;
  all.told += table.told;
  all.named += table.named;
}

std::vector<std::optional<Stepped>> every(int percent_step) {
  std::vector<std::optional<Stepped>> parts{Stepped{percent_step}};
  for (const char* const scene : {"statue", "sphere", "boxes"}) {
    for (const Strategy& strategy :
         {make_strategy("dual-frequency", {{"steps", 4}}), make_strategy("gray-phase", {}),
          make_strategy("multi-frequency", {}), make_strategy("gray", {{"bits", 7}})}) {
      parts.push_back(Stepped{percent_step, scene, strategy});
    }
  }
  parts.push_back({});
  return parts;
}

std::string name_of_part(const testing::TestParamInfo<std::optional<Stepped>>& info) {
  if (!info.param) return "shares";
  const auto& [percent_step, scene, strategy] = *info.param;
  if (scene.empty()) return "skull";
  std::string name = scene + "_" + std::string(strategy.name());
  std::ranges::replace(name, '-', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(EachPercent, OutOfStep, testing::ValuesIn(every(1)), name_of_part);
INSTANTIATE_TEST_SUITE_P(Sixteenth, OutOfStep, testing::ValuesIn(every(16)), name_of_part);

}  // namespace slipstream::out_of_step_test
