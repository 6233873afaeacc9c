#include "simulate/accuracy.h"

#include <cmath>
#include <fstream>
#include <iterator>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "simulate/rehearsal.h"
#include "slipstream/error.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/virtual_world.h"
#include "tests/io/expect_error.h"
#include "tests/io/temporary_folder.h"
#include "tests/simulate/cast_cloud.h"

namespace slipstream::accuracy_test {

using Eigen::Vector3d;

const Artefacts bar{.diameters = {40, 40},
                    .distance = 120,
                    .spheres = {"bar"},
                    .planes = {},
                    .repeated = {},
                    .diagonal = 400};

Scene bar_scene() {
  return {sphere_at({-60, 0, 600}, 20), sphere_at({60, 0, 600}, 20)};
}

Body plane_at(double depth) {
  return {.shape = Board{220, 160}, .pose = Eigen::Isometry3d(Eigen::Translation3d(0, 0, depth))};
}

Estimate estimate(const Accuracy& accuracy, std::string_view key) {
  for (const AccuracyFigure& figure : accuracy_figures(accuracy)) {
    if (figure.key == key) return figure.measured;
  }
  return {std::nan(""), std::nan("")};
}

double figure(const Accuracy& accuracy, std::string_view key) {
  return estimate(accuracy, key).value;
}

TEST(Accuracy, OfExactPointsIsExact) {
  const Accuracy found =
      measure_accuracy(bar, [](const std::string&) { return cast_cloud(bar_scene()); });
  EXPECT_NEAR(figure(found, "probing_size"), 0, 1e-4);
  EXPECT_NEAR(figure(found, "probing_form"), 0, 2e-4);  // of points in float
  EXPECT_NEAR(figure(found, "sphere_spacing"), 0, 1e-4);
  EXPECT_NEAR(figure(found, "dimension"), 0, 1e-4);
  EXPECT_TRUE(std::isnan(figure(found, "flatness")));
}

TEST(Accuracy, ShowsWhatACertifiedValueIsOff) {
  Artefacts off = bar;
  off.diameters = {39.9, 40};
  off.distance = 120.25;
  const Accuracy found =
      measure_accuracy(off, [](const std::string&) { return cast_cloud(bar_scene()); });
  EXPECT_NEAR(figure(found, "probing_size"), 0.1, 1e-4);
  EXPECT_NEAR(figure(found, "sphere_spacing"), -0.25, 1e-4);
  EXPECT_NEAR(figure(found, "dimension"), -0.25, 1e-4);
}

TEST(Accuracy, GivesEachOfTwoSpheresItsOwnDiameter) {
  Artefacts unequal = bar;
  unequal.diameters = {40, 30};
  const Scene scene{sphere_at({-60, 0, 600}, 15), sphere_at({60, 0, 600}, 20)};
  for (const bool swapped : {false, true}) {
    if (swapped) std::swap(unequal.diameters[0], unequal.diameters[1]);
    const Accuracy found =
        measure_accuracy(unequal, [&](const std::string&) { return cast_cloud(scene); });
    EXPECT_NEAR(figure(found, "probing_size"), 0, 1e-4);
  }
}

TEST(Accuracy, LeavesOutThreeInAThousandAndNoMore) {
  // Points 0.5 mm off, one in 500, are left out; one in 100 are form.
  for (const auto& [every, form] : {std::pair{500, 0.0}, std::pair{100, 0.5}}) {
    int lit = 0;
    const Cloud cloud = cast_cloud({plane_at(600)}, {320, 240},
                                   [&, n = every](int, int) { return ++lit % n == 0 ? 0.5 : 0.0; });
    const Artefacts plane{.planes = {"plane"}};
    const Accuracy found = measure_accuracy(plane, [&](const std::string&) { return cloud; });
    EXPECT_NEAR(figure(found, "flatness"), form, 0.02) << every;
    EXPECT_NEAR(figure(found, "flatness_95"), 0, 3e-3);
  }
}

TEST(Accuracy, OfAPlaneLeavesOutWhatElseLiesInIt) {
  // A table whose surface crosses the plane, apart from it in the picture, and a wall far behind.
  Body table{.shape = Board{200, 60}};
  table.pose = Eigen::Translation3d(0, 110, 600) * Eigen::AngleAxisd(1, Vector3d::UnitX());
  Body wall{.shape = Board{300, 300}};
  wall.pose.translation() = Vector3d(700, 0, 2000);
  const Scene scene{plane_at(600), table, wall};
  const Artefacts plane{.planes = {"plane"}};
  const Accuracy found =
      measure_accuracy(plane, [&](const std::string&) { return cast_cloud(scene); });
  EXPECT_NEAR(figure(found, "flatness"), 0, 2e-4);
}

TEST(Accuracy, OfNoiseIsThatOfItsDistribution) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 0.05);
  const Cloud cloud =
      cast_cloud({plane_at(600)}, {320, 240}, [&](int, int) { return noise(random); });
  const Artefacts plane{.planes = {"plane"}};
  const Accuracy found = measure_accuracy(plane, [&](const std::string&) { return cloud; });
  EXPECT_NEAR(figure(found, "flatness"), 2 * 2.968 * 0.05, 0.01);
  EXPECT_NEAR(figure(found, "flatness_95"), 2 * 1.960 * 0.05, 0.005);
  EXPECT_NEAR(figure(found, "planarity"), 0.05 / 16, 0.001);
  EXPECT_NEAR(found.shapes.front().rms, 0.05, 0.002);
}

