#include "slipstream/response.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "response/response_fit.h"
#include "slipstream/error.h"

namespace slipstream::response_test {

std::vector<double> evenly_spaced(int count) {
  std::vector<double> values;
  for (int i = 0; i < count; ++i) values.push_back(static_cast<double>(i) / (count - 1));
  return values;
}

ResponseCurve curve_of(double gamma, int points) {
  const std::vector<double> values = evenly_spaced(points);
  std::vector<double> intensities;
  for (const double value : values) intensities.push_back(12 + 180 * std::pow(value, gamma));
  return response_curve(values, intensities);
}

TEST(Response, APowerLawIsTheValueToThePowerGamma) {
  EXPECT_DOUBLE_EQ(light_at(PowerLaw{2}, 0.5), 0.25);
  EXPECT_DOUBLE_EQ(value_for(PowerLaw{2}, 0.25), 0.5);
  EXPECT_DOUBLE_EQ(light_at(PowerLaw{2}, 1.5), 1);
  EXPECT_THROW(require_gamma(0.4, "gamma"), Error);
  EXPECT_THROW(require_gamma(NAN, "gamma"), Error);
}

TEST(Response, ACurveMeasuredAt33LevelsIsThePowerLawItWasMeasuredFrom) {
  const Response curve = curve_of(2.2, 33);
  for (double value = 0; value <= 1; value += 0.001) {
    EXPECT_NEAR(light_at(curve, value), std::pow(value, 2.2), 5e-5);
    EXPECT_NEAR(light_at(curve, value_for(curve, value)), value, 1e-12);
  }
}

TEST(Response, ACurveRisesThroughAnyPointsThatDo) {
  rc::check([](std::vector<double> steps) {
    std::vector<double> intensities{0};
    for (const double step : steps) {
      RC_PRE(std::isfinite(step));
      intensities.push_back(intensities.back() + std::fmod(std::abs(step), 100.0));
    }
    RC_PRE(intensities.size() >= 3U && intensities.back() > 1);
    const auto values = evenly_spaced(static_cast<int>(intensities.size()));
    const Response curve = response_curve(values, intensities);
    double before = light_at(curve, 0);
    RC_ASSERT(before == 0);
    for (int i = 1; i <= 300; ++i) {
      const double light = light_at(curve, i / 300.0);
      RC_ASSERT(light >= before - 1e-12);
      before = light;
    }
    RC_ASSERT(std::abs(before - 1) < 1e-12);
  });
}

TEST(Response, NoiseThatReversesNeighboursIsAveraged) {
  const ResponseCurve curve = response_curve(std::array{0.0, 0.25, 0.5, 0.75, 1.0},
                                             std::array{0.0, 22.0, 18.0, 60.0, 100.0});
  EXPECT_DOUBLE_EQ(curve.light[1], 0.2);
  EXPECT_DOUBLE_EQ(curve.light[2], 0.2);
}

TEST(Response, RefusesWhatIsNoCurve) {
  EXPECT_THROW((void)response_curve(std::array{0.0, 1.0}, std::array{0.0, 1.0}), Error);
  EXPECT_THROW((void)response_curve(std::array{0.0, 0.5, 0.9}, std::array{0.0, 1.0, 2.0}), Error);
  EXPECT_THROW((void)response_curve(std::array{0.0, 0.0, 1.0}, std::array{0.0, 1.0, 2.0}), Error);
  EXPECT_THROW((void)response_curve(std::array{0.0, 0.5, 1.0}, std::array{3.0, 2.0, 1.0}), Error);
  EXPECT_THROW((void)response_curve(std::array{0.0, 0.5, 1.0}, std::array{0.0, std::nan(""), 1.0}),
               Error);
  EXPECT_THROW((void)response_curve(std::array{0.0, 0.5, 1.0}, std::array{0.0, 1.0}), Error);
}

TEST(Response, NamedResponsesSrgbIsTheStandardsCurve) {
  const Response srgb = curve_named("srgb").value();
  for (double value = 0; value <= 1; value += 0.001) {
    const double standard =
        value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
    ASSERT_NEAR(light_at(srgb, value), standard, 2e-5) << value;
  }
}

TEST(Response, NamedResponsesALogisticCurveHasItsSlopeAndItsCentre) {
  for (const double slope : {0.1, 3.0, 12.0, 50.0}) {
    const Response symmetric = logistic_curve(slope, 0.5);
    EXPECT_NEAR(light_at(symmetric, 0.5), 0.5, 1e-12);
    EXPECT_NEAR(light_at(symmetric, 0.3) + light_at(symmetric, 0.7), 1, 1e-12);
  }
  const Response curve = curve_named("logistic:9:0.45").value();
  const auto logistic = [](double value) { return 1 / (1 + std::exp(-9 * (value - 0.45))); };
  for (double value = 0; value <= 1; value += 0.001) {
    const double light = (logistic(value) - logistic(0)) / (logistic(1) - logistic(0));
    ASSERT_NEAR(light_at(curve, value), light, 2e-5) << value;
  }
}

TEST(Response, NamedResponsesTheNameOfACurveThatServesGivesThatCurve) {
  // An exponential is best served by a centre beyond the last value.
  const auto distance = [](const Response& response) {
    double sum = 0;
    for (const double value : evenly_spaced(21)) {
      const double light = (std::exp(6 * value) - 1) / (std::exp(6) - 1);
      sum += std::pow(light_at(response, value) - light, 2);
    }
    return sum;
  };
  const double of_srgb = distance(srgb_curve());
  const auto found = curve_that_serves(
      distance, [&](const Response& response) { return distance(response) < of_srgb; });

  ASSERT_TRUE(found);
  const Response named = curve_named(found->name).value();
  for (const double value : evenly_spaced(21)) {
    EXPECT_NEAR(light_at(named, value), light_at(found->response, value), 1e-3) << found->name;
  }
}

TEST(Response, NamedResponsesANameThatIsNoCurveIsToldFromOneThatIsWrong) {
  EXPECT_FALSE(curve_named("2.2"));
  EXPECT_FALSE(curve_named("scanner.yaml"));
  for (const char* wrong : {"logistic:", "logistic:9", "logistic:9:", "logistic:9:0.4:1",
                            "logistic:0:0.5", "logistic:9:1.5", "logistic:nan:0.5"}) {
    EXPECT_THROW((void)curve_named(wrong), Error) << wrong;
  }
}

}  // namespace slipstream::response_test
