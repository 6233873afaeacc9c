#include "calibrate/board_view.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <vector>

#include "base/linear_algebra.h"
#include "base/numbers.h"
#include "base/statistics.h"
#include "calibrate/opencv.h"
#include "calibrate/projector_corners.h"
#include "decode/equations.h"
#include "decode/phase_decoder.h"
#include "slipstream/unwrapping.h"

namespace slipstream {
namespace {

/// Interpolated grey level; nullopt outside the picture.
std::optional<double> grey_at(const Image<float>& picture, const Eigen::Vector2d& at) {
  const int left = static_cast<int>(std::floor(at.x())), top = static_cast<int>(std::floor(at.y()));
  if (left < 0 || top < 0 || left + 1 >= picture.width() || top + 1 >= picture.height()) {
    return std::nullopt;
  }

  const double x = at.x() - left, y = at.y() - top;
  return std::lerp(std::lerp(picture(left, top), picture(left + 1, top), x),
                   std::lerp(picture(left, top + 1), picture(left + 1, top + 1), x), y);
}

/// Standard deviation, pixels, of the Gaussian edge between two places, from its height and
/// steepest slope; nullopt without a clear edge.
std::optional<double> softness(const Image<float>& picture, const Eigen::Vector2d& from,
                               const Eigen::Vector2d& to) {
  constexpr double step = 0.25;       // pixels
  constexpr int across = 4;           // steps for the slope: one pixel
  constexpr double least_height = 8;  // grey levels

  // Samples along the line.
  const double length = (to - from).norm();
  std::vector<double> profile;
  const int steps = static_cast<int>(length / step);
  for (int i = 0; i <= steps; ++i) {
    const auto grey = grey_at(picture, from + (to - from) * (i * step / length));
    if (!grey) return std::nullopt;
    profile.push_back(*grey);
  }

  double steepest = 0;
  for (std::size_t i = across; i < profile.size(); ++i) {
    steepest = std::max(steepest, std::abs(profile[i] - profile[i - across]) / (across * step));
  }

  // A Gaussian edge has the slope height / (sigma sqrt(2 pi)) in its middle.
  const auto [low, high] = std::ranges::minmax_element(profile);
  if (profile.size() <= across || *high - *low < least_height) return std::nullopt;
  return (*high - *low) / (steepest * std::sqrt(two_pi));
}

using Complex = std::complex<double>;

/// Pixels of a board and their intensities, grey levels of 8 bits: a row for each pixel, a column
/// for each frame.
struct Samples {
  double saturated = 0;     ///< share of the board's pixels; those are excluded
  Eigen::MatrixX2d pixels;  ///< from the board's centre, in units of its larger half side
  Eigen::MatrixXd light;
};

constexpr int wanted_samples = 3000;  // enough to detect a ripple of 0.01 rad
constexpr Eigen::Index fewest_samples = 200;

/// Pixels evenly spread around each corner, up to half way to the next.
std::vector<std::pair<int, int>> pixels_about(const PixelPlaces& corners, Size size) {
  // Each corner gets an equal share of the samples, in a square grid.
  const int side = static_cast<int>(
      std::ceil(std::sqrt(wanted_samples / std::max(1.0, static_cast<double>(corners.size())))));

  std::vector<std::pair<int, int>> pixels;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const double reach = distance_to_next(corners, i);
    for (int k = 0; k < side * side; ++k) {
      const int across = k % side, down = k / side;
      const Eigen::Vector2d offset((across + 0.5) / side - 0.5, (down + 0.5) / side - 0.5);
      const Eigen::Vector2d at = corners[i] + reach * offset;

      const int column = static_cast<int>(std::lround(at.x()));
      const int row = static_cast<int>(std::lround(at.y()));
      if (column < 0 || row < 0 || column >= size.width || row >= size.height) continue;
      pixels.emplace_back(column, row);
    }
  }