TEST(Accuracy, BendingIsWhatNoiseDoesNotExplain) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 0.05);
  const Cloud cloud = cast_cloud({plane_at(600)}, {320, 240}, [&](int column, int) {
    return noise(random) +
           0.1 * std::sqrt(2) * std::cos((column - 158) * 2 * std::numbers::pi / 142);
  });
  const Artefacts plane{.planes = {"plane"}};
  const Accuracy found = measure_accuracy(plane, [&](const std::string&) { return cloud; });
  EXPECT_NEAR(figure(found, "planarity"), 0.1, 0.01);
}

TEST(Accuracy, PrecisionIsTheSpreadOfEachPixel) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 0.03);
  const Artefacts still{.repeated = std::vector<std::string>(20, "still")};
  const Accuracy found = measure_accuracy(still, [&](const std::string&) {
    return cast_cloud({plane_at(600)}, {160, 120}, [&](int, int) { return noise(random); });
  });
  EXPECT_NEAR(figure(found, "precision"), 0.03, 0.001);
  EXPECT_EQ(found.repeated->scans, 20);
  expect_error(
      [&] {
        (void)measure_accuracy(still, [](const std::string&) {
          return cast_cloud({plane_at(600)}, {160, 120});
        });
      },
      {"copies"});
}

TEST(Accuracy, RefusesAScanWithoutTheArtefactByName) {
  const auto plane = [](const std::string&) { return cast_cloud({plane_at(600)}); };
  const auto empty = [](const std::string&) { return Cloud({320, 240}); };
  expect_error([&] { (void)measure_accuracy(bar, plane); }, {"bar: ", "40 mm"});
  expect_error([&] { (void)measure_accuracy(bar, empty); }, {"bar: ", "40 mm"});
  expect_error([&] { (void)measure_accuracy({.planes = {"p"}}, empty); }, {"p: ", "too few"});
}

/// Of a scanner that is calibrated with a baseline too long by a factor.
Rehearsal small_rehearsal(const Photometry& photometry, double factor = 1) {
  const VirtualWorld world{.scanner = example_scanner({320, 240}), .photometry = photometry};
  const Sequence sequence{.strategy = DualFrequency{.steps = 4, .high = 16, .low = 1},
                          .projector = world.scanner.projector.size};
  Scanner calibrated = as_calibrated(world);
  calibrated.translation *= factor;
  return rehearsal(world, sequence, calibrated);
}

TEST(Accuracy, RehearsalInAnIdealWorldMeasuresNoErrorButThatOfItsPixels) {
  Rehearsal test = small_rehearsal({.bits = std::nullopt});
  EXPECT_EQ(test.artefacts.spheres.size(), 7U);
  EXPECT_EQ(test.artefacts.planes.size(), 6U);
  test.artefacts.repeated.clear();
  const Accuracy found = measure_accuracy(test.artefacts, test.cloud_of);
  EXPECT_NEAR(figure(found, "probing_size"), 0, 0.002);
  EXPECT_NEAR(figure(found, "probing_form"), 0, 0.004);
  EXPECT_NEAR(figure(found, "sphere_spacing"), 0, 0.002);
  EXPECT_NEAR(figure(found, "flatness"), 0, 0.004);
}

