// A cleaning step defined outside the library: its setting is read from the command line, checked
// against its range and applied.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <gtest/gtest.h>

#include "app/commands.h"
#include "slipstream/error.h"
#include "slipstream/setting.h"
#include "tests/extensions/seen.h"

namespace slipstream::own_cleaning_test {

/// Rejects points darker than a limit.
struct TooDark {
  double least_intensity = 0;

  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    visit(
        {"least_intensity", "least-intensity", "darker points are left out", "grey levels", 0, 255},
        self.least_intensity);
  }
  void operator()(Cloud& cloud) const {
    for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
      if (!(cloud.intensity.begin()[i] < least_intensity)) continue;
      cloud.validity.begin()[i] = Validity::too_dark;
      for (Image<float>* image : {&cloud.x, &cloud.y, &cloud.z}) image->begin()[i] = NAN;
    }
  }
};

TooDark told(const std::string& arguments) {
  TooDark clean;
  CLI::App command;
  app::FlagGroup{command}.add_settings(clean, [](const Setting&, auto&) {});
  command.parse(arguments);
  return clean;
}

TEST(CleaningSetting, OwnCleaningSettingIsToldOnTheCommandLine) {
  EXPECT_EQ(told("--least-intensity 150").least_intensity, 150);
  EXPECT_THROW(told("--least-intensity 256"), Error);
  EXPECT_THROW(require_in_range(TooDark{.least_intensity = -1}), Error);
}

TEST(CleaningSetting, OwnCleaningSettingIsObeyed) {
  const Seen seen = seen_under(DualFrequency{});
  Cloud cloud;
  Engine(seen.setup).cloud(seen.scan.frames, cloud);
  const std::size_t before = point_count(cloud);
  std::vector<float> seen_levels;
  for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
    if (cloud.validity.begin()[i] == Validity::valid)
      seen_levels.push_back(cloud.intensity.begin()[i]);
  }
  const auto [least, most] = std::minmax_element(seen_levels.begin(), seen_levels.end());
  told("--least-intensity " + std::to_string((*least + *most) / 2))(cloud);
  EXPECT_LT(point_count(cloud), before);
  EXPECT_GT(point_count(cloud), 0U);
}

}  // namespace slipstream::own_cleaning_test
