#include "slipstream/response/named_responses.h"

#include <cmath>

#include <gtest/gtest.h>

#include "slipstream/base/error.h"

namespace slipstream::named_responses_test {

TEST(NamedResponses, SrgbIsTheStandardsCurve) {
  const Response srgb = curve_named("srgb").value();
  for (double value = 0; value <= 1; value += 0.001) {
    const double standard =
        value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
    ASSERT_NEAR(light_at(srgb, value), standard, 2e-5) << value;
  }
}

TEST(NamedResponses, ALogisticCurveHasItsSlopeAndItsCentre) {
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

TEST(NamedResponses, ANameThatIsNoCurveIsToldFromOneThatIsWrong) {
  EXPECT_FALSE(curve_named("2.2"));
  EXPECT_FALSE(curve_named("scanner.yaml"));
  for (const char* wrong : {"logistic:", "logistic:9", "logistic:9:", "logistic:9:0.4:1",
                            "logistic:0:0.5", "logistic:9:1.5", "logistic:nan:0.5"}) {
    EXPECT_THROW((void)curve_named(wrong), Error) << wrong;
  }
}

}  // namespace slipstream::named_responses_test