  // Neighbouring grids may share pixels.
  std::ranges::sort(pixels);
  pixels.erase(std::unique(pixels.begin(), pixels.end()), pixels.end());
  return pixels;
}

Eigen::MatrixXd light_at(const FrameViews& frames, const std::vector<std::pair<int, int>>& pixels) {
  Eigen::MatrixXd light(pixels.size(), frames.count());

  const double grey_level = frames.full_scale() / 255;
  frames.visit([&](const auto& images) {
    for (Eigen::Index i = 0; i < light.rows(); ++i) {
      const auto& [column, row] = pixels[i];
      for (Eigen::Index n = 0; n < light.cols(); ++n) {
        light(i, n) = static_cast<double>(images[n](column, row)) / grey_level;
      }
    }
  });

  return light;
}

/// The bright, unsaturated pixels, away from dark parts of the print that would blur into them.
Samples samples_of(const Scan& scan, const PixelPlaces& corners, double minimum_modulation) {
  constexpr double bright_share = 0.6, bright_quantile = 0.8;
  const auto pixels = pixels_about(corners, scan.frames.size());
  const Eigen::MatrixXd light = light_at(scan.frames, pixels);
  const Eigen::VectorXd range = light.rowwise().maxCoeff() - light.rowwise().minCoeff();
  if (range.size() == 0) return {};

  const FrameViews frames = scan.frames;
  const double full_scale = 255 * frames.saturation() / frames.full_scale();
  const double saturated = (light.rowwise().maxCoeff().array() >= full_scale).cast<double>().mean();

  // White paper shows the largest range: bright means over 60 % of the 80th percentile.
  std::vector<double> ranges(range.begin(), range.end());
  const double least =
      std::max(bright_share * quantile(ranges, bright_quantile), 2 * minimum_modulation);

  std::vector<Eigen::Index> bright;
  for (Eigen::Index i = 0; i < light.rows(); ++i) {
    if (range[i] >= least && light.row(i).maxCoeff() < full_scale) bright.push_back(i);
  }
  if (std::ssize(bright) < fewest_samples) return {saturated, {}, {}};

  Samples samples{saturated, Eigen::MatrixX2d(bright.size(), 2),
                  light(bright, Eigen::seqN(0, light.cols()))};

  for (std::size_t i = 0; i < bright.size(); ++i) {
    const auto& [column, row] = pixels[bright[i]];
    samples.pixels.row(i) << column, row;
  }

  // Coordinates from -1 to 1, so that the cubic terms have similar sizes.
  samples.pixels.rowwise() -= samples.pixels.colwise().mean().eval();
  samples.pixels /= samples.pixels.cwiseAbs().maxCoeff();
  return samples;
}

/// C + i S for each sample.
Eigen::VectorXcd phasors(const Samples& samples, const Band& band) {
  const auto count = samples.light.cols();
  return samples.light *
         (Eigen::Map<const Eigen::VectorXd>(band.cosine.data(), count) +
          Complex(0, 1) * Eigen::Map<const Eigen::VectorXd>(band.sine.data(), count));
}

/// Phase of each sample, [0, 2 pi), corrected as in decoding.
Eigen::VectorXd phases(const Samples& samples, const Band& band,
                       const PhaseCorrections& corrections) {
  const auto run = step_run(band);
  const auto found = run ? corrections.find(run->steps) : corrections.end();
  return phasors(samples, band).unaryExpr([&](const Complex& phasor) {
    const double phase = wrapped_angle(phasor.imag(), phasor.real());
    return found == corrections.end() ? phase : corrected_phase(found->second, phase);
  });
}

/// Smooth model of the coordinate on a flat board seen through a lens: y = (cubic in u, v) /
/// (1 + g u + h v), solved as y = cubic - y (g u + h v) with the previous y on the right.
Eigen::VectorXd smooth_course(const Eigen::MatrixX2d& pixels, const Eigen::VectorXd& y,
                              const Eigen::VectorXd& weights) {
  // Ten terms of the cubic in u and v, two of the denominator.
  Eigen::MatrixXd terms(pixels.rows(), 12);
  int term = 0;
  for (int power = 0; power <= 3; ++power) {
    for (int of_v = 0; of_v <= power; ++of_v) {
      terms.col(term++) = pixels.col(0).array().pow(power - of_v) * pixels.col(1).array().pow(of_v);
    }
  }

  terms.col(10) = -y.cwiseProduct(pixels.col(0));
  terms.col(11) = -y.cwiseProduct(pixels.col(1));

  const Eigen::VectorXd solution =
      least_squares(weights.asDiagonal() * terms, weights.cwiseProduct(y)).X;
  return (terms.leftCols(10) * solution.head(10)).array() /
         (1 + pixels.col(0).array() * solution[10] + pixels.col(1).array() * solution[11]);
}

/// Error of the measured phase relative to the smooth model, rad, within half a turn. `turns`: the
/// unwrapped phase in turns; wrong whole turns do not count.
Eigen::VectorXd phase_errors(const Samples& samples, Eigen::VectorXd turns) {
  constexpr int rounds = 6;
  Eigen::VectorXd errors = Eigen::VectorXd::Zero(turns.size());
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(turns.size());

  for (int round = 0; round < rounds; ++round) {
    const Eigen::VectorXd course = smooth_course(samples.pixels, turns, weights);
    errors = turns - course;

    const double size = median_of(errors, [](double error) { return std::abs(error); });
    const double deviation = std::max(deviation_from_median(size), 1e-6);

    // Outliers lose their weight, and errors of whole turns are removed.
    for (Eigen::Index i = 0; i < errors.size(); ++i) {
      weights[i] = std::sqrt(tukey_weight(errors[i] / deviation));
      const double whole = std::round(errors[i]);
      turns[i] -= whole;
      errors[i] -= whole;
    }
  }

  return two_pi * errors;
}

/// Phase of each sample in turns, unwrapped from sample to nearest sample. Does not use the coarser
/// bands, which a ripple spoils most.
Eigen::VectorXd unwrapped_turns(const Samples& samples, const Eigen::VectorXd& phase) {
  const Eigen::Index count = phase.size();
  Eigen::VectorXd turns = phase / two_pi;

  // Prim's algorithm: next comes the sample nearest to an unwrapped one.
  Eigen::VectorXd distance =
      Eigen::VectorXd::Constant(count, std::numeric_limits<double>::infinity());
  std::vector<Eigen::Index> from(count, 0);
  std::vector<bool> done(count, false);

  for (Eigen::Index at = 0, left = count; left > 0; --left) {
    done[at] = true;
    distance[at] = std::numeric_limits<double>::infinity();

    for (Eigen::Index i = 0; i < count; ++i) {
      if (done[i]) continue;
      const double away = (samples.pixels.row(i) - samples.pixels.row(at)).squaredNorm();
      if (away >= distance[i]) continue;
      distance[i] = away;
      from[i] = at;
    }

    distance.minCoeff(&at);
    const double before = turns[from[at]];
    if (left > 1) turns[at] += std::round(before - turns[at]);
  }

  return turns;
}

void measure_ripple(FringeSigns& signs, const Samples& samples, const Eigen::VectorXd& phase) {
  const Eigen::VectorXd errors = phase_errors(samples, unwrapped_turns(samples, phase));

  // The component of the errors that repeats N times in each fringe.
  Complex sum = 0;
  for (Eigen::Index i = 0; i < errors.size(); ++i) {
    sum += errors[i] * std::polar(1.0, -signs.steps * phase[i]);
  }

  const auto count = static_cast<double>(errors.size());
  signs.ripple = 2 * std::abs(sum) / count;
  signs.ripple_deviation = std::sqrt(2 * errors.squaredNorm()) / count;
}

double modulation(const Samples& samples, const Band& band) {
  const Eigen::VectorXd sizes = phasors(samples, band).cwiseAbs();
  return median({sizes.begin(), sizes.end()}) / band.share;
}

}  // namespace

