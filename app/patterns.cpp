#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "app/commands.h"
#include "app/scan_flags.h"
#include "codes/design.h"
#include "codes/motion_window.h"
#include "codes/predicted_variance.h"
#include "io/pattern_pictures.h"
#include "io/plot.h"
#include "response/correction.h"
#include "slipstream/layout.h"
#include "slipstream/strategy.h"

namespace slipstream::app {
namespace {

struct DesignFlags {
  DesignGoal goal;
  std::optional<int> frames;
  std::optional<double> coordinate_noise, phase_speed, ambient, noise_variance;
  std::optional<std::string> scanner;
  std::string plot;
};

/// Light and noise from flags, or else from the scanner file.
DesignGoal goal_from(const DesignFlags& flags) {
  DesignGoal goal = flags.goal;
  PhotometricCalibration known;
  if (flags.scanner) known = read_photometric_calibration(*flags.scanner);

  const auto noise = flags.noise_variance ? flags.noise_variance : known.noise_variance;
  throw_if(!noise.has_value(),
           "no noise variance; give --noise-variance or a scanner file that contains it");

  goal.noise_variance = *noise;
  goal.ambient = flags.ambient.value_or(known.ambient.value_or(0));
  return goal;
}

LinePlot plot_of(const DesignGoal& goal, const std::vector<Design>& designs) {
  PlotLine noise{fmt::format("PCMP, {} % unwrapped", 100 * goal.success)};
  PlotLine unit{"PMP of unit frequency"};

  for (const Design& design : designs) {
    noise.add(design.strategy.f_h(), design.coordinate_sigma);
    unit.add(
        design.strategy.f_h(),
        std::sqrt(coordinate_variance(
            phase_variance(goal.steps, goal.alpha, design.light.alpha_p, goal.noise_variance), 1)));
  }

  return {fmt::format("Noise of the coordinate, {} steps", goal.steps),
          "f_h",
          "standard deviation of y",
          PlotScale::logarithmic,
          {std::move(noise), std::move(unit)}};
}

void compare_designs(const DesignFlags& flags, const DesignGoal& goal, Output& output) {
  const StrategyGoal wanted{.frames = flags.frames.value_or(24),
                            .coordinate_sigma = flags.coordinate_noise,
                            .alpha = goal.alpha,
                            .noise_variance = goal.noise_variance,
                            .success = goal.success,
                            .most_periods = goal.most_periods};

  const std::vector<StrategyDesign> designs = strategy_designs(wanted);
  throw_if(designs.empty(),
           "no strategy with at most {} frames and {} periods reaches that; allow more of either, "
           "or more noise",
           wanted.frames, wanted.most_periods);

  output.say("frames | noise of y | correct orders | strategy");
  for (const auto& [strategy, success, sigma] : designs) {
    output.say("{:6} | {:10.3g} | {:10.4f} % | {}", frame_count(strategy), sigma, 100 * success,
               label_of(strategy));
    output.add_to("strategies", "strategy", label_of(strategy), "frames", frame_count(strategy),
                  "success", success, "coordinate_sigma", sigma);
  }
}

/// Effect of extra frames for motion compensation.
void tell_motion(int steps, double speed, Output& output) {
  require_valid(Sinusoid{steps, 1}, "--steps");
  require_in_range(std::abs(speed) <= 1.5, "--phase-speed", speed, "-1.5 to 1.5 rad");

  // One cycle of phase shifting at f = 1; its noise is the measure of the others.
  const Layout cycle{.frames = steps, .bands = {phase_shifted_band(steps, 0, steps, 1)}};
  const double noise = component_noise(cycle.bands.front());

  output.say("motion | frames | ripple, rad | noise relative to one cycle");
  for (const int extra : {0, 1, 2, 3, 4, 6, 8}) {
    const double ripple = motion_ripple(cycle, extra, speed);
    const double ratio =
        std::sqrt(component_noise(motion_window(cycle, extra).bands.front()) / noise);
    output.say("{:6} | {:6} | {:11.3g} | {:.2f}", extra, steps + extra, ripple, ratio);
    output.add_to("motion", "motion", extra, "frames", steps + extra, "ripple_rad", ripple, "noise",
                  ratio);
  }
}

void design(const DesignFlags& flags, Output& output) {
  if (flags.phase_speed) return tell_motion(flags.goal.steps, *flags.phase_speed, output);
  const DesignGoal goal = goal_from(flags);
  if (flags.frames || flags.coordinate_noise) return compare_designs(flags, goal, output);

  const Design best = best_design(goal);
  const auto& [strategy, light, success, sigma] = best;
  output.say("pcmp, {} steps: f_h = {}, c_1 = {:.2f}, alpha_p = {}, beta_p = {}", strategy.steps,
             strategy.f_h(), strategy.c1(), light.alpha_p, light.beta_p);

  output.say(
      "at alpha = {}: standard deviation of y {:.3g}, {:.1f} times less than {}-step pmp of unit "
      "frequency; {:.2f} % of pixels unwrapped correctly on their own",
      goal.alpha, sigma, strategy.c1() * strategy.f_h(), strategy.steps, 100 * success);
  output.say(
      "slipstream patterns FOLDER --strategy pcmp --steps {} --high {} --share {:.2f} "
      "--alpha-p {} --beta-p {}",
      strategy.steps, strategy.f_h(), strategy.c1(), light.alpha_p, light.beta_p);

  output.document =
      described("steps", strategy.steps, "high", strategy.f_h(), "share", strategy.c1(), "alpha_p",
                light.alpha_p, "beta_p", light.beta_p, "success", success, "coordinate_sigma",
                sigma, "gain", strategy.c1() * strategy.f_h());

  if (!flags.plot.empty()) {
    write_plot(flags.plot, plot_of(goal, designs_by_frequency(goal)));
    output.document["plot"] = flags.plot;
    output.say("plot: {}", flags.plot);
  }
}

struct PatternsFlags {
  std::string folder;
  SequenceChanges scan;
  int bits = 8;
  std::optional<std::string> precompensate;
  int uniform = 0;
  std::string sheet;
  bool in_colour = false;
};

constexpr Size usual_projector{1920, 1080};

/// Uniform pictures of grey levels from 0 to 255, for `calibrate gamma --uniform`.
void write_uniform(const PatternsFlags& flags, Output& output) {
  require_in_range(flags.uniform >= 4 && flags.uniform <= 256, "--uniform", flags.uniform,
                   "4 to 256 pictures");

  const Size projector = flags.scan.projector.value_or(usual_projector);
  for (const fs::path& file : write_uniform_pictures(flags.folder, projector, flags.uniform)) {
    output.list("patterns").push_back(file.string());
  }

  output.say(
      "wrote {} uniform patterns to {}; photograph each, give the picture the same name, then run: "
      "slipstream calibrate gamma --uniform PICTURES",
      flags.uniform, flags.folder);
}

void write_patterns(const PatternsFlags& flags, Output& output) {
  if (flags.uniform != 0) return write_uniform(flags, output);
  const Sequence sequence = default_sequence(usual_projector, flags.scan);
  if (const std::string doubt = doubt_about(sequence); !doubt.empty()) output.warn(doubt);

  PatternSet patterns = pattern_set(sequence);
  if (flags.precompensate) {
    patterns = precompensated(patterns, response_named(*flags.precompensate, "--precompensate"));
  }
  const fs::path folder = flags.folder;

  if (!flags.sheet.empty()) {
    write_pattern_sheet(flags.sheet, patterns, length_along(sequence.axis, sequence.projector));
    output.document["sheet"] = flags.sheet;
  }

  tell_replaced(folder, output);
  Progress progress("patterns", flags.in_colour ? patterns.count / 3 : patterns.count);
  const auto advance = [&] { progress.advance(); };
  const std::vector<fs::path> pictures =
      flags.in_colour ? write_colour_patterns(folder, patterns, sequence, advance)
                      : slipstream::write_patterns(folder, patterns, sequence, flags.bits, advance);

  for (const fs::path& picture : pictures) output.list("patterns").push_back(picture.string());
  output.document["scan"] = (folder / "scan.yaml").string();

  output.say("wrote {} patterns of {} for a projector of {} to {}", pictures.size(),
             sequence.strategy.name(), text_of(sequence.projector), folder.string());
  output.say(
      "project them in this order, save the camera's pictures beside scan.yaml under the same "
      "names,\nthen run: slipstream reconstruct FOLDER --scanner SCANNER.yaml -o cloud.ply");
}

}  // namespace

void add_patterns(const Commands& program) {
  const auto [command, flags] = program.add(
      write_patterns, "patterns", "write a strategy's patterns as pictures for any projector");

  required(command.add_output("folder", flags.folder, "folder for the pictures and scan.yaml",
                              output_folder_type));

  add_pattern_flags(command.app, flags.scan, true);
  command.app.get_option("--projector")->default_str(text_of(usual_projector));

  command.add("--pattern-bits", flags.bits, "bit depth of the pictures, 8 to 16");
  command.add("--precompensate", flags.precompensate,
              "gamma, or a scanner file with one: apply its inverse, so that the projected light "
              "is linear");

  command.add("--colour", flags.in_colour,
              "put three patterns into each picture's red, green and blue; also write pictures for "
              "calibrate colour");

  command.add_output("--sheet", flags.sheet,
                     "also write one overview picture with a strip of each pattern: .png");

  command
      .add("--uniform", flags.uniform,
           "write this many uniform pictures from black to white instead, to measure gamma")
      ->default_str("");

  // Flags that do not go together.
  command.exclude("--binary", {"--pattern-bits", "--precompensate", "--colour", "--uniform"});
  command.exclude("--pattern-bits", {"--colour", "--uniform"});
  command.exclude("--uniform", {"--precompensate", "--sheet"});

  command.examples(
      {"patterns patterns --strategy dual-frequency --steps 3 --high 16 --low 1 --axis x "
       "--projector 1824x1140"});
}

void add_design(const Commands& program) {
  const auto [command, flags] = program.add(
      design, "design", "find the patterns with least noise for a given light, noise and surface");

  // All strategies, compared by frames and noise.
  command.add("--frames", flags.frames, "compare all strategies with at most this many frames");
  command.add("--coordinate-noise", flags.coordinate_noise,
              "compare the strategies that reach this standard deviation of y with fewest frames, "
              "field widths");

  // PCMP alone, optimised for light, noise and surface.
  command.add("--steps", flags.goal.steps, "frames of pcmp, 3 or more; with --phase-speed, of pmp");
  command.add("--least-reflectivity", flags.goal.alpha, "least reflectivity to measure, 0 to 1");
  command
      .add("--ambient-light", flags.ambient,
           "ambient light, grey levels of 255; default: from the scanner file")
      ->default_str("0");
  command.add("--noise-variance", flags.noise_variance,
              "noise variance sigma_w^2, squared grey levels of 255");
  command.add_file("--scanner", flags.scanner,
                   "scanner file with ambient light and noise variance");

  command.add("--success", flags.goal.success, "share of pixels to unwrap correctly on their own");
  command.add("--most-periods", flags.goal.most_periods, "largest f_h to consider");
  command.add_output("--plot", flags.plot, "plot of noise over f_h: .png");

  command.add("--phase-speed", flags.phase_speed,
              "for moving scenes: phase change from frame to frame, rad");

  // The modes exclude each other's flags.
  for (const char* compares : {"--frames", "--coordinate-noise"}) {
    command.exclude(compares, {"--steps", "--plot"});
  }
  command.exclude("--phase-speed",
                  {"--frames", "--coordinate-noise", "--least-reflectivity", "--ambient-light",
                   "--noise-variance", "--scanner", "--success", "--most-periods", "--plot"});

  command.examples(
      {"design --steps 4 --noise-variance 1.55 --ambient-light -7 --least-reflectivity 0.3 --plot "
       "design.png"});
}

}  // namespace slipstream::app
