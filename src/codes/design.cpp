#include "codes/design.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "base/throw_if-inl.h"
#include "codes/predicted_variance.h"
#include "slipstream/gray_code.h"
#include "slipstream/unwrapping.h"

namespace slipstream {
namespace {

using std::numbers::pi;

/// Probability that a standard normal variable exceeds x.
double upper_tail(double x) {
  return 0.5 * std::erfc(x / std::numbers::sqrt2);
}

double reference_sigma(const Layout& layout, const PatternLight& light, double alpha,
                       double ambient, double noise_variance, double R) {
  const Band& band = layout.bands[0];
  // Three frames: the cue is in the DC channel, Eq. (3.67).
  if (needs_ambient_light(layout)) {
    return std::sqrt(noise_variance * dc_reference_variance(alpha, light, ambient, band.share, R));
  }

  // (3.76) for any such channel: R = c_1 rho / (c_2 B), rho the cue's value.
  const double shares = band.share / layout.cue->share;
  const double modulation = band.share * alpha * light.alpha_p / 2;
  return std::sqrt(shares * shares * cue_variance(*layout.cue, noise_variance) +
                   R * R * (component_noise(band) * noise_variance)) /
         modulation;
}

/// The design with the least noise at f_h that meets the goal: c_1 as large as possible.
std::optional<Design> design_at(const DesignGoal& goal, const PatternLight& light, int f_h) {
  // From the largest c_1 down: the first one that unwraps well enough has the strongest fringe.
  for (int hundredths = 95; hundredths > 0; --hundredths) {
    const double c1 = 0.01 * hundredths;
    if (c1 * f_h <= 1) return std::nullopt;  // (3.64)

    const PhaseChannelMultiplexing strategy{
        .steps = goal.steps, .high = f_h, .share = c1, .reference = {}};
    const double success = predicted_unwrapping(strategy.layout(), light, goal.alpha, goal.ambient,
                                                goal.noise_variance);
    if (success < goal.success) continue;

    const double modulation = goal.alpha * light.alpha_p / 2 * c1;  // (3.57)
    const double variance = coordinate_variance(strategy.layout(), modulation, goal.noise_variance);
    return Design{.strategy = strategy,
                  .light = light,
                  .success = success,
                  .coordinate_sigma = std::sqrt(variance)};
  }

  return std::nullopt;
}

double modulation_at(double alpha) {
  return alpha * PatternLight{}.alpha_p / 2;
}

/// Candidate strategies of every kind with `frames` frames and at most `most_periods` periods.
std::vector<Strategy> candidates(int frames, int most_periods) {
  std::vector<Strategy> all{PhaseMeasuring{.steps = frames}};

  // Keeps a coding only if it takes exactly this number of frames and periods within the limit.
  const auto add = [&](const auto& coding) {
    try {
      const Strategy strategy = coding;
      if (frame_count(strategy) == frames && highest_frequency(strategy) <= most_periods) {
        all.push_back(strategy);
      }
    } catch (const Error&) {  // not available with this many frames
    }
  };

  // Codings tried at one frequency only.
  add(DoubleThreeStep{});
  add(TwoPlusOne{});
  if (frames % 2 == 0) add(TwoFrequency2N{.steps = frames / 2});

  // Codings tried at every high frequency up to the limit.
  for (int high = 2; high <= most_periods; ++high) {
    const double f = high;
    add(PhaseChannelMultiplexing{.steps = frames, .high = f});
    add(PeriodCoded{.steps = frames, .high = f});
    add(DualFrequency{.steps = frames - 3, .low_steps = 3, .high = f});

    // Three bands: a geometric series, and close frequencies whose beats have about sqrt(f) periods
    // and whose beat of beats has one.
    const double root = std::round(std::sqrt(f));
    if (root > 1) {
      const std::vector<int> steps{frames - 6, 3, 3};
      add(MultiFrequency{.steps = steps, .periods = {f, root, 1}});
      add(MultiFrequency{.steps = steps, .periods = {f, f - root, f - 2 * root + 1}});
    }

    for (int bits = 1; bits <= 10; ++bits) add(GrayPhase{.steps = frames - bits, .periods = f});
  }

  return all;
}

/// Warns of too few projector pixels a period; otherwise empty.
std::string resolution_warning(const Sequence& sequence) {
  // A projector pixel shows the N phases of a sinusoid exactly, however few pixels a period has,
  // down to Nyquist's two. But it spreads each over its width, which leaves sinc(1 / p) of the
  // modulation before any lens: 0.64 at two pixels, 0.90 at four.
  constexpr int fewest_pixels = 4;

  const int length = length_along(sequence.axis, sequence.projector);
  const double highest = highest_frequency(sequence.strategy), pixels = length / highest;
  if (length == 0 || !(pixels < fewest_pixels)) return {};

  const double angle = std::numbers::pi / pixels;
  return fmt::format(
      "{:g} periods over {} projector pixels are {:.3g} pixels each, near Nyquist's limit of 2: "
      "their width alone removes {:.0f} % of the modulation, and lenses more; {} periods lose 10 %",
      highest, length, pixels, 100 * (1 - std::sin(angle) / angle), length / fewest_pixels);
}

}  // namespace

void require_valid(const DesignGoal& goal) {
  const auto& [N, alpha, ambient, noise, success, most] = goal;

  require_in_range(N >= 3 && N <= 64, "steps", N, "3 to 64");
  require_in_range(alpha > 0 && alpha <= 1, "reflectivity", alpha, "above 0, at most 1");
  require_in_range(std::abs(ambient) <= 255, "ambient light", ambient, "-255 to 255");
  require_in_range(noise > 0 && std::isfinite(noise), "noise variance", noise, "above 0");
  require_in_range(success >= 0.5 && success < 1, "success", success, "0.5 and more, below 1");
  require_in_range(most >= 2 && most <= 1000, "most periods", most, "2 to 1000");
}

double predicted_unwrapping(const Layout& layout, const PatternLight& light, double alpha,
                            double ambient, double noise_variance) {
  const double f_h = layout.bands[0].periods;

  // A second band of one period is the cue: its noise against half a period of the fringe.
  if (!layout.cue) {
    const Band& cue = layout.bands[1];
    const double modulation = cue.share * alpha * light.alpha_p / 2;
    const double variance = phase_variance(cue, modulation, noise_variance);
    return 1 - 2 * upper_tail(pi / f_h / std::sqrt(variance));
  }

  // A cue with a reference: the chance of a neighbouring period, averaged over the field.
  constexpr int places = 400;
  const CueReference& reference = layout.cue->reference;
  double sum = 0;
  for (int place = 0; place < places; ++place) {
    const double y = (place + 0.5) / places;
    const double R = reference(y);
    const double sigma = reference_sigma(layout, light, alpha, ambient, noise_variance, R);

    // The order is wrong once noise takes the cue more than half way to the next period's.
    const auto missed = [&](double other) { return upper_tail(std::abs(other - R) / sigma); };

    // The first period has no predecessor, the last no successor.
    const int k = static_cast<int>(y * f_h);
    double wrong = 0;
    if (k > 0) wrong += missed(reference(y - 0.5 / f_h));
    if (k < f_h - 1) wrong += missed(reference(y + 0.5 / f_h));

    sum += 1 - wrong;
  }

  return sum / places;
}

PatternLight brightest_light(const DesignGoal& goal) {
  require_valid(goal);

  // Three standard deviations of the noise stay clear of both ends of the range.
  const double clear = 3 * std::sqrt(goal.noise_variance);
  const double beta = goal.ambient;

  // alpha (beta_p + beta) + beta >= clear, and alpha_p + beta_p + 2 beta <= 255 - clear.
  const double beta_p = std::ceil(std::max(0.0, (clear - beta) / goal.alpha - beta));
  const double alpha_p = std::floor(std::min(255.0, 255 - clear - 2 * beta) - beta_p);

  const PatternLight light{.alpha_p = alpha_p, .beta_p = beta_p};
  throw_if(!(light.alpha_p >= 1),
           "no patterns keep a reflectivity of {} above zero with ambient light {} and sigma_w^2 "
           "{}; use a brighter surface or less ambient light",
           goal.alpha, goal.ambient, goal.noise_variance);

  return light;
}

std::vector<Design> designs_by_frequency(const DesignGoal& goal) {
  const PatternLight light = brightest_light(goal);
  std::vector<Design> designs;

  for (int f_h = 2; f_h <= goal.most_periods; ++f_h) {
    if (const auto design = design_at(goal, light, f_h)) designs.push_back(*design);
  }

  return designs;
}

Design best_design(const DesignGoal& goal) {
  const std::vector<Design> designs = designs_by_frequency(goal);

  throw_if(designs.empty(),
           "no patterns of {} steps unwrap {} % of the pixels; lower the success rate or use more "
           "steps",
           goal.steps, 100 * goal.success);

  return *std::ranges::min_element(designs, {}, &Design::coordinate_sigma);
}

std::string doubt_about(const Sequence& sequence) {
  if (std::string doubt = resolution_warning(sequence); !doubt.empty()) return doubt;

  // Only a cue that relies on the neighbours can be too weak.
  constexpr double least_success = 0.85;
  const Layout& layout = sequence.strategy.layout();
  if (order_source(layout) != OrderSource::neighbours) return {};

  // Prediction for the surface, light and noise of a default goal.
  const DesignGoal usual{};
  const double success = predicted_unwrapping(layout, sequence.light, usual.alpha, usual.ambient,
                                              usual.noise_variance);
  if (success >= least_success) return {};

  return fmt::format(
      "at a reflectivity of {} and sigma_w^2 of {} only {:.0f} % of the pixels would be unwrapped "
      "correctly on their own; use fewer periods{}, see `design()`",
      usual.alpha, usual.noise_variance, 100 * success,
      layout.bands[0].share < 1 ? " or a smaller `share`" : "");
}

void require_valid(const StrategyGoal& goal) {
  require_valid(DesignGoal{.alpha = goal.alpha,
                           .noise_variance = goal.noise_variance,
                           .success = goal.success,
                           .most_periods = goal.most_periods});

  require_in_range(goal.frames >= 3 && goal.frames <= 64, "frames", goal.frames, "3 to 64");
  const double sigma = goal.coordinate_sigma.value_or(1);
  require_in_range(sigma > 0, "coordinate sigma", sigma, "above 0");
}

double predicted_success(const Layout& layout, double alpha, double noise_variance) {
  if (order_source(layout) == OrderSource::neighbours) {
    return predicted_unwrapping(layout, {}, alpha, 0, noise_variance);
  }

  // The margins are for B = sigma_w = 1 and grow with B / sigma_w.
  const double deviations = modulation_at(alpha) / std::sqrt(noise_variance);
  double right = 1;
  for (const WrongOrder& order : wrong_orders(layout)) {
    right *= std::pow(1 - upper_tail(order.margin * deviations), order.count);
  }

  if (!layout.code) return right;

  // A bit is compared with its reference, which has less noise than the bit.
  const double weakest = measuring_band(layout).share * deviations;
  const double wrong_bit = upper_tail(weakest / std::sqrt(2.0));
  return right * std::pow(1 - wrong_bit, static_cast<double>(layout.code->frames.size()));
}

std::vector<StrategyDesign> strategy_designs(const StrategyGoal& goal) {
  require_valid(goal);

  // 1. The best design of each kind.
  std::map<std::string, StrategyDesign> best;
  for (int frames = 3; frames <= goal.frames; ++frames) {
    for (const Strategy& strategy : candidates(frames, goal.most_periods)) {
      const Layout& layout = strategy.layout();
      const double B = measuring_band(layout).share * modulation_at(goal.alpha);
      const StrategyDesign design{
          .strategy = strategy,
          .success = predicted_success(layout, goal.alpha, goal.noise_variance),
          .coordinate_sigma = std::sqrt(coordinate_variance(layout, B, goal.noise_variance))};

      // Leave out designs that miss the goal.
      if (design.success < goal.success || !has_coordinate(layout)) continue;
      if (goal.coordinate_sigma && design.coordinate_sigma > *goal.coordinate_sigma) continue;

      // The number of frames only grows in this loop. If the noise is given, a design replaces the
      // known one only with an equal number.
      const auto [known, is_first] = best.try_emplace(strategy.name(), design);
      if (is_first) continue;
      const bool fewer = frame_count(known->second.strategy) == frames || !goal.coordinate_sigma;
      const bool better = design.coordinate_sigma < known->second.coordinate_sigma;
      if (fewer && better) known->second = design;
    }
  }

  // 2. In order of frames if the noise is given, then of noise.
  std::vector<StrategyDesign> designs;
  for (auto& [name, design] : best) designs.push_back(std::move(design));
  std::ranges::sort(designs, [&](const auto& a, const auto& b) {
    const int before = goal.coordinate_sigma ? frame_count(a.strategy) : 0;
    const int after = goal.coordinate_sigma ? frame_count(b.strategy) : 0;
    return std::pair(before, a.coordinate_sigma) < std::pair(after, b.coordinate_sigma);
  });

  return designs;
}

}  // namespace slipstream
