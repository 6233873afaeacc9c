#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "slipstream/base/error.h"
#include "slipstream/check/explanations.h"
#include "slipstream/codes/registry.h"

namespace slipstream {
namespace {

/// A way in which frames get out of the patterns' order.
struct MistakenOrder {
  enum class Kind {
    usual,
    slipped,      ///< the whole cycle begins at another frame
    far_fetched,  ///< two frames far apart exchanged
  };
  FrameOrder order;   ///< the correction: frame `order[n]` shows pattern n
  std::string words;  ///< "frames 0 to 2 look rotated by 1"
  Kind kind = Kind::usual;
};

/// The runs of steps that share no frame; the whole cycle if none exist.
std::vector<StepRun> runs_of(const Layout& layout) {
  std::vector<StepRun> runs;
  for (const Band& band : layout.bands) {
    const auto run = step_run(band);
    if (run && std::ranges::count(runs, *run) == 0) runs.push_back(*run);
  }
  std::ranges::sort(runs, {}, &StepRun::first);
  if (runs.empty()) runs.push_back({0, layout.frames});
  return runs;
}

/// A run of the frames, optionally reversed, then rotated by `places`.
FrameOrder turned(FrameOrder order, const StepRun& run, int places, bool backwards = false) {
  const auto begin = order.begin() + run.first, end = begin + run.steps;
  if (backwards) std::reverse(begin, end);
  std::rotate(begin, begin + places, end);
  return order;
}

/// Every run rotated by the same share of a period, forwards or reversed: the bands' phases still
/// agree.
template <class Add>
void add_common_turns(const FrameOrder& right, const std::vector<StepRun>& runs, const Add& add) {
  int least = runs.front().steps;
  for (const StepRun& run : runs) least = std::gcd(least, run.steps);
  for (int part = 0; part < least; ++part) {
    for (const bool backwards : {false, true}) {
      FrameOrder order = right;
      for (const StepRun& run : runs)
        order = turned(order, run, part * run.steps / least, backwards);
      add(order, backwards          ? "the frames of each band are in reversed order"
                 : runs.size() == 1 ? fmt::format("the frames are rotated by {}", part)
                                    : "the frames of each band are rotated");
    }
  }
}

template <class Add>
void add_single_turns(const FrameOrder& right, const std::vector<StepRun>& runs, const Add& add) {
  for (const StepRun& run : runs) {
    const std::string frames = fmt::format("frames {} to {}", run.first, run.first + run.steps - 1);
    for (int places = 1; places < run.steps; ++places) {
      add(turned(right, run, places),
          fmt::format("{} look rotated by {}", frames, run.steps - places));
    }
    for (int places = 0; places < run.steps; ++places) {
      add(turned(right, run, places, true), fmt::format("{} look reversed", frames));
    }
  }
}

/// Reversed and interleaved runs. Two swapped runs count as a slipped cycle instead.
template <class Add>
void add_two_runs(const FrameOrder& right, const std::vector<StepRun>& runs, const Add& add) {
  if (runs.size() != 2 || runs[0].steps + runs[1].steps != static_cast<int>(right.size())) return;
  add(FrameOrder(right.rbegin(), right.rend()), "all frames are in reversed order");
  const int steps = runs[0].steps;
  if (steps != runs[1].steps) return;
  for (const int first : {0, 1}) {
    FrameOrder in_turns;
    for (int n = 0; n < 2 * steps; ++n) {
      in_turns.push_back(2 * (n % steps) + (first + n / steps) % 2);
    }
    add(in_turns, "the frames of the two bands are interleaved");
  }
}

/// Common wrong orders, each once, simplest first: cycle begins at another frame, runs of steps
/// rotated, reversed, swapped or interleaved, two frames swapped.
std::vector<MistakenOrder> mistaken_orders(const FrameModel& model) {
  using Kind = MistakenOrder::Kind;
  const int frames = model.layout().frames;
  const FrameOrder right = model.identity();
  const std::vector<StepRun> runs = runs_of(model.layout());
  std::set<FrameOrder> known{right};
  std::vector<MistakenOrder> orders;
  const auto add = [&](FrameOrder order, std::string words, Kind kind = Kind::usual) {
    if (known.insert(order).second) orders.push_back({std::move(order), std::move(words), kind});
  };
  const auto add_exchanged = [&](int n, int m, Kind kind) {
    FrameOrder order = right;
    std::swap(order[static_cast<std::size_t>(n)], order[static_cast<std::size_t>(m)]);
    add(order, fmt::format("frames {} and {} look swapped", n, m), kind);
  };
  for (int places = 1; runs.size() > 1 && places < frames; ++places) {
    add(turned(right, {0, frames}, places),
        fmt::format("the frames have slipped: the cycle begins at frame {}", places),
        Kind::slipped);
  }
  add_two_runs(right, runs, add);
  add_common_turns(right, runs, add);
  for (int n = 0; n + 1 < frames; ++n) add_exchanged(n, n + 1, Kind::usual);
  add_single_turns(right, runs, add);
  for (int n = 0; n < frames; ++n) {
    for (int m = n + 2; m < frames; ++m) add_exchanged(n, m, Kind::far_fetched);
  }
  return orders;
}

Fit fit_of(const JudgedScan& scan, const FrameModel& model, const FrameOrder& order) {
  Fit fit{.frames = FrameJudge(model)(scan.samples, order), .moving = scan.settings.moving};
  if (scan.scanner != nullptr && model.has_coordinate()) {
    fit.geometry = geometry_evidence(model, scan.samples, *scan.scanner, scan.sequence.axis, order);
  }
  return fit;
}

class Search {
 public:
  Search(const JudgedScan& scan, const Fit& as_given)
      : scan_(scan), judge_(scan.model), as_given_(as_given) {}

