#include "paper/curve_fit.h"

#include <gtest/gtest.h>

#include "response/response_fit.h"

namespace slipstream::curve_fit_test {

TEST(CurveFit, FindsTheGammaThatMadeTheGreyLevels) {
  for (const double gamma : {0.8, 1.0, 2.21, 7.73}) {
    const FittedGamma truth{.gamma = gamma, .scale = 160, .offset = 9};
    std::vector<double> x, grey;
    for (int i = 0; i <= 60; ++i) {
      x.push_back(i / 60.0);
      grey.push_back(truth.at(x.back()));
    }
    const FittedGamma fit = fit_gamma(x, grey);
    EXPECT_NEAR(fit.gamma, gamma, 1e-4);
    EXPECT_NEAR(fit.scale, 160, 0.01) << gamma;
    EXPECT_NEAR(fit.offset, 9, 0.01) << gamma;
  }
}

}  // namespace slipstream::curve_fit_test
