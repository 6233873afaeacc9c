// The mistakes that people make.
#include "check/possible_mistakes.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "base/numbers.h"
#include "check/frame_orders.h"
#include "check/geometric_mistakes.h"
#include "slipstream/error.h"
#include "slipstream/strategy.h"

namespace slipstream {
namespace {

constexpr int shift_family = -1, gamma_family = 1;

class Mistakes {
 public:
  Mistakes(const JudgedScan& scan, const Fit& as_given) : scan_(scan), as_given_(as_given) {
    const bool frames_fit = as_given.frames_fit();
    const Layout& layout = scan.model.layout();

    // 1. Mistakes that the frames show.
    if (!frames_fit) add_responses();

    add_measured_shifts();
    // Another origin or direction is likely where someone set one, or nothing else contradicts.
    const bool likely_shifts =
        shifts_configured() || !layout.single_frames.empty() || as_given.all();
    if (likely_shifts) add_usual_shifts();
    add_shifts_with_both_ends();

    if (const auto& code = layout.code) add_codes(*code);
    if (!layout.single_frames.empty()) add_signs();
    if (!periods_proven()) add_periods();
    add_orders();

    // 2. Mistakes of the scanner, if the frames are right.
    const std::size_t of_frames = list.size();
    if (scan.scanner != nullptr && frames_fit && !as_given.all()) {
      std::ranges::move(geometric_mistakes(*scan.scanner, scan.sequence), std::back_inserter(list));
    }
    if (scan.scanner != nullptr && frames_fit && is_off_centre(scan.scanner->camera)) add_crop();
    for (std::size_t i = of_frames; i < list.size(); ++i) list[i].geometric = true;

    // 3. Usual shifts that nothing makes likely are far-fetched.
    if (likely_shifts) return;
    const std::size_t others = list.size();
    add_usual_shifts();
    for (std::size_t i = others; i < list.size(); ++i) list[i].far_fetched = true;
  }

  std::vector<PossibleMistake> list{};

 private:
  /// A mistake that nothing undoes yet.
  PossibleMistake& add(CauseKind kind, std::string likely, std::vector<Remedy> remedies) {
    PossibleMistake mistake;
    mistake.cause = {kind, std::move(likely)};
    mistake.remedies = std::move(remedies);
    return list.emplace_back(std::move(mistake));
  }

  /// 0 if the strategy has no such setting.
  [[nodiscard]] SettingValue setting(const std::string& name) const {
    const StrategySettings& settings = scan_.sequence.strategy.settings();
    return settings.contains(name) ? settings.at(name) : SettingValue(0);
  }

  [[nodiscard]] double origin() const { return setting("origin").number(); }
  [[nodiscard]] bool is_on(const char* name) const { return setting(name) == SettingValue(true); }
  [[nodiscard]] bool shifts_configured() const { return origin() != 0 || is_on("backwards"); }

  /// Steps that contradict each other do so with any number of periods, though a known response
  /// does not show at the wrong place. Bands whose relation is constant have the right periods.
  [[nodiscard]] bool periods_proven() const {
    constexpr double least_agreement = 0.9;
    const double most_residual = scan_.photometry.response ? 0.25 : 0.15;
    const FrameEvidence& frames = as_given_.frames;

    const auto is_constant = [](const BandRelation& relation) {
      return relation.agreement >= least_agreement;
    };

    if (!scan_.model.layout().single_frames.empty()) return false;
    return frames.residual > most_residual ||
           (!frames.relations.empty() && std::ranges::all_of(frames.relations, is_constant));
  }

  void add_responses() {
    constexpr double most_residual = 0.4;  // of a gamma of 3 in eight steps
    if (as_given_.frames.residual > most_residual) return;

    if (scan_.photometry.response) {
      PossibleMistake& mistake = add(CauseKind::needless_response,
                                     "a response that is corrected but does not show in the frames",
                                     {try_setting("gamma", "none")});
      mistake.photometry = scan_.photometry;
      mistake.photometry->response.reset();
      mistake.severity = Severity::doubtful;
      return;
    }

    std::vector<Remedy> remedies{{"measure it with `calibrate_gamma()`"}};
    if (!scan_.settings.blind) remedies.push_back(try_setting("gamma", "blind"));

    for (double gamma = 0.5; gamma < 3.05; gamma += 0.1) {
      constexpr double least_off = 0.05;
      if (std::abs(gamma - 1) < least_off) continue;

      PossibleMistake& mistake = add(
          CauseKind::gamma,
          fmt::format("the projector's gamma (with the camera's, about {:.1f}) is not corrected",
                      gamma),
          remedies);
      mistake.photometry = scan_.photometry;
      mistake.photometry->response = {PowerLaw{gamma}, gamma, 0};
      mistake.family = gamma_family;
      mistake.severity = Severity::doubtful;
      mistake.approximate = true;
    }
  }

