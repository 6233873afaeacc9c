#include "slipstream/check/explanations.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "slipstream/check/fit.h"
#include "slipstream/check/frame_faults.h"
#include "slipstream/check/mistaken_orders.h"
#include "slipstream/error/error.h"
#include "slipstream/strategy/registry.h"

namespace slipstream {
namespace {

/// A mistake without which all would fit.
struct Explanation {
  double misfit = 0;
  std::string likely{}, advice{};
  Gravity gravity = Gravity::wrong;
  FrameOrder order{};  ///< where the cycle has slipped
  bool far_fetched = false;
};

class Search {
 public:
  explicit Search(const JudgedScan& scan)
      : scan_(scan), judge_(scan.model), as_given_(fit(scan.model, scan.model.identity())) {}

  [[nodiscard]] const Fit& as_given() const { return as_given_; }

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
    Fit result{.frames = FrameJudge(model)(scan_.samples, order), .moving = scan_.moving};
    if (scan_.scanner != nullptr && model.has_coordinate()) {
      result.geometry =
          geometry_evidence(model, scan_.samples, *scan_.scanner, scan_.sequence.axis, order);
    }
    return result;
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
    PhotometricCalibration photometry = scan_.photometry;
    photometry.response.reset();
    if (gamma) {
      MeasuredResponse& response = photometry.response.emplace();
      response.response = PowerLaw{*gamma};
      response.gamma = *gamma;
    }
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
      if (value != said) continue;
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
            .advice = "try --order " + text_of(mistake.order),
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
    const Axis other = scan_.sequence.axis == Axis::x ? Axis::y : Axis::x;
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

std::vector<Evidence> relation_evidence(const FrameEvidence& frames) {
  const auto worst = std::min_element(
      frames.relations.begin(), frames.relations.end(), [](const auto& a, const auto& b) {
        return a.agreement - std::abs(a.offset) < b.agreement - std::abs(b.offset);
      });
  if (worst == frames.relations.end()) return {};
  return {{"agreement", worst->agreement}, {"offset in periods", worst->offset}};
}

/// What of it does not fit, the clearest first.
Finding seen(const Fit& fit) {
  Finding finding{.gravity = Gravity::wrong};
  const auto& geometry = fit.geometry;
  if (!fit.patterns_made()) {
    finding.what = "the frames are not what these patterns make";
    finding.evidence = {{"left over, share of their variation", fit.frames.residual}};
  } else if (!fit.bands_alike()) {
    finding.what = "the bands are lit unlike each other from pixel to pixel";
    finding.evidence = {{"spread of their modulations' ratio", fit.frames.ratio_spread}};
  } else if (!fit.bands_agree()) {
    finding.what = "the frames disagree about the fringe order";
    finding.evidence = relation_evidence(fit.frames);
  } else if (!fit.no_seam()) {
    finding.what = "the coordinate leaps from one end of the field to the other in the light";
    finding.evidence = {{"share of the pixels near it", fit.frames.seams}};
  } else if (!fit.geometry_fits()) {
    finding.what = "frames and scanner do not fit together";
    finding.evidence = {{"slope of the coordinate", geometry->slope},
                        {"share outside the projector's light", geometry->outside},
                        {"share without a point", geometry->without_point}};
  } else {
    finding.what = "most points lie outside of the depths that were calibrated";
    finding.evidence = {{"share", geometry->out_of_range},
                        {"median depth, mm", geometry->median_depth}};
  }
  return finding;
}

/// Where no usual mistake explains it.
void name_broadly(const Fit& fit, Finding& finding) {
  const auto& geometry = fit.geometry;
  // So few pixels are right then that none can be told from the wrong ones.
  constexpr double hopeless_agreement = 0.35, hopeless_offset = 0.25, hopeless_residual = 0.2;
  constexpr double hopeless_outside = 0.6;
  finding.gravity = Gravity::doubtful;
  if (!fit.patterns_made() || !fit.bands_agree() || !fit.no_seam()) {
    const auto hopeless = [](const BandRelation& relation) {
      return relation.agreement < hopeless_agreement || std::abs(relation.offset) > hopeless_offset;
    };
    const auto& relations = fit.frames.relations;
    if (fit.frames.residual > hopeless_residual ||
        std::any_of(relations.begin(), relations.end(), hopeless)) {
      finding.gravity = Gravity::wrong;
    }
    finding.likely = "other patterns than said, frames lost or mixed up, or something moved";
    finding.advice = "compare the pictures with those of slipstream patterns";
  } else if (!fit.geometry_fits()) {
    if (geometry->outside + geometry->without_point > hopeless_outside)
      finding.gravity = Gravity::wrong;
    finding.likely =
        "a scanner file of another rig, pictures cropped or of another size, or a camera or "
        "projector that moved since the calibration";
    finding.advice = "check the file, and calibrate again where the rig was touched";
  } else {
    finding.likely =
        "something nearer or farther than the boards were, or a scanner file of another rig";
    finding.advice = "calibrate with boards at those depths, or check the order of the frames";
  }
}

/// Light that changed between frames.
std::optional<Finding> flicker(const JudgedScan& scan, const Fit& fit) {
  // Right scans leave more at times, a real skull 0.0085, but then no gains explain it: at most
  // 0.62 of it, and by half a percent. Lamps and exposures do not change by more than the last.
  constexpr double least_residual = 0.003, least_explained = 0.7, least_gain = 0.025;
  constexpr double most_gain = 0.3;
  if (fit.frames.residual < least_residual) return std::nullopt;
  const FrameGains gains = frame_gains(scan.model, scan.samples);
  const auto odd = std::max_element(gains.gains.begin(), gains.gains.end(),
                                    [](double a, double b) { return std::abs(a) < std::abs(b); });
  const double size = std::abs(*odd);
  if (!(gains.explained >= least_explained && size >= least_gain && size <= most_gain)) {
    return std::nullopt;
  }
  // Motion may look like light, but hardly like that of one frame alone.
  if (scan.moving && !gains.odd_frame) return std::nullopt;
  Finding finding{
      .what = "frames are brighter or darker than the patterns make them",
      .likely = "light that flickers, or an exposure or gain that changed between frames",
      .advice =
          "fix exposure and gain, and expose for whole periods of the mains and the projector"};
  if (gains.odd_frame) {
    finding.evidence = {
        {fmt::format("frame {}, percent", gains.odd_frame->frame), 100 * gains.odd_frame->gain}};
  } else {
    finding.evidence = {{"the most, percent", 100 * size}};
  }
  return finding;
}

}  // namespace

namespace {

/// Frames without any pattern, where they are no dark part of one.
std::vector<Finding> dark_frames(const JudgedScan& scan, const Fit& fit) {
  // Frames that contradict each other so much have lost one; where they cannot, what the scene sees
  // of the patterns must make it bright somewhere.
  constexpr double contradicting = 0.2, least_of_pattern = 0.5;
  if (scan.model.unexplained_count() > 0 && fit.frames.residual < contradicting) return {};
  if (!scan.model.has_redundancy()) {
    for (int n = 0; n < scan.samples.frames(); ++n) {
      if (scan.model.shown_range(n, scan.samples) < least_of_pattern) return {};
    }
  }
  return slipstream::dark_frames(scan.samples);
}

}  // namespace

Explained explain(const JudgedScan& scan) {
  constexpr std::size_t fewest_groups = 64;
  if (scan.samples.groups() < fewest_groups) return {};
  Explained result;
  Search search(scan);
  const Fit& fit = search.as_given();
  auto flickering = flicker(scan, fit);
  if (fit.all()) {
    // Where frames say something of each other a dark one would not have fitted.
    if (!scan.model.has_redundancy()) result.findings = dark_frames(scan, fit);
    if (flickering && result.findings.empty()) result.findings.push_back(std::move(*flickering));
    return result;
  }
  Finding finding = seen(fit);
  const bool only_depths =
      fit.bands_agree() && fit.patterns_made() && fit.no_seam() && fit.geometry_fits();
  if (auto explanation = search.best()) {
    if (only_depths) {
      // The scene may be where no board was, as well.
      explanation->gravity = Gravity::doubtful;
      explanation->likely += ", or something nearer or farther than the boards were";
    }
    finding.likely = std::move(explanation->likely);
    finding.advice = std::move(explanation->advice);
    finding.gravity = explanation->gravity;
    result.order = std::move(explanation->order);
  } else if (std::vector<Finding> faults = dark_frames(scan, fit); !faults.empty()) {
    result.findings = std::move(faults);
    return result;
  } else if (flickering) {
    finding = std::move(*flickering);
  } else {
    name_broadly(fit, finding);
  }
  result.findings.push_back(std::move(finding));
  return result;
}

}  // namespace slipstream