TEST(Accuracy, RehearsalMeasuresWhatACalibrationIsOff) {
  Rehearsal test = small_rehearsal({.bits = std::nullopt}, 1.002);
  test.artefacts.planes.clear();
  test.artefacts.repeated.clear();
  const Accuracy found = measure_accuracy(test.artefacts, test.cloud_of);
  EXPECT_NEAR(figure(found, "dimension") / *test.artefacts.distance, 0.002, 1e-5);
}

TEST(Accuracy, StatesHowFarNoiseMovesAFigure) {
  // Twelve bars with noise of 0.05 mm: the figures scatter by their uncertainties, within a third.
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 0.05);
  const std::vector<std::string> keys{"probing_form", "probing_form_95", "sphere_spacing"};
  std::vector<double> sums(keys.size()), squares(keys.size()), stated(keys.size());
  constexpr int runs = 12;

  for (int run = 0; run < runs; ++run) {
    const Accuracy found = measure_accuracy(bar, [&](const std::string&) {
      return cast_cloud(bar_scene(), {320, 240}, [&](int, int) { return noise(random); });
    });
    for (std::size_t k = 0; k < keys.size(); ++k) {
      const Estimate of_key = estimate(found, keys[k]);
      sums[k] += of_key.value;
      squares[k] += of_key.value * of_key.value;
      stated[k] += of_key.uncertainty / runs;
    }
  }

  for (std::size_t k = 0; k < keys.size(); ++k) {
    const double mean = sums[k] / runs;
    const double scatter = std::sqrt((squares[k] / runs - mean * mean) * runs / (runs - 1));
    EXPECT_GT(scatter / stated[k], 0.4) << keys[k];
    EXPECT_LT(scatter / stated[k], 1.8) << keys[k];
  }
}

TEST(Accuracy, CountsTheUncertaintyOfCertifiedLengths) {
  Artefacts uncertain = bar;
  uncertain.diameter_uncertainty = 0.02;
  uncertain.distance_uncertainty = 0.04;
  const Accuracy found =
      measure_accuracy(uncertain, [](const std::string&) { return cast_cloud(bar_scene()); });
  EXPECT_NEAR(estimate(found, "probing_size").uncertainty, 0.01, 1e-4);
  EXPECT_NEAR(estimate(found, "sphere_spacing").uncertainty, 0.02, 1e-4);
}

Accuracy with_errors(double size, double bending) {
  return {
      .shapes = {{.rms = 0.1, .size = Estimate{size}}, {.rms = 0.1, .bending = Estimate{bending}}},
      .repeated = std::nullopt};
}

TEST(Accuracy, IsJudgedBySystematicErrorsBesideRandomOnes) {
  const auto grade = [](double size, double bending) {
    return std::string(verdict_of(with_errors(size, bending), {}, false).grade);
  };
  EXPECT_EQ(grade(0.05, 0.05), "good");
  EXPECT_EQ(grade(-0.2, 0.05), "usable");
  EXPECT_EQ(grade(0.05, 0.09), "usable");  // random: sqrt(0.1^2 - 0.09^2) = 0.044
  EXPECT_EQ(grade(0.5, 0), "bad");
  EXPECT_EQ(verdict_of({}, {}, false).grade, std::string("good"));
}

TEST(Accuracy, WithTheExactScannerDoesNotBlameItsCalibration) {
  const std::string words = verdict_of(with_errors(0.5, 0), {}, true).words;
  EXPECT_NE(words.find("the scanner is exact"), std::string::npos) << words;
  EXPECT_EQ(words.find("calibrat"), std::string::npos) << words;
}

TEST(Accuracy, PassesIfEachFigureIsWithinItsLimit) {
  const Accuracy accuracy = with_errors(-0.3, 0);
  std::vector<AccuracyFigure> figures = accuracy_figures(accuracy);
  set_limits(figures, {{"probing_size", 0.31}});
  EXPECT_EQ(verdict_of(accuracy, figures, false).words, "Passed: the figure is within its limit.");

  set_limits(figures, {{"probing_size", 0.29}});
  const Verdict failed = verdict_of(accuracy, figures, false);
  EXPECT_EQ(failed.grade, std::string("bad"));
  EXPECT_EQ(failed.words, "Failed: probing error of size is -0.3000 mm, its limit 0.29 mm.");
  expect_error([&] { set_limits(figures, {{"precision", 1}}); }, {"precision", "no scan"});
}

}  // namespace slipstream::accuracy_test
