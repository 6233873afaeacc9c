#include <limits>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "io/plot.h"
#include "slipstream/error.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::plot_file_test {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Number of pixels that are not grey.
int coloured_pixels(const std::filesystem::path& path) {
  const cv::Mat picture = cv::imread(path.string());
  int count = 0;
  for (int row = 0; row < picture.rows; ++row) {
    for (int column = 0; column < picture.cols; ++column) {
      const auto pixel = picture.at<cv::Vec3b>(row, column);
      if (pixel[0] != pixel[1] || pixel[1] != pixel[2]) ++count;
    }
  }
  return count;
}

TEST(PlotFile, ShowsLinesBarsAndMaps) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "plot.png";
  const auto drawn = [&](const auto& plot) {
    write_plot(path, plot);
    return coloured_pixels(path);
  };
  EXPECT_GT(drawn(LinePlot{"a", "x", "y", PlotScale::linear, {{"line", {0, 1, 2}, {1, 5, 2}}}}),
            300);
  EXPECT_GT(drawn(LinePlot{
                "a", "x", "y", PlotScale::logarithmic, {{"", {0, 1, 2, 3}, {1e-9, 0, nan, 2}}}}),
            10);
  EXPECT_GT(drawn(LinePlot{"flat", "x", "y", PlotScale::linear, {{"", {0, 1}, {0, 0}}}}), 300);
  EXPECT_GT(drawn(BarPlot{"a", "x", "y", 0, 1, {1, 4, nan, 2}}), 1000);
  write_map_preview(folder.path() / "map.png", Image<double>({30, 20}, 4), "mm");
  EXPECT_GT(coloured_pixels(folder.path() / "map.png"), 100);
  Cloud ramp({30, 20});
  for (int i = 0; i < 600; ++i) {
    ramp.x.begin()[i] = i % 30;
    ramp.y.begin()[i] = i / 30;
    ramp.z.begin()[i] = 500 + i % 30;
    ramp.validity.begin()[i] = Validity::valid;
  }
  write_depth_preview(path, ramp);
  EXPECT_GT(coloured_pixels(path), 100);
}

TEST(PlotFile, CropsADepthPreviewToItsPoints) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "preview.png";
  const auto width_of = [&](int from, int to) {
    Cloud cloud({400, 300});
    for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
      if (column < from || column >= to) return;
      cloud.x(column, row) = cloud.y(column, row) = 0;
      cloud.z(column, row) = 500 + static_cast<float>(row);
      cloud.validity(column, row) = Validity::valid;
    });
    write_depth_preview(path, cloud);
    return cv::imread(path.string()).cols;
  };
  EXPECT_EQ(width_of(0, 400) - width_of(150, 200), 350);
  EXPECT_EQ(width_of(0, 0), width_of(0, 400)) << "without points, the whole picture";
}

TEST(PlotFile, NoLegendHidesACurve) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "plot.png";
  const auto drawn = [&](const char* first, const char* second) {
    write_plot(path, LinePlot{"a",
                              "x",
                              "y",
                              PlotScale::linear,
                              {{first, {0, 1, 2}, {1, 5, 5}}, {second, {0, 1, 2}, {1, 1, 4.9}}}});
    return cv::imread(path.string());
  };
  const cv::Mat bare = drawn("", ""), told = drawn("one", "another");
  ASSERT_GT(told.rows, bare.rows);
  const int axes = bare.rows - 20;  // a legend would start 20 pixels above the bottom
  EXPECT_EQ(cv::norm(told.rowRange(0, axes), bare.rowRange(0, axes), cv::NORM_INF), 0);
}

TEST(PlotFile, ReducesLargeMapsToMeans) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "map.png";
  Image<double> map({2500, 50});
  for_each_pixel_in_order(map.size(), [&](int column, int row) {
    map(column, row) = (column + row) % 2 == 0 ? 1 : 3;  // whose mean is the same everywhere
  });
  write_map_preview(path, map, "mm, \u00b5m, \xff");
  const cv::Mat picture = cv::imread(path.string());
  ASSERT_GT(picture.cols, 1000);
  const cv::Mat shown = picture(cv::Rect(0, 0, 1000, 20));
  cv::Mat mean, deviation;
  cv::meanStdDev(shown, mean, deviation);
  EXPECT_LT(cv::norm(deviation, cv::NORM_INF), 20);  // checks alone would deviate by 60 and more
}

TEST(PlotFile, RefusesWhatCannotBeShown) {
  const TemporaryFolder folder;
  const LinePlot empty{"none", "x", "y", PlotScale::linear, {{"", {1}, {nan}}}};
  const LinePlot dark{"none", "x", "y", PlotScale::logarithmic, {{"", {1}, {-1}}}};
  EXPECT_THROW(write_plot(folder.path() / "plot.png", empty), Error);
  EXPECT_THROW(write_plot(folder.path() / "plot.png", dark), Error);
  EXPECT_THROW(write_plot(folder.path() / "plot.png", BarPlot{}), Error);
  EXPECT_THROW(write_plot(folder.path() / "plot.jpg", empty), Error);
  EXPECT_EQ(entries_in(folder.path()), 0);
}

}  // namespace slipstream::plot_file_test
