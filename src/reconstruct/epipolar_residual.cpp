#include "reconstruct/epipolar_residual.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "base/statistics.h"
#include "base/throw_if-inl.h"
#include "geometry/lens_residual.h"
#include "reconstruct/epipolar.h"

namespace slipstream {
namespace {

constexpr int block_pixels = 64;
constexpr int highest_degree = 6;

/// A pixel of the camera and its equation for the camera's residual.
struct SeenDistance {
  ResidualSample sample;
  double scale = 1;  ///< projector pixels of distance per camera pixel
  Size block;        ///< column and row
};

bool is_even(Size block) {
  return (block.width + block.height) % 2 == 0;
}

/// A sample of the pixels with a distance, evenly spread.
std::vector<SeenDistance> seen_distances(const Scanner& scanner, const Cloud& cloud,
                                         const Image<float>& distances) {
  constexpr double most = 1e5;
  const auto points = static_cast<double>(point_count(cloud));
  const int step = std::max(1, static_cast<int>(std::ceil(std::sqrt(points / most))));
  const Size projector = scanner.projector.size;

  std::vector<SeenDistance> seen;
  for (int row = 0; row < cloud.size().height; row += step) {
    for (int column = 0; column < cloud.size().width; column += step) {
      if (cloud.validity(column, row) != Validity::valid) continue;

      // The projector's pixel is known well enough from the point, which lies on the line.
      const Eigen::Vector2d lit =
          project(scanner.projector, in_projector_frame(scanner, position_at(cloud, column, row)));
      const auto distance_at = [&](double x, double y) {
        return epipolar_distance(scanner, ray_through(scanner.camera, {x, y}),
                                 lit.x() / projector.width, lit.y() / projector.height)
            .distance;
      };

      // How the distance changes with the camera's pixel.
      const Eigen::Vector2d slope(distance_at(column + 0.5, row) - distance_at(column - 0.5, row),
                                  distance_at(column, row + 0.5) - distance_at(column, row - 0.5));
      const double scale = slope.norm();
      const Eigen::Vector2d along = slope / scale;

      // The new map replaces the present one.
      const Eigen::Vector2d pixel(column, row);
      const double off =
          distances(column, row) / scale + along.dot(shift_at(scanner.camera.residual, pixel));
      if (!std::isfinite(off) || !along.allFinite()) continue;
      seen.push_back({{pixel, along, off}, scale, {column / block_pixels, row / block_pixels}});
    }
  }
  return seen;
}

/// The median remainder after a map, for each block with half as many samples as a full one; else
/// NaN.
Image<float> block_medians(const std::vector<SeenDistance>& seen, Size blocks,
                           const LensResidual& map) {
  std::vector<std::vector<float>> of_blocks(static_cast<std::size_t>(blocks.width) * blocks.height);
  const auto index = [&](int column, int row) { return row * blocks.width + column; };
  std::size_t most = 0;
  for (const auto& [sample, scale, block] : seen) {
    const double left = scale * (sample.off - sample.along.dot(shift_at(map, sample.pixel)));
    auto& of_block = of_blocks[index(block.width, block.height)];
    of_block.push_back(static_cast<float>(left));
    most = std::max(most, of_block.size());
  }

  Image<float> medians(blocks, std::numeric_limits<float>::quiet_NaN());
  for_each_pixel_in_order(blocks, [&](int column, int row) {
    std::vector<float>& of_block = of_blocks[index(column, row)];
    if (2 * of_block.size() >= most && most > 0) medians(column, row) = quantile(of_block, 0.5);
  });
  return medians;
}

LensResidual map_of(const std::vector<SeenDistance>& seen, Size picture, int degree,
                    const std::function<bool(Size)>& takes) {
  std::vector<ResidualSample> samples;
  for (const auto& [sample, scale, block] : seen) {
    if (takes(block)) samples.push_back(sample);
  }
  return fitted_residual(samples, picture, degree);
}

/// The squares about the mean.
Squares spread_of(const Image<float>& medians, const std::function<bool(Size)>& takes) {
  std::vector<double> values;
  for_each_pixel_in_order(medians.size(), [&](int column, int row) {
    const float median = medians(column, row);
    if (takes({column, row}) && std::isfinite(median)) values.push_back(median);
  });

  double sum = 0;
  for (const double value : values) sum += value;
  const double mean = sum / static_cast<double>(std::max<std::size_t>(values.size(), 1));

  Squares spread;
  for (const double value : values) spread.add((value - mean) * (value - mean));
  return spread;
}

/// Standard deviation of the held-out blocks' medians, each half held out in turn.
double held_out_deviation(const std::vector<SeenDistance>& seen, Size blocks, Size picture,
                          int degree) {
  Squares spread;
  for (const bool held_out : {false, true}) {
    const auto is_held_out = [&](Size block) { return is_even(block) == held_out; };
    const LensResidual map =
        degree == 0 ? LensResidual{} : map_of(seen, picture, degree, std::not_fn(is_held_out));
    spread.add(spread_of(block_medians(seen, blocks, map), is_held_out));
  }
  return spread.rms();
}

}  // namespace

EpipolarResidual epipolar_residual(const Scanner& scanner, const Cloud& cloud,
                                   const Image<float>& distances) {
  constexpr int fewest_blocks = 24;
  constexpr double about_as_good = 1.05, clearly_better = 0.8;

  // 1. The distances, block by block.
  const Size size = cloud.size();
  const Size blocks{(size.width + block_pixels - 1) / block_pixels,
                    (size.height + block_pixels - 1) / block_pixels};
  throw_if(blocks.width * blocks.height < fewest_blocks,
           "pictures of {} have {} blocks of {} pixels; a residual map requires {}", text_of(size),
           blocks.width * blocks.height, block_pixels, fewest_blocks);

  const std::vector<SeenDistance> seen = seen_distances(scanner, cloud, distances);

  const auto all = [](Size) { return true; };
  EpipolarResidual result{.scanner = scanner,
                          .before = block_medians(seen, blocks, scanner.camera.residual)};
  result.blocks = spread_of(result.before, all).count;
  throw_if(result.blocks < fewest_blocks,
           "only {} blocks of {} pixels have points along both axes; a residual map requires {}: "
           "scan a surface that fills the picture",
           result.blocks, block_pixels, fewest_blocks);

  // 2. The lowest degree that is about as good as the best on blocks that were held out.
  double best = std::numeric_limits<double>::infinity();
  for (int degree = 0; degree <= highest_degree; ++degree) {
    const double deviation = held_out_deviation(seen, blocks, size, degree);
    result.scores.push_back({degree, deviation});
    if (degree > 0) best = std::min(best, deviation);
  }

  const double without = result.scores.front().deviation;
  throw_if(!(best < clearly_better * without),
           "no residual map is supported: on blocks that it was not fitted to it leaves {:.4f} "
           "projector pixels, instead of {:.4f} without",
           best, without);

  const auto chosen = std::ranges::find_if(result.scores, [&](const EpipolarScore& score) {
    return score.degree > 0 && score.deviation <= about_as_good * best;
  });

  // 3. The map of all blocks.
  result.degree = chosen->degree;
  result.scanner.camera.residual = map_of(seen, size, result.degree, all);
  result.after = block_medians(seen, blocks, result.scanner.camera.residual);
  return result;
}

}  // namespace slipstream
