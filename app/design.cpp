#include "slipstream/codes/design.h"

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "app/commands.h"
#include "slipstream/base/error.h"
#include "slipstream/codes/motion_window.h"
#include "slipstream/codes/predicted_variance.h"
#include "slipstream/codes/registry.h"
#include "slipstream/io/plot.h"
#include "slipstream/io/scanner_file.h"

namespace slipstream::app {
namespace {

struct DesignFlags {
  DesignGoal goal;
  std::optional<int> frames;
  std::optional<double> coordinate_noise;
  std::optional<double> phase_speed;
  std::optional<double> ambient;
  std::optional<double> noise_variance;
  std::optional<std::string> scanner;
  std::string plot;
};

/// Light and noise: the flags', else the scanner file's.
DesignGoal goal_from(const DesignFlags& flags) {
  DesignGoal goal = flags.goal;
  PhotometricCalibration known;
  if (flags.scanner) known = read_photometric_calibration(*flags.scanner);
  const std::optional<double> noise =
      flags.noise_variance ? flags.noise_variance : known.noise_variance;
  if (!noise) {
    throw Error("no noise variance; give --noise-variance, or a scanner file that holds it");
  }
  goal.noise_variance = *noise;
  goal.ambient = flags.ambient.value_or(known.ambient.value_or(0));
  return goal;
}

Plot plot_of(const DesignGoal& goal, const std::vector<Design>& designs) {
  PlotLine noise{fmt::format("PCMP, {} % unwrapped", 100 * goal.success)};
  PlotLine unit{"PMP of unit frequency"};
  for (const Design& design : designs) {
    noise.add(design.strategy.f_h(), design.coordinate_sigma);
    unit.add(
        design.strategy.f_h(),
        std::sqrt(coordinate_variance(
            phase_variance(goal.steps, goal.alpha, design.light.alpha_p, goal.noise_variance), 1)));
  }
  return LinePlot{fmt::format("Noise of the coordinate, {} steps", goal.steps),
                  "f_h",
                  "standard deviation of y",
                  PlotScale::logarithmic,
                  {std::move(noise), std::move(unit)}};
}

/// Strategies of every kind, side by side.
void compare_designs(const DesignFlags& flags, const DesignGoal& goal, Output& output) {
  StrategyGoal wanted{.coordinate_sigma = flags.coordinate_noise,
                      .alpha = goal.alpha,
                      .noise_variance = goal.noise_variance,
                      .success = goal.success,
                      .most_periods = goal.most_periods};
  wanted.frames = flags.frames.value_or(24);
  const std::vector<StrategyDesign> designs = strategy_designs(wanted);
  if (designs.empty()) {
    throw Error(
        fmt::format("no strategy of at most {} frames and {} periods does that; allow more "
                    "of either, or more noise",
                    wanted.frames, wanted.most_periods));
  }
  output.say("frames | noise of y | right orders | strategy");
  for (const auto& [strategy, success, sigma] : designs) {
    output.say("{:6} | {:10.3g} | {:10.4f} % | {}", frame_count(strategy), sigma, 100 * success,
               label_of(strategy));
    output.list("strategies")
        .push_back({{"strategy", label_of(strategy)},
                    {"frames", frame_count(strategy)},
                    {"success", success},
                    {"coordinate_sigma", sigma}});
  }
}

/// What frames beyond a cycle do where things move.
void tell_motion(int steps, double speed, Output& output) {
  require_valid(Sinusoid{steps, 1}, "--steps");
  if (!(std::abs(speed) <= 1.5)) {
    throw Error(fmt::format("--phase-speed {} is out of range; -1.5 to 1.5 rad", speed));
  }
  const Layout cycle{.frames = steps, .bands = {phase_shifted_band(steps, 0, steps, 1)}};
  const double noise = component_noise(cycle.bands.front());
  output.say("motion | frames | ripple, rad | noise over that of a cycle");
  for (const int extra : {0, 1, 2, 3, 4, 6, 8}) {
    const double ripple = motion_ripple(cycle, extra, speed);
    const double ratio =
        std::sqrt(component_noise(motion_window(cycle, extra).bands.front()) / noise);
    output.say("{:6} | {:6} | {:11.3g} | {:.2f}", extra, steps + extra, ripple, ratio);
    output.list("motion").push_back(
        {{"motion", extra}, {"frames", steps + extra}, {"ripple_rad", ripple}, {"noise", ratio}});
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
      "at alpha = {}: standard deviation of y {:.3g}, {:.1f} times less than {}-step pmp of "
      "unit frequency; {:.2f} % of the pixels unwrapped each by itself",
      goal.alpha, sigma, strategy.c1() * strategy.f_h(), strategy.steps, 100 * success);
  output.say(
      "slipstream patterns FOLDER --strategy pcmp --steps {} --high {} --share {:.2f} "
      "--alpha-p {} --beta-p {}",
      strategy.steps, strategy.f_h(), strategy.c1(), light.alpha_p, light.beta_p);
  output.document = {{"steps", strategy.steps},   {"high", strategy.f_h()},
                     {"share", strategy.c1()},    {"alpha_p", light.alpha_p},
                     {"beta_p", light.beta_p},    {"success", success},
                     {"coordinate_sigma", sigma}, {"gain", strategy.c1() * strategy.f_h()}};
  if (!flags.plot.empty()) {
    write_plot(flags.plot, plot_of(goal, designs_by_frequency(goal)));
    output.document["plot"] = flags.plot;
    output.say("plot: {}", flags.plot);
  }
}

}  // namespace

void add_design(CLI::App& program, Command& chosen) {
  const auto [command, flags] =
      add_command(program, chosen, design, "design",
                  "patterns of least noise for a given light, noise and surface");
  CLI::Option* const frames = command.add("--frames", flags.frames,
                                          "compare strategies of every kind with at most so many");
  CLI::Option* const noise =
      command.add("--coordinate-noise", flags.coordinate_noise,
                  "compare those of fewest frames that reach it: standard deviation of y, fields");
  command.add("--steps", flags.goal.steps, "of pcmp, 3 or more; with --phase-speed of pmp")
      ->excludes(frames)
      ->excludes(noise);
  command.add("--least-reflectivity", flags.goal.alpha, "the least that is to be measured");
  command.add("--ambient", flags.ambient, "grey levels of 255, where not that of the scanner file")
      ->default_str("0");
  command.add("--noise-variance", flags.noise_variance, "sigma_w^2, grey levels^2 of 255");
  command.add_file("--scanner", flags.scanner, "scanner file that says both");
  command.add("--success", flags.goal.success,
              "share of the pixels to be unwrapped rightly each by itself");
  command.add("--most-periods", flags.goal.most_periods, "largest f_h to be considered");
  command.add_output("--plot", flags.plot, "noise over f_h: .png")
      ->excludes(frames)
      ->excludes(noise);
  CLI::Option* const speed =
      command.add("--phase-speed", flags.phase_speed,
                  "things that move: rad that the phase of --steps moves from frame to frame");
  for (const char* flag :
       {"--frames", "--coordinate-noise", "--least-reflectivity", "--ambient", "--noise-variance",
        "--scanner", "--success", "--most-periods", "--plot"}) {
    speed->excludes(command.app.get_option(flag));
  }
  command.app.footer(
      "Example:\n  slipstream design --steps 4 --noise-variance 1.55 --ambient -7 "
      "--least-reflectivity 0.3 --plot design.png");
}

}  // namespace slipstream::app
