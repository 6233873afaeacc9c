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

namespace slipstream {
namespace {

using std::numbers::pi;
constexpr double infinity = std::numeric_limits<double>::infinity();

PhaseSum band_alone(const Layout& layout, std::size_t band) {
  PhaseSum sum{.of = std::vector<int>(layout.bands.size()), .periods = layout.bands[band].periods};
  sum.of[band] = 1;
  return sum;
}

/// Variance of the band's phase for B = 1 at a share of 1 and frame noise of variance 1.
double phase_noise(const Band& band) {
  return component_noise(band) / (band.share * band.share);
}

/// Squared distance, in standard deviations, that noise must move C + i S to turn it by `angle`.
double turn(double angle, double phase_noise) {
  const double distance = std::sin(std::min(std::abs(angle), pi / 2));
  return distance * distance / phase_noise;
}

/// Standard deviations from the right fringe order of `fine`, given `coarse`, to the next one.
double margin(const Layout& layout, const PhaseSum& coarse, const PhaseSum& fine) {
  const double ratio = fine.periods / coarse.periods;
  const auto factor = [&](std::size_t i) { return ratio * coarse.of[i] - fine.of[i]; };

  // Variance of the fine phase minus its prediction from the coarse one.
  double variance = 0;
  for (std::size_t i = 0; i < layout.bands.size(); ++i) {
    variance += factor(i) * factor(i) * phase_noise(layout.bands[i]);
  }

  // The likeliest noise that turns this difference by pi: each band's part of it, in deviations.
  double square = 0;
  for (std::size_t i = 0; i < layout.bands.size(); ++i) {
    const double noise = phase_noise(layout.bands[i]);
    square += turn(pi * factor(i) * noise / variance, noise);
  }

  return std::sqrt(square);
}

/// All sums with factors from -2 to 2 and at most four bands counted, from fewest periods up to the
/// measuring band, which is last.
std::vector<PhaseSum> beats(const Layout& layout) {
  constexpr int most_factor = 2, most_bands = 4;
  constexpr double least_periods = 0.02;
  const PhaseSum measuring = band_alone(layout, measuring_band_index(layout));
  std::vector<PhaseSum> sums{{std::vector<int>(layout.bands.size()), 0}};

  // Add the bands one after another, with every factor.
  for (std::size_t i = 0; i < layout.bands.size(); ++i) {
    const std::vector<PhaseSum> before = sums;
    for (int factor = -most_factor; factor <= most_factor; ++factor) {
      if (factor == 0) continue;
      for (PhaseSum sum : before) {
        sum.of[i] = factor;
        sum.periods += factor * layout.bands[i].periods;

        int counted = 0;
        for (const int of : sum.of) counted += std::abs(of);
        if (counted <= most_bands) sums.push_back(std::move(sum));
      }
    }
  }

  // A sum of hardly any periods gives no position; one as fine as the measuring band is not needed.
  std::erase_if(sums, [&](const PhaseSum& sum) {
    return sum.periods < least_periods || sum.periods >= measuring.periods;
  });

  std::ranges::stable_sort(sums, {}, &PhaseSum::periods);
  sums.push_back(measuring);
  return sums;
}

constexpr double chain_rounding = 1e-9;

bool is_whole(double ratio) {
  return std::abs(ratio - std::round(ratio)) <= chain_rounding;
}

/// The chain from at most one period to the measuring band whose worst step has the largest margin;
/// an empty one if impossible. `circle_of`: uses only sums that repeat with these periods.
std::vector<PhaseSum> surest_chain(const Layout& layout, std::vector<PhaseSum> sums,
                                   std::optional<double> circle_of) {
  const auto repeats = [&](const PhaseSum& sum) {
    return !circle_of || is_whole(sum.periods / *circle_of);
  };
  if (!repeats(sums.back())) return {};
  std::erase_if(sums, [&](const PhaseSum& sum) { return !repeats(sum); });

  // The best way to each sum: its worst margin, the sum before it and the number of steps.
  struct Way {
    double surest = 0;
    std::size_t from = 0;
    int steps = 0;
  };
  std::vector<Way> ways(sums.size());

  // Sums of at most one period start a chain.
  for (std::size_t fine = 0; fine < sums.size(); ++fine) {
    if (sums[fine].periods <= circle_of.value_or(1) + chain_rounding) {
      ways[fine] = {infinity, fine, 0};
    }

    // All others continue the chain of a coarser sum: the one with the best margin or, at equal
    // margins, the shortest.
    for (std::size_t coarse = 0; coarse < fine; ++coarse) {
      if (ways[coarse].surest == 0 || ways[fine].surest == infinity) continue;
      const double surest = std::min(ways[coarse].surest, margin(layout, sums[coarse], sums[fine]));
      const Way way{surest, coarse, ways[coarse].steps + 1};

      const bool shorter =
          way.surest > ways[fine].surest - chain_rounding && way.steps < ways[fine].steps;
      if (way.surest > ways[fine].surest + chain_rounding || shorter) ways[fine] = way;
    }
  }

  // Follow the best way back from the measuring band.
  if (ways.back().surest == 0) return {};
  std::size_t at = sums.size() - 1;
  std::vector<PhaseSum> chain{sums[at]};
  for (; ways[at].from != at; at = ways[at].from) chain.insert(chain.begin(), sums[ways[at].from]);

  return chain;
}

std::vector<WrongOrder> wrong_steps(const Layout& layout, const std::vector<PhaseSum>& chain) {
  std::vector<WrongOrder> wrong;
  for (std::size_t i = 1; i < chain.size(); ++i) {
    wrong.push_back({margin(layout, chain[i - 1], chain[i]), 2});
  }
  return wrong;
}

double nearest_of(const std::vector<WrongOrder>& wrong) {
  double nearest = infinity;
  for (const WrongOrder& order : wrong) nearest = std::min(nearest, order.margin);
  return nearest;
}

/// A cyclic chain is unaffected by the field's ends, so it may have a somewhat lower margin.
std::vector<PhaseSum> chain_of_beats(const Layout& layout) {
  constexpr double worth = 0.7;
  const auto surest_of = [&](const std::vector<PhaseSum>& chain) {
    return nearest_of(wrong_steps(layout, chain));
  };

  // The best chain of any kind, and the best one that is cyclic with its first sum's periods.
  const std::vector<PhaseSum> sums = beats(layout);
  std::vector<PhaseSum> any = surest_chain(layout, sums, std::nullopt), circle;

  for (const PhaseSum& first : sums) {
    if (first.periods > 1 + chain_rounding) break;
    std::vector<PhaseSum> chain = surest_chain(layout, sums, first.periods);
    if (chain.empty()) continue;
    if (circle.empty() || surest_of(chain) > surest_of(circle) + chain_rounding)
      circle = std::move(chain);
  }

  return !circle.empty() && surest_of(circle) >= worth * surest_of(any) ? circle : any;
}

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

std::vector<PhaseSum> chain_of_bands(const Layout& layout) {
  std::vector<PhaseSum> chain;
  for (const std::size_t i : coarse_to_fine(layout)) chain.push_back(band_alone(layout, i));
  return chain;
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
  const auto run = step_run(layout.bands.front());
  throw_if(!has_single_frames(layout, infinity) || !run,
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
