#include "check/mistake_search.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "base/numbers.h"
#include "check/code_evidence.h"
#include "check/method_limits.h"
#include "check/phase_noise.h"
#include "check/waveform.h"

namespace slipstream {
namespace {

/// Leaves the part of a waveform that hardly bends the phase out of the residual.
void excuse_waveform(const JudgedScan& scan, const FrameModel& model, const FrameOrder& order,
                     Fit& fit) {
  const auto waveform = waveform_of(model, scan, order);
  if (!waveform || !waveform->explains(fit.frames.residual)) return;
  fit.waveform = waveform;

  const PhaseNoise noise = phase_noise(model, scan);
  const bool is_harmless = waveform->phase_error <= std::hypot(noise.typical, noise.by_pixel);
  if (is_harmless) fit.frames.residual = waveform->residual;
}

/// Whether the mistake is one of the scanner, or of how the pictures lie.
bool leaves_frames(const PossibleMistake& mistake) {
  return mistake.order.empty() && !mistake.sequence && !mistake.photometry;
}

/// Calls `use` with the model and the order of the frames after the mistake is undone.
template <class Use>
auto with_model(const JudgedScan& scan, const PossibleMistake& mistake, const Use& use) {
  const FrameOrder order = mistake.order.empty() ? scan.model.identity() : mistake.order;
  if (!mistake.sequence && !mistake.photometry) return use(scan.model, order);

  const FrameModel* const same_light = mistake.photometry ? nullptr : &scan.model;
  return use(FrameModel(mistake.sequence.value_or(scan.sequence),
                        mistake.photometry.value_or(scan.photometry), same_light),
             order);
}

/// The coordinates of the frames compared with the scanner; nullopt without one or the other.
std::optional<GeometryEvidence> geometry_of(const JudgedScan& scan, const PossibleMistake& mistake,
                                            const FrameModel& model, const FrameEvidence& frames) {
  if (scan.scanner == nullptr || !model.has_coordinate()) return std::nullopt;

  const Scanner& scanner = mistake.scanner ? *mistake.scanner : *scan.scanner;
  const Axis axis = mistake.sequence ? mistake.sequence->axis : scan.sequence.axis;
  return geometry_evidence(frames.coordinates, source_of(model), scanner, axis, mistake.turn);
}

/// The residual beyond which few groups show that frames are not of the patterns.
double most_rough_residual(const JudgedScan& scan, const FrameModel& model) {
  // Motion, and a waveform that is taken out later: of a gamma of 3 in four steps.
  constexpr double usual = 0.15, moving = 0.3, with_waveform = 0.35;

  if (scan.settings.moving) return moving;
  return can_show_waveform(model) ? with_waveform : usual;
}

/// The misfit of the frames alone, by a few groups; nullopt if a full test is useless. Most
/// mistakes show in the very first groups.
std::optional<double> rough_misfit(const JudgedScan& scan, const PossibleMistake& mistake) {
  return with_model(scan, mistake, [&](const FrameModel& model, const FrameOrder& order) {
    const double most_residual = mistake.approximate ? 1 : most_rough_residual(scan, model);
    FrameJudge judge(model);
    Fit fit;

    for (const std::size_t groups : {4U, 16U, 96U}) {
      fit.frames = judge(scan.samples, order, groups);
      const bool hopeless = std::ranges::any_of(fit.frames.relations, [](const auto& relation) {
        return relation.noise > 0.3 && relation.agreement < 0.35;
      });

      if (fit.frames.doubt > 0.35 || fit.frames.residual > most_residual ||
          (hopeless && groups > 4)) {
        return std::optional<double>();
      }
    }

    fit.code = code_evidence(model, scan.samples, order, false);
    return fit.code_agrees() ? std::optional(fit.misfit() + fit.frames.doubt) : std::nullopt;
  });
}

/// Whether the mistake explains the scan, which fitted as `before`.
bool explains(const Fit& fit, const Fit& before, const PossibleMistake& mistake) {
  // Periods too narrow for the pictures contradict nothing.
  if (before.has_evidence() && !fit.has_evidence()) return false;

  // An order or origin that leaves a drift along the field is only right in a part of it.
  if (fit.code.drifts()) return false;

  if (!mistake.approximate) return fit.all();

  // A large misfit of the patterns is a gamma's only if correcting that removes most of it. The
  // camera's response curve leaves some harmonics.
  constexpr double large = 0.2, most_left = 0.6, most_left_of_small = 0.8;
  const double residual = before.frames.residual;
  if (residual > large && fit.frames.residual > most_left * residual) return false;
  if (!before.patterns_made() && fit.frames.residual > most_left_of_small * residual) return false;

  return fit.bands_agree() && fit.code_agrees() && fit.no_seam() && fit.geometry_fits() &&
         fit.depths_fit() && fit.frames.residual <= before.frames.residual &&
         fit.misfit() < before.misfit();
}

double misfit_of_frames(Fit fit) {
  fit.geometry.reset();
  return fit.misfit();
}

/// Whether warnings about the method's limits remain after the mistake is undone.
bool leaves_warnings(const JudgedScan& scan, const Attempt& attempt) {
  const PossibleMistake& mistake = attempt.mistake;
  return with_model(scan, mistake, [&](const FrameModel& model, const FrameOrder& order) {
    ScanSamples samples = scan.samples;
    samples.reorder(order);

    const Sequence sequence = mistake.sequence.value_or(scan.sequence);
    const PhotometricCalibration photometry = mistake.photometry.value_or(scan.photometry);
    const Scanner* const scanner = mistake.scanner ? &*mistake.scanner : scan.scanner;

    return !method_limits({model, samples, sequence, scanner, photometry, scan.settings},
                          attempt.fit)
                .empty();
  });
}

/// The mistakes that may explain the scan, judged by a few groups of pixels.
std::vector<PossibleMistake> promising(const JudgedScan& scan,
                                       std::vector<PossibleMistake> mistakes) {
  constexpr std::size_t most = 32;

  std::vector<std::pair<double, std::size_t>> rough;
  const auto as_given = rough_misfit(scan, {});
  for (std::size_t i = 0; i < mistakes.size(); ++i) {
    mistakes[i].rank = i;
    const auto misfit = leaves_frames(mistakes[i]) ? as_given : rough_misfit(scan, mistakes[i]);
    if (misfit) rough.emplace_back(*misfit, i);
  }
  std::ranges::sort(rough);

  // Best first, one per family. Geometric ones leave the frames as they are, so that a rough misfit
  // of the frames cannot rank them: all stay.
  std::vector<PossibleMistake> left;
  std::set<int> families;
  for (const auto& [misfit, i] : rough) {
    const int family = mistakes[i].family;
    if (family > 0 && !families.insert(family).second) continue;
    if (left.size() < most || mistakes[i].geometric) left.push_back(std::move(mistakes[i]));
  }

  return left;
}

/// The mistakes that explain the scan, likeliest first: among about equal fits the simplest.
std::vector<Attempt> explaining(const JudgedScan& scan, const Fit& before,
                                std::vector<PossibleMistake> mistakes) {
  std::vector<Attempt> found;
  for (PossibleMistake& mistake : mistakes) {
    Fit fit = leaves_frames(mistake) ? before : fit_of(scan, mistake);
    if (leaves_frames(mistake)) fit.geometry = geometry_of(scan, mistake, scan.model, fit.frames);
    if (explains(fit, before, mistake)) found.push_back({std::move(mistake), fit, fit.misfit()});
  }

  std::ranges::sort(found, {}, [](const Attempt& attempt) {
    // Misfits within a step of this size count as equal.
    constexpr double alike = 0.3;
    return std::pair(std::floor(attempt.misfit / alike), attempt.mistake.rank);
  });

  return found;
}

}  // namespace

Explanation explanation_from(const std::vector<Attempt>& attempts, const FrameOrder& in_force) {
  constexpr double nearly = 1.2;
  constexpr std::size_t most_named = 3;

  // A usual mistake comes before a far-fetched one that fits hardly better.
  const auto usual = std::ranges::find_if(
      attempts, [](const Attempt& attempt) { return !attempt.mistake.far_fetched; });
  const bool is_usual =
      usual != attempts.end() && usual->misfit <= attempts.front().misfit + nearly;

  const Attempt& best = is_usual ? *usual : attempts.front();
  Explanation result{.misfit = best.misfit,
                     .causes = {best.mistake.cause},
                     .remedies = best.mistake.remedies,
                     .severity = best.mistake.severity};

  // Others that fit about as well: a few by name, one per family, the rest by number.
  std::set<int> families{0, best.mistake.family};
  std::size_t unnamed = 0;

  for (const auto& [other, fit, misfit] : attempts) {
    const bool is_named = std::ranges::count(result.causes, other.cause) > 0;
    if (is_named || misfit > best.misfit + nearly) continue;
    if (result.causes.size() == most_named || (is_usual && other.far_fetched) ||
        (other.family != 0 && families.contains(other.family))) {
      ++unnamed;
      continue;
    }

    families.insert(other.family);
    result.causes.push_back(other.cause);
    std::ranges::copy(other.remedies, std::back_inserter(result.remedies));
  }

  // Say how certain the explanation is.
  const bool alone = result.causes.size() == 1 && unnamed == 0;
  if (unnamed > 0) result.remark = fmt::format("{} more would fit as well; ", unnamed);
  if (!alone) result.remark += "all of these fit, so verify the result";
  if (best.mistake.scanner) {
    result.causes.push_back({CauseKind::other_rig, "a scanner file of another rig"});
  }

  // Repair only if the explanation is unique.
  if (alone && best.mistake.slipped) {
    result.order = best.mistake.order;
    if (best.fit.geometry) result.median_depth = best.fit.geometry->median_depth;
    result.severity = Severity::doubtful;

    const std::string order = text_of(composed(in_force, result.order));
    result.remedies = {{"the order " + order + " corrects this", {{"order", order}}}};
  }

  return result;
}

void give_causes(Explanation& explanation, Finding& finding) {
  finding.causes = std::move(explanation.causes);
  finding.remedies = std::move(explanation.remedies);
  finding.remark = std::move(explanation.remark);
}

Fit fit_of(const JudgedScan& scan, const PossibleMistake& mistake) {
  return with_model(scan, mistake, [&](const FrameModel& model, const FrameOrder& order) {
    Fit fit{.frames = FrameJudge(model)(scan.samples, order),
            .code = code_evidence(model, scan.samples, order),
            .moving = scan.settings.moving};

    if (!fit.patterns_made()) excuse_waveform(scan, model, order, fit);

    fit.code.doubt = fit.frames.doubt;
    // Without a code's edges the frames themselves show an error of the origin.
    if (!fit.code.has_edges) fit.code.offset = fit.frames.origin / two_pi;

    fit.geometry = geometry_of(scan, mistake, model, fit.frames);
    return fit;
  });
}

std::optional<Explanation> likeliest_mistake(const JudgedScan& scan, const Fit& as_given) {
  constexpr std::size_t few_groups = 128, most_proposed = 8, most_of_family = 4;
  constexpr double far_better = 0.5;

  // 1. With few pixels: the best mistakes, of each family a few.
  ScanSamples few = scan.samples;
  few.keep_first(few_groups);
  const JudgedScan quick{scan.model,      few,          scan.sequence, scan.scanner,
                         scan.photometry, scan.settings};

  std::vector<PossibleMistake> mistakes;
  std::multiset<int> families;
  for (Attempt& attempt :
       explaining(quick, fit_of(quick), promising(quick, possible_mistakes(scan, as_given)))) {
    const int family = attempt.mistake.family;
    if (mistakes.size() == most_proposed) break;
    if (family != 0 && families.count(family) == most_of_family) continue;
    families.insert(family);
    mistakes.push_back(std::move(attempt.mistake));
  }

  // 2. The few left must also pass with all pixels.
  std::vector<Attempt> found = explaining(scan, as_given, std::move(mistakes));

  // 3. Prefer mistakes that leave no warning, and good fits to poor ones.
  const auto warns = [&](const Attempt& attempt) { return leaves_warnings(scan, attempt); };
  if (!std::ranges::all_of(found, warns)) std::erase_if(found, warns);

  double best = std::numeric_limits<double>::infinity();  // misfit of good fits
  for (const Attempt& attempt : found) {
    if (!attempt.fit.poor()) best = std::min(best, attempt.misfit);
  }
  std::erase_if(
      found, [&](const Attempt& attempt) { return attempt.misfit > best && attempt.fit.poor(); });

  // 4. Geometry that may be of other pictures proves no setting that the frames do not.
  if (scan.scanner != nullptr && as_given.frames_fit() && is_off_centre(scan.scanner->camera)) {
    std::erase_if(found, [&](const Attempt& attempt) {
      return !attempt.mistake.geometric &&
             misfit_of_frames(attempt.fit) > misfit_of_frames(as_given) - far_better;
    });
  }

  // 5. A scan that fits as it is needs a far better explanation.
  if (as_given.all()) {
    std::erase_if(found, [&](const Attempt& attempt) {
      return attempt.mistake.far_fetched || attempt.misfit > as_given.misfit() - far_better;
    });
  }

  if (found.empty()) return std::nullopt;
  return explanation_from(found, scan.settings.order);
}

}  // namespace slipstream
