// What lossy compression costs: the table of docs/reference/files.md.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <turbojpeg.h>

#include "base/statistics.h"
#include "io/plain_pictures.h"
#include "slipstream/engine.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_world.h"

namespace slipstream::mjpg_test {

Image<std::uint8_t> compressed(const Image<std::uint8_t>& picture, int quality) {
  const std::unique_ptr<void, int (*)(tjhandle)> encoder(tjInitCompress(), tjDestroy);
  unsigned char* jpeg = nullptr;
  unsigned long size = 0;
  EXPECT_EQ(tjCompress2(encoder.get(), picture.begin(), picture.width(), 0, picture.height(),
                        TJPF_GRAY, &jpeg, &size, TJSAMP_GRAY, quality, 0),
            0);
  Image<std::uint8_t> decoded(picture.size());
  EXPECT_TRUE(decode_jpeg({jpeg, size}, decoded));
  tjFree(jpeg);
  return decoded;
}

TEST(Mjpg, CostsPrecision) {
  const VirtualWorld world = virtual_world({.scene = "statue", .camera = {640, 480}});
  const Sequence sequence{.strategy = make_strategy("dual-frequency", {{"steps", 4}}),
                          .projector = world.scanner.projector.size};
  const VirtualScan scan =
      take_scan(world.scanner, world.scene, pattern_set(sequence), world.photometry);
  Engine engine(as_calibrated(world), sequence);
  const auto median_error = [&](int quality) {
    std::vector<Image<std::uint8_t>> frames;
    scan.frames.visit([&](const auto& views) {
      for (const auto& view : views) {
        Image<std::uint8_t> frame(view.size());
        for (int row = 0; row < view.height(); ++row) {
          std::copy_n(view.row(row), view.width(), frame.row(row));
        }
        frames.push_back(quality == 0 ? frame : compressed(frame, quality));
      }
    });
    Cloud cloud;
    engine.cloud(FrameSet(std::move(frames)), cloud);
    std::vector<double> errors;
    for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
      const double error = std::abs(cloud.z.begin()[i] - scan.depth.begin()[i]);
      if (std::isfinite(error)) errors.push_back(error);
    }
    const auto wrong = std::count_if(errors.begin(), errors.end(), [](double e) { return e > 5; });
    const double median = quantile(errors, 0.5);
    std::printf(
        "JPEG quality %2d (0: none): depth error median %.3f mm, 90 %% below %.3f mm; "
        "%td pixels over 5 mm\n",
        quality, median, quantile(errors, 0.9), wrong);
    return median;
  };
  const double raw = median_error(0), fine = median_error(90), coarse = median_error(50);
  for (const int quality : {95, 75, 20}) EXPECT_GT(median_error(quality), 0);
  EXPECT_LT(fine, 1.5 * raw);
  EXPECT_GT(coarse, fine);
  EXPECT_LT(coarse, 4 * raw);
}

}  // namespace slipstream::mjpg_test
