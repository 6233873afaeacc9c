#include "paper/pcmp_figures.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "base/statistics.h"
#include "codes/predicted_variance.h"
#include "decode/cue_evidence.h"
#include "decode/decoder.h"
#include "decode/equations.h"
#include "decode/phase_decoder.h"
#include "paper/cloud_views.h"
#include "slipstream/named_scenes.h"
#include "slipstream/phase_channel_multiplexing.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"

namespace slipstream {
namespace {

constexpr double full_circle = 2 * std::numbers::pi;
constexpr PatternLight pcmp_light{.alpha_p = 200, .beta_p = 55};
constexpr double pcmp_ambient = -7;

/// Least reflectivity of a reliable pixel, Section 3.3.
constexpr double least_reflectivity = 0.15;

PhaseChannelMultiplexing pcmp_of(int steps, double c1, double high) {
  return {.steps = steps, .high = high, .share = c1, .reference = {}};
}

/// A scene under the virtual scanner that is scanned with one strategy after the other.
class ScannedThing {
 public:
  ScannedThing(const char* scene, std::uint64_t seed)
      : seed_(1000 * seed), scanner_(example_scanner({320, 240})) {
    Scene bodies = scene_named(scene, scanner_);
    if (bodies.front().shading == Shading::none) bodies.front().texture = uniform_texture(0.65);
    scan_ = take_scan(scanner_, bodies, pattern_set(PhaseMeasuring{3, 1}, Axis::x, pcmp_light));
  }

  /// Each call has its own noise; sigma_w^2 = 1.55 after rounding.
  [[nodiscard]] FrameSet frames(const Strategy& strategy) {
    const Photometry photometry{
        .ambient = pcmp_ambient, .noise_variance = 1.55 - quantisation_variance, .seed = ++seed_};
    return take_again(scan_, pattern_set(strategy, Axis::x, pcmp_light), photometry);
  }

  /// Coordinates by the rule of the dissertation; NaN where the reflectivity is below 0.15 or no
  /// light falls.
  [[nodiscard]] BasicMaps<double> maps(const Strategy& strategy, const FrameSet& frames,
                                       double share) const {
    const CueSettings cue{.light = pcmp_light, .ambient = pcmp_ambient, .rule = CueRule::published};
    BasicMaps<double> maps = Decoder(strategy.layout(), scanner_.projector.size.width,
                                     PhaseMethod::equation, {}, cue)(frames);
    for (std::size_t i = 0; i < maps.coordinate.pixel_count(); ++i) {
      const double alpha = 2 * maps.modulation.begin()[i] / (pcmp_light.alpha_p * share);
      const bool lit = !std::isnan(truth().begin()[i]) && alpha >= least_reflectivity;
      if (!lit) maps.coordinate.begin()[i] = std::nan("");
    }
    return maps;
  }

  [[nodiscard]] const Image<double>& truth() const { return scan_.coordinate; }
  [[nodiscard]] const Image<double>& depth() const { return scan_.depth; }
  [[nodiscard]] const Scanner& scanner() const { return scanner_; }