bool is_soft(const EdgeSoftness& edges) {
  return edges.pixels > soft_pixels && edges.spacings > soft_spacings;
}

EdgeSoftness edge_softness(const Image<float>& picture, const CalibrationBoard& board,
                           const std::vector<int>& places, const PixelPlaces& corners) {
  std::map<int, Eigen::Vector2d> seen;
  for (std::size_t i = 0; i < places.size(); ++i) seen.emplace(places[i], corners[i]);

  std::vector<double> widths, spacings;
  for (const auto& [place, corner] : seen) {
    const auto right = seen.find(place + 1), below = seen.find(place + board.columns);
    if (place % board.columns + 1 == board.columns) continue;
    if (right == seen.end() || below == seen.end()) continue;

    const Eigen::Vector2d along = right->second - corner, down = below->second - corner;
    std::optional<double> width;

    if (has_circles(board)) {
      // From the centre of a circle to the paper beside it.
      const bool symmetric = board.kind == BoardKind::symmetric_circles;
      width = softness(picture, corner, corner + (symmetric ? 0.5 : 0.4) * along);
      spacings.push_back(symmetric ? along.norm() : along.norm() / 2);
    } else {
      const Eigen::Vector2d edge = corner + along / 2;
      width = softness(picture, edge - 0.35 * down, edge + 0.35 * down);
      spacings.push_back(down.norm());
    }

    if (width) widths.push_back(*width);
  }

  if (widths.empty()) return {};
  const double width = median(std::move(widths));
  return {width, width / median(std::move(spacings))};
}

