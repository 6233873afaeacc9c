// Maps of other programs: right ones are accepted, and those in another form are named.
#include "check/map_check.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <ostream>
#include <string>
#include <tuple>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/numbers.h"
#include "check/map_evidence.h"
#include "slipstream/engine.h"
#include "slipstream/named_scenes.h"
#include "slipstream/scan.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"

namespace slipstream::map_check_test {

Scanner rig() {
  Scanner scanner = example_scanner({160, 120});
  scanner.calibrated_depths = {450, 750};
  return scanner;
}

/// The coordinates that a scan of the scene gives.
Image<double> coordinates_of(const std::string& scene, Axis axis) {
  const Scanner scanner = rig();
  const Sequence sequence{.strategy = make_strategy("dual-frequency", {{"high", 16}, {"low", 1}}),
                          .axis = axis};
  VirtualScan taken = take_scan(scanner, scene_named(scene, scanner), pattern_set(sequence),
                                {.noise_variance = 1.6});
  const Scan scan =
      merged({.frames = std::move(taken.frames), .sequence = sequence, .scanner = scanner});

  Engine engine(setup_for(scan));
  return measured_coordinates(engine, scan.frames);
}

int length_of(Axis axis) {
  return length_along(axis, rig().projector.size);
}

/// The map that a program writes in that form.
Image<double> written_as(const MapForm& form, Image<double> coordinates, Axis axis = Axis::x) {
  const double origin = origin_of(form, length_of(axis));
  const double slope = (form.backwards ? -1 : 1) * span_of(form, length_of(axis));
  for (double& value : coordinates) value = origin + slope * value;
  return coordinates;
}

std::vector<Finding> findings_of(Image<double> map, const MapForm& form, Axis axis = Axis::x) {
  std::vector<Finding> findings = leave_out_shared_values(map);
  const Image<double> coordinates = coordinates_of_map(std::move(map), form, length_of(axis));
  for (Finding& finding : check_map(coordinates, form, rig(), axis).findings) {
    findings.push_back(std::move(finding));
  }
  return findings;
}

const MapForm phase{.unit = MapUnit::phase, .periods = 16};

class MapCheckRightMap : public testing::TestWithParam<std::tuple<std::string, Axis>> {};

TEST_P(MapCheckRightMap, IsAcceptedInEveryForm) {
  const auto& [scene, axis] = GetParam();
  const Image<double> coordinates = coordinates_of(scene, axis);

  MapForm from_minus_pi = phase, falling{.unit = MapUnit::pixels, .backwards = true};
  from_minus_pi.origin = -std::numbers::pi;
  for (const MapForm& form : {MapForm{}, phase, from_minus_pi, falling}) {
    const std::vector<Finding> findings =
        findings_of(written_as(form, coordinates, axis), form, axis);
    for (const Finding& finding : findings) ADD_FAILURE() << text_of(finding);
  }
}

TEST_P(MapCheckRightMap, MayHaveWholePixels) {
  const auto& [scene, axis] = GetParam();
  const MapForm pixels{.unit = MapUnit::pixels};
  Image<double> map = written_as(pixels, coordinates_of(scene, axis), axis);
  for (double& value : map) value = std::round(value);

  const std::vector<Finding> findings = findings_of(map, pixels, axis);
  for (const Finding& finding : findings) ADD_FAILURE() << text_of(finding);
}

INSTANTIATE_TEST_SUITE_P(Scenes, MapCheckRightMap,
                         testing::Combine(testing::Values("statue", "sphere", "boxes", "fish"),
                                          testing::Values(Axis::x, Axis::y)),
                         [](const auto& info) {
                           return std::get<0>(info.param) + "_" +
                                  std::string(name_of(std::get<1>(info.param)));
                         });

/// A map that is not in the form that its user names, and the settings that name it rightly.
struct MistakenMap {
  const char* name;
  MapForm is, given;
  std::vector<SettingChange> remedy;
  Severity severity = Severity::wrong;

  friend std::ostream& operator<<(std::ostream& out, const MistakenMap& map) {
    return out << map.name;
  }
};

class MapCheckMistakenForm : public testing::TestWithParam<MistakenMap> {};

TEST_P(MapCheckMistakenForm, IsNamed) {
  const MistakenMap& mistaken = GetParam();
  const std::vector<Finding> findings =
      findings_of(written_as(mistaken.is, coordinates_of("statue", Axis::x)), mistaken.given);

  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings.front().severity, mistaken.severity) << text_of(findings.front());
  ASSERT_FALSE(findings.front().remedies.empty()) << text_of(findings.front());
  EXPECT_EQ(findings.front().remedies.front().settings, mistaken.remedy)
      << text_of(findings.front());
}

MapForm phase_of(double periods, std::optional<double> origin = {}, bool backwards = false) {
  return {.unit = MapUnit::phase, .periods = periods, .origin = origin, .backwards = backwards};
}

const MapForm coordinate{}, pixels{.unit = MapUnit::pixels};