 private:
  std::uint64_t seed_;
  Scanner scanner_;
  VirtualScan scan_;
};

/// Coarse phase phi_u of every pixel from the reference signal, rad: by (3.58), (3.74) or, for five
/// steps, the phase of the second frequency. NaN outside the reference's range.
Image<double> coarse_phase(const PhaseChannelMultiplexing& pcmp, const FrameSet& frames,
                           const BasicMaps<double>& maps) {
  if (pcmp.steps == 5) {
    const Strategy strategy = pcmp;
    return PhaseDecoder(PhaseMethod::equation, {})(frames, strategy.layout().bands[1])
        .wrapped_phase;
  }
  const Image<double> channel =
      pcmp.steps == 3 ? maps.mean : weighted_sum(frames, half_phase_weights());
  Image<double> phase(channel.size());
  for (std::size_t i = 0; i < phase.pixel_count(); ++i) {
    const double B = maps.modulation.begin()[i], c = channel.begin()[i];
    if (pcmp.steps == 3) {
      // (3.58) with alpha alpha_p = 2 B / c_1, by (3.59).
      const double R = ((c - pcmp_ambient) * pcmp.c1() / B -
                        2 * (pcmp_light.beta_p + pcmp_ambient) / pcmp_light.alpha_p - 1) /
                       pcmp.c2();
      phase.begin()[i] = full_circle * (R + 1) / 2;
    } else {
      // (3.74), with R = cos(pi y).
      phase.begin()[i] = 2 * std::acos(c / B * pcmp.c1() / pcmp.c2());
    }
  }
  return phase;
}

/// The middle row of a map times `scale`; NaN where `lit` has none.
PlotLine row_of(std::string label, const Image<double>& map, const Image<double>& lit,
                double scale = 1) {
  PlotLine line{std::move(label)};
  const int row = map.height() / 2;
  for (int column = 0; column < map.width(); ++column) {
    const bool shown = !std::isnan(lit(column, row));
    line.add(column, shown ? scale * map(column, row) : std::nan(""));
  }
  return line;
}

/// Errors of a coordinate as a phase of one period, rad; NaN where it is wrong by half of one of
/// the `periods` or more, so unwrapped incorrectly.
Image<double> phase_errors(const Image<double>& coordinate, const Image<double>& truth,
                           double periods) {
  Image<double> errors(truth.size());
  for (std::size_t i = 0; i < truth.pixel_count(); ++i) {
    const double error = coordinate.begin()[i] - truth.begin()[i];
    const bool correct = std::abs(error) < 0.5 / periods;
    errors.begin()[i] = correct ? full_circle * error : std::nan("");
  }
  return errors;
}

double variance_of_errors(const Image<double>& errors) {
  double sum = 0, squares = 0, count = 0;
  for (const double error : finite_values(errors)) {
    sum += error;
    squares += error * error;
    ++count;
  }
  return squares / count - sum * sum / (count * count);
}

/// One N of Section 3.3, with the printed results of its first scan of the board.
struct PcmpExperiment {
  int steps;
  std::array<double, 3> shares;
  std::array<double, 3> frequencies;
  double unwrapped;      ///< % of the pixels
  double pmp_variance;   ///< of the phase error, rad^2
  double pcmp_variance;  ///< the same, by the printed ratio
};

const std::array<PcmpExperiment, 3> pcmp_experiments{
    {{3, {0.5, 0, 0}, {3, 0, 0}, 97.61, 2.43e-4, 1.13e-4},
     {4, {0.5, 0.6, 0.7}, {4, 6, 8}, 99.86, 1.80e-4, 1.80e-4 / 3.47},
     {5, {0.5, 0.6, 0.8}, {6, 8, 12}, 99.77, 1.53e-4, 1.53e-4 / 8.35}}};

const PcmpExperiment& experiment_of(int steps) {
  return pcmp_experiments.at(static_cast<std::size_t>(steps - 3));
}

/// Figures 3.16, 3.19 and 3.22.
Reproduction board_phases(const std::string& figure, int steps, std::uint64_t seed) {
  const PcmpExperiment& paper = experiment_of(steps);
  const double c1 = paper.shares[0], high = paper.frequencies[0];
  const PhaseChannelMultiplexing pcmp = pcmp_of(steps, c1, high);
  ScannedThing board("board", seed);
  const FrameSet frames = board.frames(pcmp);
  const BasicMaps<double> maps = board.maps(pcmp, frames, c1);

  Image<double> unwrapped = maps.coordinate;
  for (double& value : unwrapped) value *= full_circle * high;

  const auto lit = static_cast<double>(finite_values(maps.coordinate).size());
  const auto correct =
      static_cast<double>(finite_values(phase_errors(maps.coordinate, board.truth(), high)).size());
  Reproduction result;
  result.add("pixels unwrapped correctly, %", {{"N", steps}, {"c_1", c1}, {"f_h", high}},
             paper.unwrapped, 100 * correct / lit);
  result.draw(figure + "-row", "Phases of the middle row", "column", "rad", PlotScale::linear,
              {row_of("phi_h", maps.wrapped_phase, maps.coordinate),
               row_of("phi_u", coarse_phase(pcmp, frames, maps), maps.coordinate),
               row_of("unwrapped phi_h", unwrapped, maps.coordinate)});
  result.draw_map(figure, std::move(unwrapped), "rad");
  result.notes.emplace_back(
      "A virtual board of reflectivity 0.65 with noise alone, patterns along the rows; the print "
      "has them along the columns.");
  return result;
}

/// Figures 3.17, 3.20 and 3.23.
Reproduction board_errors(const std::string& figure, int steps, std::uint64_t seed) {
  const PcmpExperiment& paper = experiment_of(steps);
  const double c1 = paper.shares[0], high = paper.frequencies[0];
  const Strategy pmp = PhaseMeasuring{steps, 1}, pcmp = pcmp_of(steps, c1, high);
  ScannedThing board("board", seed);
  const auto errors_of = [&](const Strategy& strategy, double share, double periods) {
    const FrameSet frames = board.frames(strategy);
    return phase_errors(board.maps(strategy, frames, share).coordinate, board.truth(), periods);
  };
  const Image<double> by_pmp = errors_of(pmp, 1, 1), by_pcmp = errors_of(pcmp, c1, high);

  Reproduction result;
  result.add("variance of the phase error, PMP, rad^2", {{"N", steps}}, paper.pmp_variance,
             variance_of_errors(by_pmp));
  result.add("variance of the phase error, PCMP, rad^2", {{"N", steps}, {"c_1", c1}, {"f_h", high}},
             paper.pcmp_variance, variance_of_errors(by_pcmp));
  result.draw(figure, "Phase error of the middle row", "column", "rad", PlotScale::linear,
              {row_of("PMP", by_pmp, by_pmp), row_of("PCMP", by_pcmp, by_pcmp)});
  return result;
}

/// Figures 3.18, 3.21 and 3.24: PMP first, then PCMP with each c_1 and f_h.
Reproduction angel_views(const std::string& figure, int steps, std::uint64_t seed) {
  const PcmpExperiment& paper = experiment_of(steps);
  ScannedThing thing("angel", seed);
  Reproduction result;
  std::vector<Image<std::uint8_t>> front, side;
  const auto scan_with = [&](const Strategy& strategy, double share, double high) {
    const FrameSet frames = thing.frames(strategy);
    const BasicMaps<double> maps = thing.maps(strategy, frames, share);
    Image<double> texture = maps.modulation;
    for (double& value : texture) value /= share;
    const Cloud cloud = cloud_of(thing.scanner(), maps.coordinate, texture);
    front.push_back(seen_turned(cloud, 0, {240, 240}));
    side.push_back(seen_turned(cloud, 70, {240, 240}));
    const double error = median_depth_error(cloud, thing.depth());
    result.add("median depth error, mm", {{"N", steps}, {"c_1", share}, {"f_h", high}}, {}, error);
  };

  scan_with(PhaseMeasuring{steps, 1}, 1, 1);
  for (const double share : paper.shares) {
    for (const double high : paper.frequencies) {
      if (high > 0 && share > 0) scan_with(pcmp_of(steps, share, high), share, high);
    }
  }

  // Fig. 3.18 has front views above side views, the others only side views.
  if (steps == 3) {
    front.insert(front.end(), side.begin(), side.end());
    result.draw_picture(figure, side_by_side(front, 2));
  } else {
    result.draw_picture(figure, side_by_side(side, 5));
  }
  result.notes.emplace_back(
      "A virtual angel, sigma_w^2 = 1.55, by the published rule, turned by 70 degrees in side "
      "views; c_1 = 1 and f_h = 1 is PMP, the first picture. Pixels of a reflectivity below 0.15 "
      "are left out.");
  return result;
}

}  // namespace

std::vector<Reproducible> pcmp_figure_reproducibles() {
  std::vector<Reproducible> all;
  for (const int steps : {3, 4, 5}) {
    static constexpr std::array<std::array<const char*, 3>, 3> ids{
        {{"3.16", "3.17", "3.18"}, {"3.19", "3.20", "3.21"}, {"3.22", "3.23", "3.24"}}};
    const auto& [phases, errors, views] = ids.at(static_cast<std::size_t>(steps - 3));
    const auto run = [steps](const char* id, auto make) {
      return [=](std::uint64_t seed) { return make(fmt::format("figure-{}", id), steps, seed); };
    };
    all.push_back({"figure", phases, "phases of a board by PCMP", run(phases, board_phases)});
    all.push_back(
        {"figure", errors, "phase error of a board, PMP and PCMP", run(errors, board_errors)});
    all.push_back({"figure", views, "an angel by PMP and PCMP", run(views, angel_views)});
  }
  return all;
}

}  // namespace slipstream