  /// The likeliest mistake; its text names others that fit about as well.
  [[nodiscard]] std::optional<Explanation> best() {
    const bool frames_fit = as_given_.frames_fit();
    if (!frames_fit) try_gamma();
    try_periods();
    try_orders();
    if (scan_.scanner != nullptr && frames_fit) {
      try_axis(*scan_.scanner);
      try_turned_pictures(*scan_.scanner);
      try_scanners(*scan_.scanner);
    }
    if (explanations_.empty()) return std::nullopt;
    return likeliest();
  }

 private:
  void keep(const Fit& fit, Explanation explanation) {
    if (!fit.all()) return;
    explanation.misfit = fit.misfit();
    explanations_.push_back(std::move(explanation));
  }

  void try_gamma() {
    constexpr double most_residual = 0.4;  // of a gamma of 3 in eight steps
    if (as_given_.frames.residual > most_residual) return;
    if (scan_.photometry.response) {
      const Fit with = fit_with_gamma(std::nullopt);
      keep(with, {.likely = "a response that is corrected but does not show in the frames",
                  .advice = "try --gamma none",
                  .gravity = Gravity::doubtful});
      return;
    }
    Explanation best{.misfit = as_given_.misfit()};
    for (int tenths = 5; tenths <= 30; ++tenths) {
      const double gamma = tenths / 10.0;
      const Fit with = fit_with_gamma(gamma);
      // The camera's response curve leaves some harmonics.
      const bool fits = with.bands_agree() && with.no_seam() && with.geometry_fits() &&
                        with.depths_fit() && with.frames.residual <= as_given_.frames.residual;
      if (!fits || with.misfit() >= best.misfit) continue;
      best = {
          with.misfit(),
          fmt::format("the projector's gamma (with the camera's, about {:.1f}) is not corrected",
                      gamma),
          "measure it with slipstream calibrate gamma, or try --gamma blind", Gravity::doubtful};
    }
    if (!best.likely.empty()) explanations_.push_back(best);
  }

  [[nodiscard]] Fit fit_with_gamma(const std::optional<double>& gamma) const {
    PhotometricCalibration photometry{.ambient = scan_.photometry.ambient,
                                      .noise_variance = scan_.photometry.noise_variance};
    if (gamma) photometry.response = {PowerLaw{*gamma}, *gamma, 0};
    return fit_of(scan_, FrameModel(scan_.sequence, photometry), scan_.model.identity());
  }