FringeSigns fringe_signs(const Scan& scan, const PixelPlaces& corners, double minimum_modulation,
                         const PhaseCorrections& corrections) {
  const Layout& layout = scan.sequence.strategy.layout();
  const Samples samples = samples_of(scan, corners, minimum_modulation);
  FringeSigns signs{.saturated = samples.saturated};
  if (samples.light.rows() == 0) return signs;

  // Blur lowers the modulation of the fine fringes more than the coarse ones'.
  if (order_source(layout) == OrderSource::bands && layout.bands.size() > 1) {
    const std::vector<std::size_t> bands = coarse_to_fine(layout);
    signs.contrast = modulation(samples, layout.bands[bands.back()]) /
                     modulation(samples, layout.bands[bands.front()]);
  }

  const Band& measuring = measuring_band(layout);
  signs.period = length_along(scan.sequence.axis, scan.sequence.projector) / measuring.periods;

  const auto run = step_run(measuring);
  if (!run || measuring.carrier > 0) return signs;
  signs.steps = run->steps;
  measure_ripple(signs, samples, phases(samples, measuring, corrections));
  return signs;
}

bool has_ripple(const FringeSigns& signs) {
  // A gamma of 1.1 with three steps; less moves no corner by a fifth of a pixel.
  constexpr double least = 0.03;    // rad
  constexpr double deviations = 5;  // one false alarm in a million scans
  return signs.ripple > std::max(least, deviations * signs.ripple_deviation);
}

Image<std::uint8_t> coverage_map(const BoardViews& views, Device device, Size size) {
  constexpr int columns = 100;
  const double cells_per_pixel = static_cast<double>(columns) / size.width;
  const int rows = std::max(1, static_cast<int>(std::lround(size.height * cells_per_pixel)));

  cv::Mat counts(rows, columns, CV_8U, cv::Scalar(0));
  for (const BoardView& view : views) {
    std::vector<cv::Point> cells;
    for (const Eigen::Vector2d& pixel : corners_of(view, device)) {
      if (pixel.allFinite()) cells.push_back(nearest_pixel(pixel * cells_per_pixel));
    }
    if (!cells.empty()) counts += within_hull(cells, counts.size());
  }

  return image_from<std::uint8_t>(counts);
}

double covered_share(const Image<std::uint8_t>& coverage) {
  return cv::countNonZero(mat_of(coverage)) / static_cast<double>(coverage.pixel_count());
}

}  // namespace slipstream
