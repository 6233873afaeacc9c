#include "slipstream/check/mistake_search.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/check/mistaken_orders.h"
#include "slipstream/codes/registry.h"

namespace slipstream {
namespace {

Fit fit_of(const JudgedScan& scan, const FrameModel& model, const FrameOrder& order) {
  Fit fit{.frames = FrameJudge(model)(scan.samples, order), .moving = scan.moving};
  if (scan.scanner != nullptr && model.has_coordinate()) {
    fit.geometry = geometry_evidence(model, scan.samples, *scan.scanner, scan.sequence.axis, order);
  }
  return fit;
}

MeasuredResponse power_law(double gamma) {
  MeasuredResponse measured;
  measured.response = PowerLaw{gamma};
  measured.gamma = gamma;
  return measured;
}

class Search {
 public:
  Search(const JudgedScan& scan, const Fit& as_given)
      : scan_(scan), judge_(scan.model), as_given_(as_given) {}

  /// The likeliest; where others fit about as well their words with its own.
  [[nodiscard]] std::optional<Explanation> best() {
    const bool frames_fit =
        as_given_.bands_agree() && as_given_.patterns_made() && as_given_.no_seam();
    if (!frames_fit) try_gamma();
    try_periods();
    try_orders();
    if (scan_.scanner != nullptr && frames_fit) {
      try_axis();
      try_turned_pictures();
      try_scanners();
    }
    if (explanations_.empty()) return std::nullopt;
    return likeliest();
  }

 private:
  [[nodiscard]] Fit fit(const FrameModel& model, const FrameOrder& order) const {
    return fit_of(scan_, model, order);
  }

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
      keep(with, {.likely = "a response that is corrected for and does not show in the frames",
                  .advice = "try --gamma none",
                  .gravity = Gravity::doubtful});
      return;
    }
    Explanation best{.misfit = as_given_.misfit()};
    for (int tenths = 5; tenths <= 30; ++tenths) {
      const double gamma = tenths / 10.0;
      const Fit with = fit_with_gamma(gamma);
      // A camera's own curve leaves something of its harmonics.
      const bool fits = with.bands_agree() && with.no_seam() && with.geometry_fits() &&
                        with.depths_fit() && with.frames.residual <= as_given_.frames.residual;
      if (!fits || with.misfit() >= best.misfit) continue;
      best = {
          with.misfit(),
          fmt::format("the projector's gamma, with the camera's, of about {:.1f}, not corrected",
                      gamma),
          "measure it with slipstream calibrate gamma, or try --gamma blind", Gravity::doubtful};
    }
    if (!best.likely.empty()) explanations_.push_back(best);
  }