  void try_periods() {
    const std::size_t relations = as_given_.frames.relations.size();
    for (std::size_t i = 0; i < relations; ++i) {
      const auto periods = periods_that_agree(scan_.model, scan_.samples, i);
      if (!periods) continue;
      const std::vector<std::size_t>& chain = scan_.model.bands();
      const std::vector<Band>& bands = scan_.model.layout().bands;
      const std::size_t fine = chain[i + chain.size() - relations];
      try_setting(fine, *periods);
      // Only the ratio of two bands is known: the coarser one may be misconfigured.
      if (relations == chain.size()) continue;
      const std::size_t coarse = chain[i];
      try_setting(coarse, bands[coarse].periods * bands[fine].periods / *periods);
    }
  }

  /// Tries the strategy with `periods` in a band, through the setting that controls it.
  void try_setting(std::size_t band, double periods) {
    const Strategy& strategy = scan_.sequence.strategy;
    const double said = strategy.layout().bands[band].periods;
    for (const auto& [name, value] : strategy.settings()) {
      if (value != SettingValue(said)) continue;
      StrategySettings settings = strategy.settings();
      settings[name] = periods;
      try {
        Sequence sequence = scan_.sequence;
        sequence.strategy = make_strategy(strategy.name(), settings);
        if (frame_count(sequence.strategy) != scan_.samples.frames()) continue;
        keep(fit_of(scan_, FrameModel(sequence, scan_.photometry), scan_.model.identity()),
             {.likely = fmt::format("patterns of {:g} periods, configured as {:g}", periods, said),
              .advice = fmt::format("try --{} {:g}", name, periods)});
      } catch (const Error&) {
        continue;  // the strategy does not allow these periods
      }
    }
  }

  /// Quick test on a quarter of the groups: whether the full test is worthwhile.
  [[nodiscard]] bool may_fit(const FrameOrder& order) {
    constexpr std::size_t groups = 192;
    const double most_residual = scan_.settings.moving ? 0.3 : 0.15;
    const FrameEvidence& frames = judge_(scan_.samples, order, groups);
    const auto agrees = [](const BandRelation& relation) { return relation.agreement >= 0.35; };
    return frames.residual <= most_residual &&
           std::all_of(frames.relations.begin(), frames.relations.end(), agrees);
  }

  void try_orders() {
    for (MistakenOrder& mistake : mistaken_orders(scan_.model)) {
      if (!may_fit(mistake.order)) continue;
      keep(fit_of(scan_, scan_.model, mistake.order),
           {.likely = std::move(mistake.words),
            .advice = "try --order " + text_of(composed(scan_.settings.order, mistake.order)),
            .order = mistake.kind == MistakenOrder::Kind::slipped ? mistake.order : FrameOrder{},
            .far_fetched = mistake.kind == MistakenOrder::Kind::far_fetched});
    }
  }

  void try_geometry(const Scanner& scanner, Axis axis, const PictureTurn& turn, std::string likely,
                    std::string advice) {
    Fit with{.frames = as_given_.frames, .moving = scan_.settings.moving};
    with.geometry =
        geometry_evidence(scan_.model, scan_.samples, scanner, axis, scan_.model.identity(), turn);
    keep(with, {.likely = std::move(likely), .advice = std::move(advice)});
  }

  void try_axis(const Scanner& scanner) {
    const Axis axis = scan_.sequence.axis, other = across(axis);
    try_geometry(scanner, other, {},
                 fmt::format("patterns that vary along {}, not {}", name_of(other), name_of(axis)),
                 fmt::format("try --axis {}", name_of(other)));
  }

  void try_turned_pictures(const Scanner& scanner) {
    const auto attempt = [&](const PictureTurn& turn, const char* turned, const char* advice) {
      try_geometry(scanner, scan_.sequence.axis, turn,
                   fmt::format("pictures {} since the calibration", turned), advice);
    };
    attempt({.columns = true, .rows = true}, "turned upside down",
            "rotate them by 180 degrees, or calibrate with pictures in this orientation");
    attempt({.columns = true}, "mirrored left to right", "mirror them back");
    attempt({.rows = true}, "mirrored top to bottom", "mirror them back");
  }

