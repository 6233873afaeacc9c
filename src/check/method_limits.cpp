// What frames that fit cannot show, or measure badly.
#include "check/method_limits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/QR>
#include <fmt/format.h>

#include "base/linear_algebra.h"
#include "base/numbers.h"
#include "base/statistics.h"
#include "check/phase_noise.h"
#include "slipstream/unwrapping.h"

namespace slipstream {
namespace {

double light_shown(const Sequence& sequence, int n, double y) {
  const auto& [alpha_p, beta_p] = sequence.light;
  return std::max(0.0, (alpha_p * sequence.strategy.shape(n, y, 0) + beta_p) / 255);
}

/// Phase error of the measuring band, RMS, rad, for one unit of gamma - 1, to first order.
double phase_error_of_gamma(const JudgedScan& scan) {
  constexpr int places = 31;  // prime, to avoid aliasing with any period
  constexpr float little = 0.1F;

  Eigen::ArrayXf light(scan.samples.frames());
  SampleReading reading;

  const auto phase_of = [&](const Eigen::ArrayXf& levels) {
    scan.model.read(levels.data(), scan.model.identity(), reading);
    return reading.phase[scan.model.measuring_band()];
  };

  double squares = 0;
  for (int i = 0; i < places; ++i) {
    for (int n = 0; n < light.size(); ++n) {
      light[n] = static_cast<float>(light_shown(scan.sequence, n, (i + 0.5) / places));
    }

    const double error = phase_of(light.pow(1 + little)) - phase_of(light);
    squares += std::pow(std::remainder(error, two_pi), 2);
  }

  return std::sqrt(squares / places) / static_cast<double>(little);
}

/// Factors of the surface's ambient light, of its change along the picture's width and height, of
/// the camera's offset and gamma - 1, then the sum.
constexpr int light_factors = 5;
using LightRow = Eigen::Vector<double, light_factors + 1>;

/// Appends the frames of a group, without all that changes of modulations and coordinate explain.
void add_rows(const JudgedScan& scan, std::size_t group, SampleReading& reading,
              std::vector<LightRow>& rows) {
  const FrameModel& model = scan.model;
  const std::vector<Band>& bands = model.layout().bands;
  const float* const levels = scan.samples.levels(group, ScanSamples::middle);
  model.read(levels, model.identity(), reading);

  // Step of the finite difference in y: a thousandth of a period.
  const double h = 1e-3 / std::max(1.0, bands[model.measuring_band()].periods);
  const double y = std::clamp(reading.coordinate, h, 1 - h);

  const auto unknowns = static_cast<Eigen::Index>(bands.size());
  // A column per band's modulation and one for the coordinate.
  Eigen::MatrixXd moved = Eigen::MatrixXd::Zero(scan.samples.frames(), unknowns + 1);
  Eigen::MatrixXd causes = Eigen::MatrixXd::Zero(scan.samples.frames(), light_factors + 1);

  // The pixel's place in the picture, -1 to 1.
  const Size size = scan.samples.size();
  const double right = 2.0 * scan.samples.column(group) / size.width - 1;
  const double down = 2.0 * scan.samples.row(group) / size.height - 1;

  for (int n = 0; n < scan.samples.frames(); ++n) {
    const auto band = std::ranges::find_if(
        bands, [&](const Band& b) { return b.cosine[n] != 0 || b.sine[n] != 0; });
    if (band == bands.end()) continue;  // a code's frame

    const auto light = [&](double dy) { return light_shown(scan.sequence, n, y + dy); };

    // 2 B is the brightness of the surface under the patterns' light.
    const auto b = band - bands.begin();
    const double alpha = 2 * reading.modulation[b] / band->share, u = light(0);

    moved(n, b) = u;
    moved(n, unknowns) = alpha * (light(h) - light(-h)) / h;

    // The derivative of u^gamma at gamma = 1 is u log u.
    causes.row(n) << alpha, alpha * right, alpha * down, 255 * scan.samples.gain(group),
        alpha * u * std::log(std::max(u, 1e-9)), levels[n];
  }

  // Rows beyond the rank are orthogonal to modulations and coordinate.
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(moved);
  causes.applyOnTheLeft(qr.householderQ().adjoint());
  for (auto i = qr.rank(); i < causes.rows(); ++i) {
    if (!causes.row(i).isZero()) rows.emplace_back(causes.row(i));
  }
}

/// Gamma - 1 and its standard error, by least squares with Tukey's weights. On uniform surfaces
/// negative ambient light or a large offset would imitate gamma: both are bounded.
std::pair<double, double> fitted_gamma(const std::vector<LightRow>& rows, double most_offset) {
  constexpr double any = std::numeric_limits<double>::infinity();
  constexpr int gamma = light_factors - 1;

  LightRow factors = LightRow::Zero();
  factors[light_factors] = -1;
  double scale = any, error = 0;

  for (int round = 0; round < 5; ++round) {
    // Weighted normal equations; the fitted factors reduce the degrees of freedom.
    Eigen::Matrix<double, light_factors + 1, light_factors + 1> sums;
    sums.setIdentity();
    sums *= 1e-9;
    double weights = -light_factors;
    std::vector<double> sizes;

    for (const LightRow& row : rows) {
      const double weight = tukey_weight(row.dot(factors) / scale);
      sums += weight * row * row.transpose();
      weights += weight;
    }

    // One factor after another, 200 times around, each within its bounds.
    for (int i = 0; i < 200 * light_factors; ++i) {
      const int k = i % light_factors;

      // Ambient light is nowhere negative, so that it changes by no more than its mean.
      const double ambient = factors[0];
      const LightRow least{0, -ambient, -ambient, 0, -any, 0};
      const LightRow most{any, ambient, ambient, most_offset, any, 0};
      factors[k] =
          std::clamp(factors[k] - sums.row(k).dot(factors) / sums(k, k), least[k], most[k]);
    }

    // Standard error of gamma.
    error = std::sqrt(factors.dot(sums * factors) / std::max(1.0, weights) *
                      inverse_of(sums.topLeftCorner<light_factors, light_factors>())(gamma, gamma));

    // A robust standard deviation of the rest scales the next round's weights.
    for (const LightRow& row : rows) sizes.push_back(std::abs(row.dot(factors)));
    scale = std::max(deviation_from_median(quantile(sizes, 0.5)), 1e-6);
  }

  return {factors[gamma], error};
}

/// Groups in parts of the picture with as many in each: halves from left to right, and each of them
/// from top to bottom. One part if they are few.
std::vector<std::vector<std::size_t>> parts_of_picture(const ScanSamples& samples) {
  constexpr std::size_t parts = 4, most_groups = parts * ScanSamples::fewest_groups;
  std::vector<std::size_t> groups(std::min(most_groups, samples.groups()));
  std::iota(groups.begin(), groups.end(), std::size_t{0});
  if (groups.size() < most_groups) return {groups};

  const std::span all(groups);
  std::ranges::sort(all, {}, [&](std::size_t g) { return samples.column(g); });
  for (const auto half : {all.first(most_groups / 2), all.last(most_groups / 2)}) {
    std::ranges::sort(half, {}, [&](std::size_t g) { return samples.row(g); });
  }

  std::vector<std::vector<std::size_t>> found;
  for (std::size_t part = 0; part < parts; ++part) {
    const auto of_part = all.subspan(part * ScanSamples::fewest_groups, ScanSamples::fewest_groups);
    found.emplace_back(of_part.begin(), of_part.end());
  }
  return found;
}

/// Gamma - 1 and its standard error: over the whole picture, or the mean over its parts and how far
/// they differ, whichever proves more. Each part has its own ambient light, which no plane
/// describes over a whole picture; but a part of a few uniform surfaces says little.
std::pair<double, double> measured_gamma(const JudgedScan& scan, double most_offset) {
  std::vector<LightRow> all;
  std::vector<double> found;
  double sum = 0, squares = 0;
  SampleReading reading;

  for (const std::vector<std::size_t>& part : parts_of_picture(scan.samples)) {
    std::vector<LightRow> rows;
    for (const std::size_t group : part) add_rows(scan, group, reading, rows);
    if (rows.empty()) continue;

    all.insert(all.end(), rows.begin(), rows.end());
    const auto [gamma, error] = fitted_gamma(rows, most_offset);
    found.push_back(gamma);
    sum += gamma;
    squares += error * error;
  }

  // Frames without redundancy show nothing of gamma.
  if (all.empty()) return {0, 1};

  const std::pair of_picture = fitted_gamma(all, most_offset);
  if (found.size() < 2) return of_picture;

  // Standard error of the mean: by noise, or by the spread of the parts.
  const auto count = static_cast<double>(found.size());
  double spread = 0;
  for (const double gamma : found) spread += std::pow(gamma - sum / count, 2);
  const std::pair of_parts{sum / count,
                           std::sqrt(std::max(squares / count, spread / (count - 1)) / count)};

  const auto most = [](const std::pair<double, double>& gamma) {
    return std::abs(gamma.first) + 3 * gamma.second;
  };
  return std::ranges::min(of_parts, of_picture, {}, most);
}

/// A warning if no response is known, a usual gamma would distort the phase by more than its noise,
/// rad, and the frames do not prove that there is none.
std::optional<Finding> unknown_response(const JudgedScan& scan, double noise) {
  // Correct scans: within 0.04, by light between surfaces.
  constexpr double linear = 0.06, most_usual = 1.8;  // gamma - 1

  // Too weak a gamma for the noise to show needs no warning.
  const double bend = phase_error_of_gamma(scan), least = noise / bend;
  if (scan.photometry.response || least > most_usual) return std::nullopt;

  // The largest offset, as a share of the camera's range; few cameras and rooms have as much.
  const double most_offset = std::max(0.125, 1.5 * scan.photometry.ambient.value_or(0) / 255);
  const auto [off, error] = measured_gamma(scan, most_offset);

  const double doubt = 3 * error, most = std::max(linear, least);
  if (std::abs(off) + doubt <= most) return std::nullopt;

  std::vector<Remedy> remedies{{"measure it with `calibrate_gamma()`"}};
  if (!scan.settings.blind) remedies.push_back(try_setting("gamma", "blind"));
  remedies.push_back({"give `gamma 1` if it is linear", {{"gamma", "1"}}});

  const bool seen = std::abs(off) > doubt;
  return Finding{.kind = seen ? FindingKind::nonlinear_light : FindingKind::unproven_response,
                 .what = seen ? "the light is not proportional to the patterns' grey levels"
                              : "the frames cannot show whether the light is proportional to the "
                                "patterns' grey levels, and no response is known",
                 .evidence = {{"gamma to first order", 1 + off},
                              {"three standard errors", doubt},
                              {"phase error", bend * (std::abs(off) + doubt), "rad", bend * most},
                              {"phase noise", noise, "rad"}},
                 .causes = {{CauseKind::gamma,
                             seen ? "the projector's gamma (with the camera's) is not corrected"
                                  : "the projector's gamma, if it is not 1"}},
                 .remedies = std::move(remedies)};
}

/// A warning if noise of depth exceeds 1 % somewhere in the field (three standard deviations then
/// exceed the 3 % beyond which points are dropped), and stripes along the other axis would move at
/// least `most` times as far with depth. `noise`: of the coordinate, fields.
std::optional<Finding> stripes_along_baseline(const JudgedScan& scan, double depth, double noise) {
  constexpr double most = 3, share = 0.01;
  const Lens& projector = scan.scanner->projector;

  // Depth moves a pixel p of the projector along the epipolar line, by (K t - p (K t)_z) / z.
  const Eigen::Vector3d epipole = projector.intrinsic * scan.scanner->translation * (share / depth);

  // The move by 1 % of the depth at either corner of the field, and its mean size, pixels.
  const Eigen::Array2d size(projector.size.width, projector.size.height);
  const Eigen::Array2d first = epipole.head<2>(), last = first - size * epipole.z();
  const Eigen::Array2d moves = (first.abs() + last.abs()) / 2;

  const int along = scan.sequence.axis == Axis::x ? 0 : 1;
  const bool stands = first[along] * last[along] <= 0;  // somewhere in the field
  const double least = stands ? 0 : std::min(std::abs(first[along]), std::abs(last[along]));

  const Eigen::Array2d shares = moves / size;  // with as many periods along both axes
  if (least > noise * size[along] || shares[1 - along] < most * shares[along]) return std::nullopt;

  const std::string_view other = name_of(across(scan.sequence.axis));
  return Finding{.kind = FindingKind::stripes_along_baseline,
                 .what = "the stripes run along the baseline: depth hardly moves them",
                 .evidence = {{"projector pixels for 1 % of the depth", moves[along]},
                              {fmt::format("along {}", other), moves[1 - along]}},
                 .causes = {{CauseKind::axis, fmt::format("a rig for patterns along {}", other)}},
                 .remedies = {{fmt::format("scan with `axis {}`", other)}}};
}

/// A warning if neighbouring pixels differ by much more than noise and the projector's pixels make
/// them.
std::optional<Finding> unexplained_noise(const JudgedScan& scan, const PhaseNoise& noise) {
  constexpr double most = 3;  // standard deviations: a wrong noise variance may give 2
  constexpr std::size_t most_groups = 128;

  const FrameModel& model = scan.model;
  const std::size_t band = model.measuring_band();
  std::array<SampleReading, ScanSamples::far_right> read;
  std::vector<double> ratios;

  for (std::size_t g = 0; g < scan.samples.groups() && ratios.size() < most_groups; ++g) {
    bool lit = true;
    for (std::size_t i = 0; i < read.size(); ++i) {
      const auto place = static_cast<ScanSamples::Place>(i);
      lit = lit && scan.samples.lit(g, place);
      model.read(scan.samples.levels(g, place), model.identity(), read[i]);
    }

    if (!lit) continue;

    // The twist of four pixels: slopes cancel, and most of the curvature. Its noise is twice the
    // noise of one phase.
    const double twist = std::remainder(
        read[0].phase[band] - read[1].phase[band] - read[2].phase[band] + read[3].phase[band],
        two_pi);
    const double of_pixel = noise.of_level / read[0].modulation[band];
    ratios.push_back(std::abs(twist) / (2 * std::hypot(of_pixel, noise.by_pixel)));
  }

  if (ratios.size() < ScanSamples::fewest_groups) return std::nullopt;
  const double ratio = deviation_from_median(quantile(ratios, 0.5));
  if (ratio <= most) return std::nullopt;

  return Finding{
      .kind = FindingKind::excess_noise,
      .what =
          fmt::format("neighbouring pixels differ over {:g} times as much as noise explains", most),
      .evidence = {{.name = "times the noise", .value = ratio, .limit = most}},
      .causes = {{CauseKind::noise,
                  "one-bit patterns in focus, speckle, compressed pictures or too small a noise "
                  "variance"}},
      .remedies = {{"defocus the projector or show 8-bit patterns; measure the noise with "
                    "`calibrate_noise()`"}}};
}

}  // namespace

std::optional<Finding> small_scale(const Scanner& scanner, double median_depth) {
  // mm: a C-mount is 25.4 wide, so that two lenses are not closer; nor do they focus closer than
  // 100.
  constexpr double least_baseline = 25.4, least_depth = 100;

  const double baseline = scanner.translation.norm();
  if (baseline >= least_baseline && median_depth >= least_depth) return std::nullopt;

  return Finding{.kind = FindingKind::small_scale,
                 .what = fmt::format("the baseline is below {:g} mm or the depth below {:g} mm",
                                     least_baseline, least_depth),
                 .evidence = {{"baseline", baseline, "mm", least_baseline},
                              {"median depth", median_depth, "mm", least_depth}},
                 .causes = {{CauseKind::scanner_file, "a scanner file in centimetres or inches"}},
                 .remedies = {{"write its translation in mm, or calibrate with `spacing` in mm"}}};
}

std::vector<Finding> method_limits(const JudgedScan& scan, const Fit& fit) {
  std::vector<Finding> findings;
  const FrameModel& model = scan.model;
  const Layout& layout = model.layout();
  if (scan.samples.groups() < ScanSamples::fewest_groups || !model.has_coordinate())
    return findings;

  // 1. Noise of the phase at the scene's typical modulation.
  const Band& band = layout.bands[model.measuring_band()];
  const PhaseNoise noise = phase_noise(model, scan);

  const auto add = [&](std::optional<Finding> found) {
    if (found) findings.push_back(std::move(*found));
    return found.has_value();
  };

  // 2. Limits of the rig.
  if (fit.geometry) {
    add(stripes_along_baseline(scan, fit.geometry->median_depth,
                               noise.typical / two_pi / band.periods));
    add(small_scale(*scan.scanner, fit.geometry->median_depth));
  }

  // 3. Limits of the patterns, which motion and whole stripes hide.
  if (scan.settings.moving || layout.unwrapping->whole_stripes) return findings;

  const bool scattered = add(unexplained_noise(scan, noise));

  // One-bit patterns are not proportional to grey levels pixel by pixel, nor are blurred carriers.
  if ((scattered && scan.sequence.binary) || band.carrier > 0) return findings;

  // The frames have shown a waveform that hardly bends the phase.
  if (fit.waveform) return findings;

  add(unknown_response(scan, std::hypot(noise.typical, noise.by_pixel)));
  return findings;
}

}  // namespace slipstream