  void add_settings(const StrategySettings& changes, std::string likely, int family = 0) {
    const Strategy& strategy = scan_.sequence.strategy;
    StrategySettings settings = strategy.settings();

    // As a remedy.
    std::vector<SettingChange> changed;
    for (const auto& [name, value] : changes) {
      settings[name] = value;
      changed.push_back({name, value.text()});
    }
    if (changes.contains("shifts")) {  // they replace the numbers of steps
      settings.erase("steps");
      settings.erase("low_steps");
    }

    // The same settings may come up for several reasons: try them once.
    if (std::ranges::count(tried_, changed) > 0) return;
    tried_.push_back(changed);

    try {
      Sequence sequence = scan_.sequence;
      sequence.strategy = make_strategy(strategy.name(), settings);
      if (frame_count(sequence.strategy) != scan_.samples.frames()) return;

      PossibleMistake& mistake = add(CauseKind::pattern_settings, std::move(likely),
                                     {change_settings("try", std::move(changed))});
      mistake.sequence = std::move(sequence);
      mistake.family = family;
    } catch (const Error&) {
      return;  // the strategy does not allow them
    }
  }

  void add_shift(double shift, bool backwards, bool measured = true) {
    // To (-pi, pi].
    shift = std::remainder(shift, two_pi) + 0.0;  // not -0
    if (shift < 1e-3 - two_pi / 2) shift += two_pi;

    StrategySettings changes;
    std::string likely;
    if (std::abs(std::remainder(shift - origin(), two_pi)) > 1e-3) {
      changes["origin"] = fmt::format("{:.5g}", shift);
      likely = fmt::format("patterns whose phase origin is {:.5g}{}", shift,
                           measured ? "" : ", or near that");
    }

    if (backwards != is_on("backwards")) {
      changes["backwards"] = backwards;
      likely += (likely.empty() ? "patterns" : " and") +
                std::string(" whose phases shift in the other direction");
    }

    if (!changes.empty()) add_settings(changes, std::move(likely), shift_family);
  }

  /// Adds an origin that people set if the measured one is near it: a step of the shifts, or a
  /// quarter of a period. Others would be as inexact as they were measured.
  void add_near(double measured, double tolerance, bool backwards) {
    std::vector<int> parts{4};
    for (const StepRun& run : step_runs(scan_.model.layout())) parts.push_back(run.steps);

    for (const int count : parts) {
      const double part = two_pi / count, near = part * std::round(measured / part);
      if (std::abs(measured - near) < tolerance) add_shift(near, backwards);
    }
  }

  /// The origin and direction that the frames give.
  void add_measured_shifts() {
    const CodeEvidence& code = as_given_.code;
    const bool against = code.against > 0.5;
    const double measured = (against ? -1 : 1) * origin() + two_pi * code.offset;

    // 1. By the code's edges, which blur moves.
    // An offset that changes along the field is not one of the origin.
    constexpr double by_edges = 0.1;
    if (std::abs(code.drift) < CodeEvidence::least_drift) {
      add_near(measured, by_edges, is_on("backwards") != against);
    }

    // 2. By the relations of the bands, up to whole periods.
    // An error of the origin moves a relation by the ratio of the bands' periods less 1: the
    // coarsest relation whatever the error, others if the coarser orders are right.
    const std::vector<std::size_t>& chain = scan_.model.bands();
    const std::vector<Band>& bands = scan_.model.layout().bands;

    double below = scan_.model.has_real_cue() ? 0 : bands[chain.front()].periods;
    std::size_t next = below > 0 ? 1 : 0;
    for (const BandRelation& relation : as_given_.frames.relations) {
      const double periods = bands[chain[next++]].periods;
      const double gain = below > 0 ? periods / below - 1 : -1;
      below = periods;

      // The relation is known modulo 1: try each whole number that keeps the origin within a turn.
      const int most = static_cast<int>(std::ceil(std::abs(gain) / 2));
      for (int k = -most; k <= most; ++k) {
        constexpr double by_relations = 0.02;
        add_near(origin() + two_pi * (relation.offset + k) / gain, by_relations,
                 is_on("backwards"));
      }
    }
  }

  /// Quarters of a period; finer parts of it only if an origin or direction was configured and no
  /// relation gives it.
  void add_usual_shifts() {
    const bool configured = is_on("backwards");
    const int parts = shifts_configured() && as_given_.frames.relations.empty() ? 12 : 4;

    for (int i = 0; i < parts; ++i) {
      for (const bool backwards : {configured, !configured})
        add_shift(i * two_pi / parts, backwards, false);
    }
  }

  /// N shifts from 0 to a whole period, both ends counted: the last frame is the first one again.
  void add_shifts_with_both_ends() {
    std::vector<double> of_bands;
    setting("steps").read(of_bands);
    if (of_bands.empty()) return;
    const int steps = static_cast<int>(of_bands.front());

    // Three of them would have two different shifts; shifts are the same in all bands.
    const bool alike = std::ranges::count(of_bands, of_bands.front()) == std::ssize(of_bands);
    if (steps < 4 || !alike) return;

    std::vector<double> shifts;
    for (int n = 0; n < steps; ++n) shifts.push_back(360.0 * n / (steps - 1));
    add_settings({{"shifts", shifts}},
                 fmt::format("{} shifts that count both ends of a period, so that the last frame "
                             "shows the first pattern again",
                             steps));
  }