INSTANTIATE_TEST_SUITE_P(
    Forms, MapCheckMistakenForm,
    testing::Values(
        MistakenMap{"from_minus_pi",
                    phase_of(16, -std::numbers::pi),
                    phase,
                    {{"origin", "-3.14159"}},
                    Severity::doubtful},
        MistakenMap{"from_0_taken_from_minus_pi",
                    phase,
                    phase_of(16, -std::numbers::pi),
                    {{"origin", "0"}}},
        MistakenMap{"a_period_high", phase_of(16, two_pi), phase, {{"origin", "6.28319"}}},
        MistakenMap{"a_period_low",
                    phase_of(16, -two_pi),
                    phase,
                    {{"origin", "-6.28319"}},
                    Severity::doubtful},
        MistakenMap{"fewer_periods", phase, phase_of(15), {{"from", "phase:16"}}},
        MistakenMap{"half_of_the_periods", phase, phase_of(8), {{"from", "phase:16"}}},
        MistakenMap{
            "more_periods", phase, phase_of(32), {{"from", "phase:16"}}, Severity::doubtful},
        MistakenMap{"pixels_as_phase", pixels, phase, {{"from", "pixels"}}},
        MistakenMap{"periods_as_phase",
                    {.unit = MapUnit::periods, .periods = 16},
                    phase,
                    {{"from", "periods:16"}}},
        MistakenMap{"coordinate_as_pixels", coordinate, pixels, {{"from", "coordinate"}}},
        MistakenMap{"pixels_as_coordinate", pixels, coordinate, {{"from", "pixels"}}},
        MistakenMap{"phase_as_pixels", phase, pixels, {{"from", "phase:16"}}},
        MistakenMap{"falling_pixels",
                    {.unit = MapUnit::pixels, .backwards = true},
                    pixels,
                    {{"backwards", "true"}}},
        MistakenMap{"falling_phase", phase_of(16, {}, true), phase, {{"backwards", "true"}}},
        MistakenMap{"phase_falling_from_0",
                    phase_of(16, 0, true),
                    phase,
                    {{"origin", "0"}, {"backwards", "true"}}},
        MistakenMap{"pixels_from_the_middle",
                    {.unit = MapUnit::pixels, .origin = -640},
                    pixels,
                    {{"origin", "-640"}}}),
    [](const auto& info) { return std::string(info.param.name); });

TEST(MapCheck, NamesAWholeMapInOnePixel) {
  const auto findings = findings_of(coordinates_of("statue", Axis::x), pixels);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_NE(findings.front().what.find("lie in one projector pixel"), std::string::npos)
      << text_of(findings.front());
}

TEST(MapCheck, EndsOfTheLightChangePlacesIfTheMapIsReversed) {
  const MapEvidence reversed =
      changed({.low = LightEnd{0.1, 0.02}, .high = LightEnd{0.7, 0.03}}, -2, 2);
  EXPECT_DOUBLE_EQ(reversed.low->coordinate, 0.6);
  EXPECT_DOUBLE_EQ(reversed.low->step, 0.06);
  EXPECT_DOUBLE_EQ(reversed.high->coordinate, 1.8);
  EXPECT_DOUBLE_EQ(reversed.high->step, 0.04);
}

TEST(MapCheck, NamesTheOtherAxis) {
  const std::vector<Finding> findings =
      findings_of(written_as(pixels, coordinates_of("statue", Axis::y), Axis::y), pixels, Axis::x);

  ASSERT_EQ(findings.size(), 1U);
  EXPECT_TRUE(blames(findings.front(), CauseKind::axis)) << text_of(findings.front());
  EXPECT_EQ(findings.front().severity, Severity::wrong);
}

TEST(MapCheck, LeavesOutValuesOfInvalidPixels) {
  const Image<double> right = written_as(pixels, coordinates_of("statue", Axis::x));

  for (const double invalid : {0.0, -1.0, 65535.0, 500.0}) {
    for (const bool whole : {false, true}) {
      Image<double> map = right;
      for (double& value : map) {
        if (whole) value = std::round(value);
        if (std::isnan(value)) value = invalid;
      }

      const std::vector<Finding> findings = findings_of(map, pixels);
      ASSERT_EQ(findings.size(), 1U) << invalid;
      EXPECT_EQ(findings.front().kind, FindingKind::shared_map_value);
      EXPECT_EQ(findings.front().severity, Severity::doubtful);
      EXPECT_EQ(findings.front().evidence.front().value, invalid);

      (void)leave_out_shared_values(map);
      EXPECT_EQ(std::ranges::count(map, invalid), 0);
    }
  }
}

// Each column has a value of its own, and four more columns share one of these.
TEST(MapCheck, LeavesOutTheLeastAndTheLargestValueSooner) {
  for (const auto& [value, found] : {std::pair(0, 1U), std::pair(50, 0U), std::pair(99, 1U)}) {
    Image<double> map({104, 10});
    for_each_pixel_in_order(
        map.size(), [&](int column, int row) { map(column, row) = column < 100 ? column : value; });
    EXPECT_EQ(leave_out_shared_values(map).size(), found) << value;
  }
}

TEST(MapCheck, LightEndsNowhereIfItGoesOnBeyond) {
  for (const int next : {60, 100}) {  // the first column that is valid again
    Image<double> map({100, 60});
    for_each_pixel_in_order(map.size(), [&](int column, int row) {
      map(column, row) = column < 50 || column >= next ? 0.01 * column : nan;
    });
    EXPECT_EQ(map_evidence(map).high.has_value(), next == 100) << next;
  }
}

TEST(MapCheck, KeepsTheOnlyValueOfAMap) {
  Image<double> map({16, 16}, 3.0);
  EXPECT_TRUE(leave_out_shared_values(map).empty());
  EXPECT_EQ(std::ranges::count(map, 3.0), 256);
}

}  // namespace slipstream::map_check_test