  [[nodiscard]] Fit fit_with_gamma(const std::optional<double>& gamma) const {
    PhotometricCalibration photometry{.ambient = scan_.photometry.ambient,
                                      .noise_variance = scan_.photometry.noise_variance};
    if (gamma) photometry.response.emplace(power_law(*gamma));
    return fit(FrameModel(scan_.sequence, photometry), scan_.model.identity());
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
      // Only the ratio of two bands is known: the coarser one may be what was said wrongly.
      if (relations == chain.size()) continue;
      const std::size_t coarse = chain[i];
      try_setting(coarse, bands[coarse].periods * bands[fine].periods / *periods);
    }
  }

  /// The strategy with `periods` in a band, by whichever setting says them.
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
        keep(fit(FrameModel(sequence, scan_.photometry), scan_.model.identity()),
             {.likely = fmt::format("patterns of {:g} periods where {:g} are said", periods, said),
              .advice = fmt::format("try --{} {:g}", name, periods)});
      } catch (const Error&) {
        continue;  // no strategy of the registry's has such periods
      }
    }
  }

  /// Whether it is worth while to look at all groups and at the geometry, from a quarter of them.
  [[nodiscard]] bool may_fit(const FrameOrder& order) {
    constexpr std::size_t groups = 192;
    const double most_residual = scan_.moving ? 0.3 : 0.15;
    const FrameEvidence& frames = judge_(scan_.samples, order, groups);
    const auto agrees = [](const BandRelation& relation) { return relation.agreement >= 0.35; };
    return frames.residual <= most_residual &&
           std::all_of(frames.relations.begin(), frames.relations.end(), agrees);
  }

  void try_orders() {
    for (MistakenOrder& mistake : mistaken_orders(scan_.model.layout())) {
      if (!may_fit(mistake.order)) continue;
      keep(fit(scan_.model, mistake.order),
           {.likely = std::move(mistake.words),
            .advice = "try --order " + text_of(composed(scan_.order, mistake.order)),
            .order = mistake.kind == MistakenOrder::Kind::slipped ? mistake.order : FrameOrder{},
            .far_fetched = mistake.kind == MistakenOrder::Kind::far_fetched});
    }
  }

  void try_geometry(const Scanner& scanner, Axis axis, const PictureTurn& turn,
                    Explanation explanation) {
    Fit with{.frames = as_given_.frames, .moving = scan_.moving};
    with.geometry =
        geometry_evidence(scan_.model, scan_.samples, scanner, axis, scan_.model.identity(), turn);
    keep(with, std::move(explanation));
  }

  void try_axis() {
    const Axis other = across(scan_.sequence.axis);
    try_geometry(*scan_.scanner, other, {},
                 {.likely = fmt::format("patterns that vary along {}, not {}", name_of(other),
                                        name_of(scan_.sequence.axis)),
                  .advice = fmt::format("try --axis {}", name_of(other))});
  }

  void try_turned_pictures() {
    const Scanner& scanner = *scan_.scanner;
    const Axis axis = scan_.sequence.axis;
    try_geometry(scanner, axis, {.columns = true, .rows = true},
                 {.likely = "pictures turned upside down since the calibration",
                  .advice = "turn them by 180 degrees, or calibrate with pictures as these"});
    try_geometry(scanner, axis, {.columns = true},
                 {.likely = "pictures mirrored left to right since the calibration",
                  .advice = "mirror them back"});
    try_geometry(scanner, axis, {.rows = true},
                 {.likely = "pictures mirrored top to bottom since the calibration",
                  .advice = "mirror them back"});
  }

  void try_scanners() {
    const Scanner& given = *scan_.scanner;
    const Axis axis = scan_.sequence.axis;
    Scanner other = given;
    other.rotation = given.rotation.transpose();
    other.translation = -other.rotation * given.translation;
    try_geometry(other, axis, {},
                 {.likely = "a scanner file whose rotation and translation go from the projector "
                            "to the camera",
                  .advice = "invert them: they go from the camera's frame to the projector's"});
    other = given;
    other.rotation = given.rotation.transpose();
    try_geometry(other, axis, {},
                 {.likely = "a scanner file whose rotation is inverted",
                  .advice = "transpose it: it goes from the camera's frame to the projector's"});
    other = given;
    other.translation = -given.translation;
    try_geometry(other, axis, {},
                 {.likely = "a scanner file whose translation has the wrong sign",
                  .advice = "turn its sign: it is the camera's place in the projector's frame"});
    other = given;
    std::swap(other.camera.intrinsic, other.projector.intrinsic);
    std::swap(other.camera.distortion, other.projector.distortion);
    try_geometry(other, axis, {},
                 {.likely = "a scanner file with camera and projector swapped",
                  .advice = "swap their matrices"});
    other.rotation = given.rotation.transpose();
    other.translation = -other.rotation * given.translation;
    try_geometry(other, axis, {},
                 {.likely = "a scanner file with camera and projector swapped",
                  .advice = "swap their matrices, and invert rotation and translation"});
    for (const double scale : {0.5, 2.0}) try_scaled(scale);
  }

  void try_scaled(double scale) {
    const Axis axis = scan_.sequence.axis;
    const char* const words = scale < 1 ? "twice" : "half";
    Scanner other = *scan_.scanner;
    other.camera.intrinsic.topRows<2>() *= scale;
    try_geometry(other, axis, {},
                 {.likely = fmt::format("a scanner file for camera pictures {} as large", words),
                  .advice = "use pictures of the size that was calibrated"});
    other = *scan_.scanner;
    other.projector.intrinsic.topRows<2>() *= scale;
    try_geometry(other, axis, {},
                 {.likely = fmt::format("a scanner file for projector pictures {} as large", words),
                  .advice = "give the projector's size that was calibrated with --projector"});
  }

  [[nodiscard]] Explanation likeliest() {
    // Of those that fit about as well the simplest comes first; an order that takes more than one
    // slip of the hand is named only where nothing else fits.
    constexpr double nearly = 1.2;
    constexpr std::size_t most_named = 3;
    std::stable_sort(explanations_.begin(), explanations_.end(), [](const auto& a, const auto& b) {
      constexpr double alike = 0.3;
      return std::floor(a.misfit / alike) < std::floor(b.misfit / alike);
    });
    const auto usual = std::find_if(explanations_.begin(), explanations_.end(),
                                    [](const Explanation& one) { return !one.far_fetched; });
    const bool is_usual =
        usual != explanations_.end() && usual->misfit <= explanations_.front().misfit + nearly;
    Explanation best = is_usual ? *usual : explanations_.front();
    std::vector<std::string> named{best.likely};
    for (const Explanation& other : explanations_) {
      const bool known = std::find(named.begin(), named.end(), other.likely) != named.end();
      const bool too_far = other.misfit > best.misfit + nearly || (is_usual && other.far_fetched);
      if (known || too_far || named.size() == most_named) continue;
      named.push_back(other.likely);
      best.likely += ", or " + other.likely;
      best.advice += "; or " + other.advice;
    }
    // Nothing is set right that may be wrong then.
    if (named.size() == 1 && !best.order.empty()) {
      best.gravity = Gravity::doubtful;
      best.advice = "the order " + text_of(composed(scan_.order, best.order)) + " sets them right";
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

Fit fit_as_given(const JudgedScan& scan) {
  return fit_of(scan, scan.model, scan.model.identity());
}

std::optional<Explanation> likeliest_mistake(const JudgedScan& scan, const Fit& as_given) {
  return Search(scan, as_given).best();
}

}  // namespace slipstream
