#include "paper/gamma_experiment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "base/statistics.h"
#include "decode/phase_decoder.h"
#include "paper/board_experiment.h"
#include "paper/cloud_views.h"
#include "paper/curve_fit.h"
#include "paper/formulas.h"
#include "reconstruct/phase_matcher.h"
#include "reconstruct/pipeline.h"
#include "response/correction.h"
#include "response/gamma_calibration.h"
#include "response/harmonics.h"
#include "response/response_fit.h"
#include "slipstream/gamma.h"
#include "slipstream/named_scenes.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/virtual_world.h"

namespace slipstream {
namespace {

using Parameters = std::vector<std::pair<std::string, double>>;

constexpr Size camera{320, 240};

/// Printed results for one N; the textured object with calibration only for N = 3.
struct Published {
  int steps;
  double gamma;
  double ambient;  ///< grey levels: none for N = 3, as in the paper
  double before;
  std::optional<double> calibrated;
  double blind;
};

const std::array<Published, 3> published_board{{{3, 2.21, 0, 0.0256, 4.2e-4, 7.5957e-4},
                                                {4, 4.42, 5, 0.0152, {}, 3.4803e-4},
                                                {5, 7.73, 5, 0.0123, {}, 3.1519e-4}}};

std::optional<double> gain_of(std::optional<double> before, std::optional<double> after) {
  if (!before || !after) return std::nullopt;
  return *before / *after;
}

PhaseCorrections correction_for(int steps, double gamma) {
  return {{steps, phase_correction(PowerLaw{gamma}, steps)}};
}

/// Errors in the middle row, over the column.
PlotLine middle_row(std::string label, const Image<double>& errors) {
  PlotLine line{std::move(label)};
  for (int column = 0; column < errors.width(); ++column) {
    line.add(column, errors(column, errors.height() / 2));
  }
  return line;
}

/// Middle row of a surface, from above.
PlotLine middle_row_from_above(std::string label, const Cloud& surface) {
  const float* x = surface.x.row(surface.size().height / 2);
  const float* z = surface.z.row(surface.size().height / 2);
  const int width = surface.size().width;
  return {std::move(label), {x, x + width}, {z, z + width}};
}

/// Plots the surface from the front, before and after correction, and from above.
void add_surface_plots(const BoardExperiment& board, const Image<double>& measured,
                       const Image<double>& corrected, const std::string& how,
                       const std::string& figure, Reproduction& result) {
  const Cloud before = board.surface(measured), after = board.surface(corrected);
  result.draw(figure + "-above", "Middle row of the surface from above", "X, mm", "Z, mm",
              PlotScale::linear,
              {middle_row_from_above("measured", before), middle_row_from_above(how, after)});
  for (const auto& [ending, surface] :
       {std::pair{"-uncorrected", before}, std::pair{"-corrected", after}}) {
    result.plots.push_back(
        {figure + ending, [surface = surface](const std::filesystem::path& file) {
           write_depth_preview(file, surface);
         }});
  }
}

/// Errors before correction, with the true gamma, and without calibration.
void add_correction_cells(const BoardExperiment& board, const Published& paper, bool textured,
                          Reproduction& result) {
  const auto& [steps, gamma, ambient, before_printed, calibrated_printed, blind_printed] = paper;
  const FrameSet frames = board.averaged(steps, gamma, ambient);
  const Image<MeasuredHarmonics> pixels = pixel_harmonics(frames, 0, steps);
  const Image<std::uint8_t> lit = well_lit(pixels, frames);
  const BlindGamma found = find_gamma(pixels, lit, steps);

  const Image<double> measured = BoardExperiment::phase(frames, {});
  const Image<double> calibrated = BoardExperiment::phase(frames, correction_for(steps, gamma));
  const Image<double> blind =
      found.accepted() ? BoardExperiment::phase(frames, correction_for(steps, found.gamma))
                       : measured;
  const double before = board.rms_error(measured, lit);
  const double with_gamma = board.rms_error(calibrated, lit);
  const double without = board.rms_error(blind, lit);

  const Parameters parameters{
      {"N", double(steps)}, {"gamma", gamma}, {"textured", double(textured)}};
  const auto printed = [&](std::optional<double> value) { return textured ? std::nullopt : value; };
  const auto add = [&](const char* quantity, std::optional<double> paper_says, double ours) {
    result.add(quantity, parameters, paper_says, ours);
  };
  const bool paper_fish = textured && steps == 3;
  add("RMS error before, rad / f", printed(before_printed), before);
  add("RMS error after, gamma known, rad / f",
      paper_fish ? std::optional(4.9e-4) : printed(calibrated_printed), with_gamma);
  add("times smaller, gamma known", printed(gain_of(before_printed, calibrated_printed)),
      before / with_gamma);
  add("RMS error after, without calibration, rad / f", printed(blind_printed), without);
  add("times smaller, without calibration", printed(gain_of(before_printed, blind_printed)),
      before / without);
  add("gamma found without calibration", {}, found.gamma);
  if (!found.accepted()) {
    result.notes.push_back(
        fmt::format("N = {}: blind correction refused: {}", steps, reason_of(found.refusal)));
  }
  if (steps == 3) {
    add_surface_plots(board, measured, calibrated, "gamma known",
                      textured ? "figure-4.17" : "figure-4.16", result);
  }
}

constexpr const char* conditions =
    "The virtual scanner, 8-bit frames, sigma_w^2 = 1.55, averaged over 48 scans, f = 8; all lit "
    "pixels, while the paper has one row of a real board.";

BoardExperiment experiment(bool fish, std::uint64_t seed) {
  return BoardExperiment(
      camera, fish ? BoardExperiment::Surface::fish : BoardExperiment::Surface::white, seed);
}

/// Figures 4.16 and 4.17, with calibration.
Reproduction with_calibration(bool fish, std::uint64_t seed) {
  Reproduction result;
  add_correction_cells(experiment(fish, seed), published_board[0], fish, result);
  result.notes.emplace_back(conditions);
  return result;
}

/// Figure 4.12: the mean of one scan of each object.
Reproduction figure_412(std::uint64_t seed) {
  std::vector<Image<std::uint8_t>> photographs;
  for (const bool fish : {false, true}) {
    const FrameSet frames = experiment(fish, seed).once(3, 1, 5);
    photographs.push_back(as_picture(weighted_sum(frames, mean_weights(3))));
  }
  Reproduction result;
  result.draw_picture("figure-4.12", side_by_side(photographs, 2));
  result.notes.emplace_back("The virtual board and fish.");
  return result;
}

/// Figure 4.13: surfaces from 48 steps, from the front and from above.
Reproduction figure_413(std::uint64_t seed) {
  constexpr int steps = 48;
  Reproduction result;
  for (const bool fish : {false, true}) {
    const BoardExperiment board = experiment(fish, seed);
    const FrameSet frames = board.averaged(steps, 2.21, 5, 1);
    const Image<double> phase = BoardExperiment::phase(frames, {});
    const Cloud surface = board.surface(phase);
    result.add("RMS phase error, rad / f", {{"N", steps}, {"fish", double(fish)}}, {},
               board.rms_error(phase, well_lit(pixel_harmonics(frames, 0, steps), frames)));
    const std::string name = fish ? "figure-4.13-fish" : "figure-4.13-board";
    result.draw(name + "-above", "Middle row of the surface from above", "X, mm", "Z, mm",
                PlotScale::linear, {middle_row_from_above("48 steps", surface)});
    result.plots.push_back({name, [surface](const std::filesystem::path& file) {
                              write_depth_preview(file, surface);
                            }});
  }
  result.notes.emplace_back("f = 8, where the print has 16.");
  return result;
}

/// The traditional calibration of gamma at the middle of the board: a curve through 160 grey
/// levels. Also the error of the phase corrected by it, and by the gamma of the print's curve.
void add_curve_fit(const BoardExperiment& board, Reproduction& result) {
  constexpr int levels = 160;
  constexpr double ambient = 5, printed_fit = 2.153;
  const auto& [steps, gamma, no_ambient, before, calibrated, blind] = published_board[0];

  // Mean of the 5 x 5 pixels in the middle of the picture.
  const FrameSet shown = board.grey_levels(levels, gamma, ambient);
  std::vector<double> grey(levels), share(levels);
  for (int n = 0; n < levels; ++n) {
    std::vector<double> weights(levels);
    weights[n] = 1;
    const Image<double> frame = weighted_sum(shown, weights);
    for (int row = -2; row <= 2; ++row) {
      for (int column = -2; column <= 2; ++column) {
        grey[n] += frame(camera.width / 2 + column, camera.height / 2 + row) / 25;
      }
    }
    share[n] = static_cast<double>(n) / (levels - 1);
  }
  const FittedGamma fit = fit_gamma(share, grey);

  const FrameSet frames = board.averaged(steps, gamma, no_ambient);
  const Image<std::uint8_t> lit = well_lit(pixel_harmonics(frames, 0, steps), frames);
  const Parameters parameters{{"N", double(steps)}, {"gamma", gamma}};
  result.add("gamma by a curve fit at one place", parameters, printed_fit, fit.gamma);
  result.add("RMS error after, gamma of the printed fit, rad / f", parameters, 1.1e-3,
             board.rms_error(frames, correction_for(steps, printed_fit), lit));
  result.add("RMS error after, gamma of our fit, rad / f", parameters, {},
             board.rms_error(frames, correction_for(steps, fit.gamma), lit));

  PlotLine measured{"measured"}, curve{fmt::format("gamma {:.3f}", fit.gamma)};
  for (int n = 0; n < levels; ++n) {
    measured.add(255 * share[n], grey[n]);
    curve.add(255 * share[n], fit.at(share[n]));
  }
  result.draw("figure-4.14-fit", "Best-fit curve at the middle of the board",
              "projected grey level", "grey level", PlotScale::linear, {measured, curve});
}

/// Figures 4.18 to 4.26, without calibration: errors in the middle row, or the surface.
struct BlindFigure {
  const char* id;
  std::size_t paper;  ///< in published_board
  enum { errors, board, fish } shows;
};
constexpr std::array<BlindFigure, 9> blind_figures{{{"4.18", 0, BlindFigure::errors},
                                                    {"4.19", 0, BlindFigure::board},
                                                    {"4.20", 0, BlindFigure::fish},
                                                    {"4.21", 1, BlindFigure::errors},
                                                    {"4.22", 1, BlindFigure::board},
                                                    {"4.23", 1, BlindFigure::fish},
                                                    {"4.24", 2, BlindFigure::errors},
                                                    {"4.25", 2, BlindFigure::board},
                                                    {"4.26", 2, BlindFigure::fish}}};

Reproduction without_calibration(const BlindFigure& figure, std::uint64_t seed) {
  const auto& [steps, gamma, ambient, before_printed, calibrated_printed, blind_printed] =
      published_board.at(figure.paper);
  const bool fish = figure.shows == BlindFigure::fish;
  const BoardExperiment board(
      camera, fish ? BoardExperiment::Surface::fish : BoardExperiment::Surface::white, seed);
  const FrameSet frames = board.averaged(steps, gamma, ambient);
  const Image<MeasuredHarmonics> pixels = pixel_harmonics(frames, 0, steps);
  const Image<std::uint8_t> lit = well_lit(pixels, frames);
  const double found = find_gamma(pixels, lit, steps).gamma;
  const Image<double> measured = BoardExperiment::phase(frames, {});
  const Image<double> blind = BoardExperiment::phase(frames, correction_for(steps, found));
  const Parameters parameters{{"N", double(steps)}, {"gamma", gamma}};
  const auto printed = [&](double value) { return fish ? std::nullopt : std::optional(value); };
  Reproduction result;
  result.add("RMS error before, rad / f", parameters, printed(before_printed),
             board.rms_error(measured, lit));
  result.add("RMS error after, without calibration, rad / f", parameters, printed(blind_printed),
             board.rms_error(blind, lit));
  const std::string name = fmt::format("figure-{}", figure.id);
  if (figure.shows != BlindFigure::errors) {
    add_surface_plots(board, measured, blind, "without calibration", name, result);
    if (fish) result.notes.emplace_back("A virtual fish in relief; the print gives no numbers.");
    return result;
  }
  const Image<double> known = BoardExperiment::phase(frames, correction_for(steps, gamma));
  result.draw(
      name, fmt::format("Error of the middle row, N = {}, gamma = {}", steps, gamma), "column",
      "rad / f", PlotScale::linear,
      {middle_row("measured", board.error(measured)), middle_row("gamma known", board.error(known)),
       middle_row("without calibration", board.error(blind))});
  return result;
}

/// Gamma of the projector from 20 steps, on this board.
GammaEstimate calibrated_gamma(const BoardExperiment& board, double gamma, Reproduction* plots) {
  constexpr int steps = 20;
  const FrameSet frames = board.averaged(steps, gamma, 5, 12);
  const Image<MeasuredHarmonics> pixels = pixel_harmonics(frames, 0, steps);
  const Image<double> map = gamma_map(pixels, well_lit(pixels, frames));
  const GammaEstimate estimate = robust_gamma(map);
  if (plots != nullptr) {
    const double reach = 5 * estimate.spread;
    const Histogram counted = histogram(map, estimate.gamma - reach, estimate.gamma + reach, 60);
    plots->draw("figure-4.14", BarPlot{"Gamma of every pixel",
                                       "gamma",
                                       "pixels",
                                       counted.low,
                                       counted.high,
                                       {counted.counts.begin(), counted.counts.end()}});
  }
  return estimate;
}

Reproduction figure_414(std::uint64_t seed) {
  const BoardExperiment board = experiment(false, seed);
  Reproduction result;
  add_curve_fit(board, result);
  const GammaEstimate estimate = calibrated_gamma(board, 2.21, &result);
  result.add("gamma calibrated on the white board", {{"gamma", 2.21}}, 2.2123, estimate.gamma);
  result.add("variance of gamma over the pixels", {{"gamma", 2.21}}, 2.67e-4,
             estimate.spread * estimate.spread);
  result.notes.emplace_back(
      "Every virtual pixel has the same gamma, so a fit at one place finds it; the printed fit "
      "misses the mean of the picture by 0.06.");
  return result;
}

Reproduction figure_415(std::uint64_t seed) {
  const BoardExperiment board = experiment(false, seed);
  const auto& [steps, gamma, ambient, before, calibrated, blind] = published_board[0];
  const FrameSet frames = board.averaged(steps, gamma, ambient);
  const Image<std::uint8_t> lit = well_lit(pixel_harmonics(frames, 0, steps), frames);
  const Image<double> measured = BoardExperiment::phase(frames, {});
  const Image<double> known = BoardExperiment::phase(frames, correction_for(steps, gamma));
  const Parameters parameters{{"N", double(steps)}, {"gamma", gamma}};
  Reproduction result;
  result.add("RMS error before, rad / f", parameters, before, board.rms_error(measured, lit));
  result.add("RMS error after, gamma known, rad / f", parameters, calibrated,
             board.rms_error(known, lit));
  result.draw("figure-4.15", "Error of the middle row, N = 3, gamma = 2.21", "column", "rad / f",
              PlotScale::linear,
              {middle_row("measured", board.error(measured)),
               middle_row("gamma known", board.error(known))});
  result.notes.emplace_back(conditions);
  return result;
}

Reproduction section_45(std::uint64_t seed) {
  const BoardExperiment white = experiment(false, seed), textured = experiment(true, seed);
  Reproduction result;
  for (const Published& paper : published_board) add_correction_cells(white, paper, false, result);
  for (const Published& paper : published_board) {
    add_correction_cells(textured, paper, true, result);
  }
  for (const double gamma : {2.21, 4.42, 7.73}) {
    const bool first = gamma == 2.21;
    const double on_white = calibrated_gamma(white, gamma, first ? &result : nullptr).gamma;
    const double on_texture = calibrated_gamma(textured, gamma, nullptr).gamma;
    const auto published = [&](double gamma_there) {
      return first ? std::optional(gamma_there) : std::nullopt;
    };
    result.add("gamma calibrated on the white board", {{"gamma", gamma}}, published(2.2123),
               on_white);
    result.add("gamma calibrated on the textured object", {{"gamma", gamma}}, published(2.2079),
               on_texture);
  }
  add_curve_fit(white, result);
  // Common alternatives to phase correction, on the white board.
  const Parameters parameters{{"gamma", 2.21}};
  const FrameSet six = white.averaged(6, 2.21, 5);
  const Image<std::uint8_t> lit = well_lit(pixel_harmonics(six, 0, 6), six);
  result.add("RMS error, double three-step (6 frames), rad / f", parameters, {},
             white.rms_error(double_three_step_phase(six, 0), lit));
  result.add("RMS error, 6 steps (6 frames), rad / f", parameters, {},
             white.rms_error(six, {}, lit));
  const FrameSet inverse = white.precompensated(3, 2.21, 5, PowerLaw{2.21});
  result.add("RMS error, 3 precompensated 8-bit patterns, rad / f", parameters, {},
             white.rms_error(inverse, {}, lit));
  result.notes.emplace_back(conditions);
  return result;
}

template <class Real>
Image<double> depth_errors(const BasicCloud<Real>& cloud, const Image<double>& depth) {
  Image<double> errors(depth.size());
  std::transform(cloud.z.begin(), cloud.z.end(), depth.begin(), errors.begin(),
                 [](double z, double truth) { return z - truth; });
  return errors;
}

template <class Real>
double rms_depth_error(const BasicCloud<Real>& cloud, const Image<double>& depth) {
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < depth.pixel_count(); ++i) {
    const double error = cloud.z.begin()[i] - depth.begin()[i];
    if (!std::isfinite(error)) continue;
    sum += error * error;
    ++count;
  }
  return std::sqrt(sum / count);
}

Reproduction section_44(std::uint64_t seed) {
  const Scanner first = example_scanner(), second = second_scanner(first);
  const Scene board = scene_named("board", first);
  const Sequence sequence{.strategy =
                              DualFrequency{.steps = 3, .low_steps = 6, .high = 32, .low = 1}};
  const PatternSet patterns = pattern_set(sequence);
  const VirtualScan first_scan = take_scan(first, board, patterns);
  const VirtualScan second_scan =
      take_scan(second, seen_from_second(board, first, second), patterns);
  PhaseMatcher match(first, second, sequence);
  const ReferenceEngine one_camera({.scanner = first, .sequence = sequence}, {});
  Reproduction result;
  std::vector<PlotLine> lines;
  std::array<double, 2> matched{};
  std::size_t i = 0;
  for (const double gamma : {1.0, 2.2}) {
    const Photometry light{
        .ambient = 5, .response = PowerLaw{gamma}, .noise_variance = 1.55, .seed = seed};
    Photometry other = light;
    other.seed = ~seed;
    const FrameSet frames = take_again(first_scan, patterns, light);
    const auto both = match(frames, take_again(second_scan, patterns, other)).cloud;
    matched.at(i) = rms_depth_error(both, first_scan.depth);
    const Parameters parameters{{"N", 3}, {"gamma", gamma}};
    const BasicCloud<double> alone = one_camera(frames).cloud;
    result.add("RMS depth error, two cameras, mm", parameters, {}, matched.at(i));
    result.add("RMS depth error, one camera, mm", parameters, {},
               rms_depth_error(alone, first_scan.depth));
    lines.push_back(middle_row(fmt::format("one camera, gamma {}", gamma),
                               depth_errors(alone, first_scan.depth)));
    lines.push_back(middle_row(fmt::format("two cameras, gamma {}", gamma),
                               depth_errors(both, first_scan.depth)));
    ++i;
  }
  result.draw("figure-4.11", "Depth error of the middle row", "column", "mm", PlotScale::linear,
              std::move(lines));
  result.add("two cameras, gamma 2.2 over gamma 1", {{"N", 3}}, {}, matched[1] / matched[0]);
  result.notes.emplace_back(
      "The virtual board, 640x480, dual-frequency with f = 32 (3 steps) and 1 (6 steps), one scan; "
      "depth from planes of 11 x 11 pixels. The paper gives no number.");
  return result;
}

}  // namespace

std::vector<Reproducible> gamma_experiment_reproducibles() {
  std::vector<Reproducible> all{
      {"section", "4.4", "phase matching between two cameras", section_44},
      {"figure", "4.11", "phase matching between two cameras", section_44},
      {"section", "4.5", "experiments with and without calibration", section_45},
      {"figure", "4.12", "the board and the fish", figure_412},
      {"figure", "4.13", "surfaces from 48 steps", figure_413},
      {"figure", "4.14", "gamma by a curve fit, and of every pixel", figure_414},
      {"figure", "4.15", "phase error with calibration", figure_415},
      {"figure", "4.16", "the board with calibration",
       [](std::uint64_t seed) { return with_calibration(false, seed); }},
      {"figure", "4.17", "the fish with calibration",
       [](std::uint64_t seed) { return with_calibration(true, seed); }}};
  for (const BlindFigure& figure : blind_figures) {
    const char* const title = figure.shows == BlindFigure::errors
                                  ? "phase error without calibration"
                                  : "a surface without calibration";
    all.push_back({"figure", figure.id, title,
                   [figure](std::uint64_t seed) { return without_calibration(figure, seed); }});
  }
  return all;
}

}  // namespace slipstream
