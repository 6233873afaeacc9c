#include "slipstream/unwrapping.h"

#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Dense>

#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "codes/phase_chain.h"

namespace slipstream {
namespace {

using std::numbers::pi;

/// For coordinates with the same measuring phase: half way to the best fit of all bands there.
std::vector<WrongOrder> wrong_likelihoods(const Layout& layout) {
  const double f_h = measuring_band(layout).periods;
  std::vector<WrongOrder> wrong;
  for (int k = 1; k < f_h; ++k) {
    // How far the band's phase k measuring periods away is from the phase here.
    const auto apart = [&](const Band& band) {
      const double turns = band.periods * k / f_h;
      return 2 * pi * (turns - std::round(turns));
    };

    // A small shift of the coordinate explains part of these phases: its least-squares value.
    double along = 0, length = 0, square = 0;
    for (const Band& band : layout.bands) {
      along += apart(band) * band.periods / phase_noise(band);
      length += band.periods * band.periods / phase_noise(band);
    }

    // Noise must cover half of the rest.
    for (const Band& band : layout.bands) {
      square += turn((apart(band) - along / length * band.periods) / 2, phase_noise(band));
    }

    // There are such coordinates on both sides, except near the ends of the field.
    wrong.push_back({std::sqrt(square), 2 * (f_h - k) / f_h});
  }

  return wrong;
}

/// From all frames, which share one mean and modulation.
double single_frames_variance(const Layout& layout) {
  constexpr int places = 509;
  const std::vector<SingleFrame> frames = frames_of_sinusoids(layout);

  double sum = 0;
  for (int i = 0; i < places; ++i) {
    const double y = (i + 0.5) / places;
    // Normal equations of the mean, the modulation and y, with a row per frame.
    Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
    for (const SingleFrame& shown : frames) {
      const double a = two_pi * shown.periods * y + shown.origin;
      const Eigen::Vector3d row(1, std::cos(a), -two_pi * shown.periods * std::sin(a));
      products += row * row.transpose();
    }

    // The variance of y.
    sum += products.inverse()(2, 2);
  }

  return sum / places;
}

double fewest_periods(const Layout& layout) {
  return layout.bands[coarse_to_fine(layout).front()].periods;
}

std::string periods_text(const Layout& layout) {
  std::vector<double> periods;
  for (const Band& band : layout.bands) periods.push_back(band.periods);
  for (const SingleFrame& single : layout.single_frames) periods.push_back(single.periods);
  return fmt::format("{:g}", fmt::join(periods, ", "));
}

void require_hierarchy(const Layout& layout, std::string_view name) {
  throw_if(fewest_periods(layout) > 1, "{}: no band has at most 1 period to unwrap the others from",
           name);
}

void require_beats(const Layout& layout, std::string_view name) {
  throw_if(chain_of_beats(layout).empty(),
           "{}: no sum or difference of {} periods has at most 1 period", name,
           periods_text(layout));
}

[[noreturn]] void refuse_repeating(const Layout& layout, std::string_view name) {
  throw Error(fmt::format(
      "{}: {} periods repeat within the field; their lengths in projector pixels must have no "
      "common multiple below the field's length",
      name, periods_text(layout)));
}

void require_unlike(const Layout& layout, std::string_view name) {
  constexpr double least_margin = 1e-6;
  if (nearest_of(wrong_likelihoods(layout)) < least_margin) refuse_repeating(layout, name);
}

void require_code(const Layout& layout, std::string_view name) {
  throw_if(!layout.code, "{}: there is no code to unwrap with", name);
  require_valid(*layout.code, layout.frames, name);
}

void require_code_of_periods(const Layout& layout, std::string_view name) {
  require_code(layout, name);
  const double f = measuring_band(layout).periods;
  throw_if(layout.code->stripes < f - chain_rounding,
           "{}: a code of {} stripes is too short for {} periods", name, layout.code->stripes, f);
}

/// One band, and single frames of the scan with at most `most_periods` periods.
bool has_single_frames(const Layout& layout, double most_periods) {
  return layout.bands.size() == 1 && !layout.single_frames.empty() &&
         std::ranges::all_of(layout.single_frames, [&](const SingleFrame& single) {
           return single.frame >= 0 && single.frame < layout.frames && single.periods > 0 &&
                  single.periods <= most_periods;
         });
}

void require_surfaces(const Layout& layout, std::string_view name) {
  if (layout.bands.size() == 2 && layout.single_frames.empty()) return require_unlike(layout, name);
  throw_if(
      !has_single_frames(layout, 1) || layout.single_frames.size() < 3,
      "{}: unwrapping by surfaces requires two bands, or one and at least three single frames of "
      "at most one period each",
      name);
}

void require_single_frames(const Layout& layout, std::string_view name) {
  constexpr double any_periods = std::numeric_limits<double>::infinity();
  const auto run = step_run(layout.bands.front());
  throw_if(!has_single_frames(layout, any_periods) || !run,
           "{}: a run of steps and single frames of one sinusoid each are required", name);
  std::vector<int> shown(static_cast<std::size_t>(layout.frames));

  // 1. Each frame shows exactly one sinusoid.
  for (int n = run->first; n < run->first + run->steps; ++n) ++shown[static_cast<std::size_t>(n)];
  for (const SingleFrame& one : layout.single_frames) ++shown[static_cast<std::size_t>(one.frame)];
  throw_if(std::ranges::count(shown, 1) != std::ssize(shown),
           "{}: each frame must be either a step or one single frame", name);

  // 2. No shift by whole periods of the band leaves all single frames as they are.
  const double f = layout.bands.front().periods;
  for (int k = 1; k < f; ++k) {
    const bool repeats = std::ranges::all_of(layout.single_frames, [&](const SingleFrame& single) {
      return is_whole(single.periods * k / f);
    });
    if (repeats) refuse_repeating(layout, name);
  }
}

void require_cue(const Layout& layout, std::string_view name) {
  if (layout.cue) {
    require_valid(*layout.cue, layout.frames, name);
    throw_if(layout.bands.size() != 1, "{}: a cue with {} bands; it requires one", name,
             layout.bands.size());
  } else if (layout.bands.size() != 2 || layout.bands[1].periods != 1) {
    throw Error(fmt::format("{}: voting requires a cue or a second band of 1 period", name));
  }

  const double f_h = layout.bands[0].periods;
  throw_if(f_h != std::floor(f_h), "{}: {} periods are not a whole number", name, f_h);
}

constexpr UnwrappingWay none_way{.name = "none",
                                 .order_source = OrderSource::bands,
                                 .gives_coordinate = false,
                                 .least_periods = fewest_periods};

constexpr UnwrappingWay hierarchical_way{.name = "hierarchical",
                                         .order_source = OrderSource::bands,
                                         .require = require_hierarchy,
                                         .chain = chain_of_bands,
                                         .least_periods = fewest_periods};

constexpr UnwrappingWay surfaces_way{
    .name = "surfaces", .order_source = OrderSource::surface, .require = require_surfaces};

constexpr UnwrappingWay vote_way{
    .name = "vote", .order_source = OrderSource::neighbours, .require = require_cue};

constexpr UnwrappingWay beats_way{
    .name = "heterodyne",
    .order_source = OrderSource::pixel,
    .weighs_bands = true,
    .require = require_beats,
    .chain = chain_of_beats,
    .least_periods = [](const Layout& layout) { return chain_of_beats(layout).front().periods; }};

constexpr UnwrappingWay likelihood_way{.name = "number-theory",
                                       .order_source = OrderSource::pixel,
                                       .weighs_bands = true,
                                       .tries_orders = true,
                                       .require = require_unlike,
                                       .wrong_orders = wrong_likelihoods};

constexpr UnwrappingWay code_way{.name = "code",
                                 .order_source = OrderSource::pixel,
                                 .reads_code = true,
                                 .require = require_code_of_periods};

constexpr UnwrappingWay code_alone_way{.name = "code-alone",
                                       .order_source = OrderSource::pixel,
                                       .reads_code = true,
                                       .whole_stripes = true,
                                       .require = require_code};

constexpr UnwrappingWay single_frames_way{.name = "single-frames",
                                          .order_source = OrderSource::pixel,
                                          .tries_orders = true,
                                          .require = require_single_frames,
                                          .coordinate_variance = single_frames_variance};

}  // namespace

constinit const Unwrapping Unwrapping::none{none_way};
constinit const Unwrapping Unwrapping::hierarchical{hierarchical_way};
constinit const Unwrapping Unwrapping::surfaces{surfaces_way};
constinit const Unwrapping Unwrapping::vote{vote_way};
constinit const Unwrapping Unwrapping::beats{beats_way};
constinit const Unwrapping Unwrapping::likelihood{likelihood_way};
constinit const Unwrapping Unwrapping::code{code_way};
constinit const Unwrapping Unwrapping::code_alone{code_alone_way};
constinit const Unwrapping Unwrapping::single_frames{single_frames_way};

std::vector<PhaseSum> unwrapping_chain(const Layout& layout) {
  const UnwrappingWay& way = *layout.unwrapping;
  if (way.chain != nullptr) return way.chain(layout);
  return {band_alone(layout, measuring_band_index(layout))};
}

bool is_circle(const Layout& layout) {
  const std::vector<PhaseSum> chain = unwrapping_chain(layout);
  return std::ranges::all_of(
      chain, [&](const PhaseSum& sum) { return is_whole(sum.periods / chain.front().periods); });
}

std::vector<double> band_weights(const Layout& layout) {
  // Without weighing, the measuring band alone.
  std::vector<double> weights(layout.bands.size());
  const std::size_t measuring = measuring_band_index(layout);
  weights[measuring] = 1;
  if (!layout.unwrapping->weighs_bands) return weights;

  // Inverse variances of y, relative to the best band. Bands below a hundredth are left out.
  const auto precision = [](const Band& band) {
    return band.periods * band.periods / phase_noise(band);
  };

  const double best = precision(layout.bands[measuring]);
  double sum = 0;

  for (std::size_t i = 0; i < weights.size(); ++i) {
    const double share = precision(layout.bands[i]) / best;
    weights[i] = share < 0.01 ? 0 : share;
    sum += weights[i];
  }

  for (double& weight : weights) weight /= sum;
  return weights;
}

std::vector<SingleFrame> frames_of_sinusoids(const Layout& layout) {
  const Band& band = layout.bands.front();
  const StepRun run = *step_run(band);
  std::vector<SingleFrame> frames;
  for (int n = run.first; n < run.first + run.steps; ++n) {
    frames.push_back({n, band.periods, -std::atan2(band.sine[n], band.cosine[n])});
  }

  frames.insert(frames.end(), layout.single_frames.begin(), layout.single_frames.end());
  return frames;
}

double least_periods(const Layout& layout) {
  const UnwrappingWay& way = *layout.unwrapping;
  return way.least_periods != nullptr ? way.least_periods(layout) : 1;
}

std::vector<WrongOrder> wrong_orders(const Layout& layout) {
  const UnwrappingWay& way = *layout.unwrapping;
  return way.wrong_orders != nullptr ? way.wrong_orders(layout)
                                     : wrong_steps(layout, unwrapping_chain(layout));
}

double unwrapping_margin(const Layout& layout) {
  return nearest_of(wrong_orders(layout));
}

int fringe_order(double wrapped_phase, double frequency, double coarse_coordinate) {
  return static_cast<int>(std::lround(coarse_coordinate * frequency - wrapped_phase / two_pi));
}

double fringe_order_residual(double wrapped_phase, double frequency, double coarse_coordinate,
                             int fringe_order) {
  return coarse_coordinate * frequency - wrapped_phase / (two_pi)-fringe_order;
}

double unwrapped_coordinate(double wrapped_phase, int fringe_order, double frequency) {
  return (wrapped_phase + two_pi * fringe_order) / (two_pi * frequency);
}

double coordinate_in_field(double coordinate, double period, int projector_length) {
  const double unlit = period - 1;
  const double cut = -0.5 / projector_length - unlit / 2;
  return coordinate - period * std::floor((coordinate - cut) / period);
}

}  // namespace slipstream