  void add_signs() {
    const SettingValue other = !is_on("alternating");
    add_settings({{"alternating", other}}, "single frames of another sign");
    add_settings({{"alternating", other}, {"backwards", !is_on("backwards")}},
                 "single frames of another sign and phases that shift in the other direction");
  }

  void add_codes(const Code& code) {
    add_settings({{"plain", code.gray}}, code.gray ? "a plain binary code" : "a Gray code");
    add_settings({{"least_first", !is_on("least_first")}}, "the code begins with its other end");
    if (code.base)
      add_settings({{"base", 3 - setting("base").number()}}, "a code with another base");
  }

  /// Other numbers of periods, one at a time, and every two of a list exchanged.
  void add_periods() {
    int family = gamma_family;
    for (const std::string name : {"high", "low", "frequency", "periods"}) {
      const StrategySettings& settings = scan_.sequence.strategy.settings();
      if (!settings.contains(name)) continue;

      std::vector<double> configured;
      settings.at(name).read(configured);
      for (std::size_t i = 0; i < configured.size(); ++i) {
        ++family;

        std::vector<double> periods = configured;
        const int most = std::max(64, static_cast<int>(2 * configured[i]));

        // Half of the configured number, then every whole number up to twice it, 64 at least.
        for (int count = 0; count <= most; ++count) {
          periods[i] = count == 0 ? configured[i] / 2 : count;
          if (periods == configured) continue;
          add_settings({{name, periods}},
                       fmt::format("patterns of {:g} periods, configured as {:g}", periods[i],
                                   configured[i]),
                       family);
        }

        // Exchange two numbers of the list.
        for (std::size_t k = i + 1; k < configured.size(); ++k) {
          periods = configured;
          std::swap(periods[i], periods[k]);
          if (periods != configured)
            add_settings({{name, periods}}, "the periods in another order");
        }
      }
    }
  }

  /// Wrong orders, each once: the cycle begins at another frame; runs of steps rotated, reversed,
  /// swapped or interleaved; two frames swapped.
  void add_orders() {
    const int frames = scan_.model.layout().frames;
    const FrameOrder right = scan_.model.identity();

    // The runs of steps in the order of their frames, and the rest as one more.
    std::vector<StepRun> runs = step_runs(scan_.model.layout());
    std::ranges::sort(runs, {}, &StepRun::first);
    const int end = runs.empty() ? 0 : runs.back().first + runs.back().steps;
    if (end < frames) runs.push_back({end, frames - end});  // e.g. of a code

    // Each order once, with advice relative to the order in force.
    std::set<FrameOrder> known{right};
    const auto add = [&](const FrameOrder& order, std::string likely) {
      if (!known.insert(order).second) return;
      const FrameOrder all = composed(scan_.settings.order, order);
      this->add(CauseKind::frame_order, std::move(likely),
                {std::ranges::is_sorted(all) ? change_settings("omit", {{"order", ""}})
                                             : try_setting("order", text_of(all))})
          .order = order;
    };

    const auto add_swapped = [&](int n, int m) {
      FrameOrder order = right;
      std::swap(order[n], order[m]);
      add(order, fmt::format("frames {} and {} look swapped", n, m));
    };

    // The cycle begins at another frame.
    const std::size_t others = list.size();
    for (int n = 1; runs.size() > 1 && n < frames; ++n) {
      add(turned(right, {0, frames}, n),
          fmt::format("the frames have slipped: the cycle begins at frame {}", n));
    }
    for (std::size_t i = others; i < list.size(); ++i) list[i].slipped = true;

    // Runs in another order, and neighbours swapped.
    add_several_runs(right, runs, add);
    if (const auto& code = scan_.model.layout().code) add_code_orders(right, *code, add);
    for (int n = 0; n + 1 < frames; ++n) add_swapped(n, n + 1);

    add_turns(right, runs, add);

    // Frames far apart are rarely swapped.
    const std::size_t usual = list.size();
    for (int n = 0; n < frames; ++n) {
      for (int m = n + 2; m < frames; ++m) add_swapped(n, m);
    }
    for (std::size_t i = usual; i < list.size(); ++i) list[i].far_fetched = true;
  }

  /// Pictures that are the middle of the calibrated ones, or nearly.
  void add_crop() {
    Scanner cropped = *scan_.scanner;
    const Size size = cropped.camera.size;
    cropped.camera.intrinsic(0, 2) = (size.width - 1) / 2.0;
    cropped.camera.intrinsic(1, 2) = (size.height - 1) / 2.0;

    add(CauseKind::picture_size,
        "a scanner file for larger camera pictures: these are a part of them",
        {{"say which part they are with `camera_region`, or use pictures of the calibrated size"}})
        .scanner = std::move(cropped);
  }

  const JudgedScan& scan_;
  const Fit& as_given_;
  std::vector<std::vector<SettingChange>> tried_;
};

}  // namespace

std::vector<PossibleMistake> possible_mistakes(const JudgedScan& scan, const Fit& as_given) {
  return std::move(Mistakes(scan, as_given).list);
}

}  // namespace slipstream