  void try_scanners(const Scanner& given) {
    const auto attempt = [&](const auto& mend, std::string_view file, const char* advice) {
      Scanner mended = given;
      mend(mended);
      try_geometry(mended, scan_.sequence.axis, {}, fmt::format("a scanner file {}", file), advice);
    };
    const auto invert = [](Scanner& scanner) {
      scanner.rotation.transposeInPlace();
      scanner.translation = (-scanner.rotation * scanner.translation).eval();
    };
    const auto swap = [](Scanner& scanner) {
      std::swap(scanner.camera.intrinsic, scanner.projector.intrinsic);
      std::swap(scanner.camera.distortion, scanner.projector.distortion);
    };
    const auto both = [&](Scanner& scanner) {
      swap(scanner);
      invert(scanner);
    };
    attempt(invert, "whose rotation and translation go from the projector to the camera",
            "invert them: they must go from the camera's frame to the projector's");
    attempt([](Scanner& scanner) { scanner.rotation.transposeInPlace(); },
            "whose rotation is inverted",
            "transpose it: it must go from the camera's frame to the projector's");
    attempt([](Scanner& scanner) { scanner.translation *= -1; },
            "whose translation has the wrong sign",
            "negate it: it is the camera's position in the projector's frame");
    attempt(swap, "with camera and projector swapped", "swap their matrices");
    attempt(both, "with camera and projector swapped",
            "swap their matrices, and invert rotation and translation");
    for (const double scale : {0.5, 2.0}) {
      const char* const large = scale < 1 ? "twice as large" : "half as large";
      attempt([&](Scanner& scanner) { scanner.camera.intrinsic.topRows<2>() *= scale; },
              fmt::format("for camera pictures {}", large), "use pictures of the calibrated size");
      attempt([&](Scanner& scanner) { scanner.projector.intrinsic.topRows<2>() *= scale; },
              fmt::format("for projector pictures {}", large),
              "set --projector to the calibrated size");
    }
  }

  [[nodiscard]] Explanation likeliest() {
    // Among about equal fits the simplest comes first. A far-fetched order is named only if nothing
    // else fits.
    constexpr double nearly = 1.2;
    constexpr std::size_t most_named = 3;
    std::stable_sort(explanations_.begin(), explanations_.end(), [](const auto& a, const auto& b) {
      constexpr double alike = 0.3;
      return std::floor(a.misfit / alike) < std::floor(b.misfit / alike);
    });
    const auto usual = std::ranges::find(explanations_, false, &Explanation::far_fetched);
    const bool is_usual =
        usual != explanations_.end() && usual->misfit <= explanations_.front().misfit + nearly;
    Explanation best = is_usual ? *usual : explanations_.front();
    std::vector<std::string> named{best.likely};
    for (const Explanation& other : explanations_) {
      const bool known = std::ranges::count(named, other.likely) > 0;
      const bool too_far = other.misfit > best.misfit + nearly || (is_usual && other.far_fetched);
      if (known || too_far || named.size() == most_named) continue;
      named.push_back(other.likely);
      best.likely += ", or " + other.likely;
      best.advice += "; or " + other.advice;
    }
    // Repair only if the explanation is unique.
    if (named.size() == 1 && !best.order.empty()) {
      best.gravity = Gravity::doubtful;
      best.advice =
          "the order " + text_of(composed(scan_.settings.order, best.order)) + " corrects this";
    } else {
      best.order.clear();
    }
    return best;
  }

  JudgedScan scan_;
  FrameJudge judge_;
  Fit as_given_;
  std::vector<Explanation> explanations_;
};

}  // namespace

FrameOrder composed(const FrameOrder& first, const FrameOrder& then) {
  if (first.empty()) return then;
  FrameOrder both;
  for (const int place : then) both.push_back(first.at(static_cast<std::size_t>(place)));
  return both;
}

std::string text_of(const FrameOrder& order) {
  return fmt::format("{}", fmt::join(order, ","));
}

Fit fit_as_given(const JudgedScan& scan) {
  return fit_of(scan, scan.model, scan.model.identity());
}

std::optional<Explanation> likeliest_mistake(const JudgedScan& scan, const Fit& as_given) {
  return Search(scan, as_given).best();
}

}  // namespace slipstream
