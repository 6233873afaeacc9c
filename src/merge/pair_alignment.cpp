#include "merge/pair_alignment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "base/parallel_rows.h"
#include "base/statistics.h"
#include "merge/consensus.h"

namespace slipstream {
namespace {

constexpr std::size_t fewest_matches = 200;
constexpr std::size_t sparse = 8;  // one sample of these many is enough to come near a pose

/// Distance up to which surfaces count as compared, mm.
float compared_distance(const PreparedView& first, const PreparedView& second) {
  return 3 * std::max(first.view().spacing, second.view().spacing);
}

/// How the samples of one view lie to the other's surface and camera.
struct Comparison {
  std::size_t samples = 0;
  std::size_t beside = 0;        ///< with the other's surface beside them
  std::size_t seen_through = 0;  ///< the other camera would have seen them and saw farther
  std::size_t still = 0;  ///< of these, with the other's surface beside them before any motion
};

/// `pose`: of `from` in the frame of `to`.
Comparison compare(const PreparedView& from, const PreparedView& to, const Eigen::Isometry3d& pose,
                   std::size_t step) {
  const SurfaceSamples source = fine_surface(from), target = fine_surface(to);
  const float farthest = compared_distance(from, to);
  const Eigen::Isometry3f motion = pose.cast<float>();

  // Sights are compared at a distance that neither noise nor a slanted surface reaches.
  const std::size_t samples = (source.sample.size() + step - 1) / step;
  enum class Fate : std::uint8_t { other, beside, seen_through, still };
  std::vector<Fate> fates(samples, Fate::other);
  for_each_row(static_cast<int>(samples), [&](int sample) {
    Fate& fate = fates[static_cast<std::size_t>(sample)];
    const std::uint32_t i = source.sample[static_cast<std::size_t>(sample) * step];
    const Eigen::Vector3f place = motion * source.points[i];
    if (partner_of(place, motion.linear() * source.normals[i], target, farthest)) {
      fate = Fate::beside;
    } else if (!target.grid->nearest(place, 2 * farthest) &&
               to.seen().at(place, 2 * farthest) == Sight::clear) {
      const bool still =
          partner_of(source.points[i], source.normals[i], target, farthest).has_value();
      fate = still ? Fate::still : Fate::seen_through;
    }
  });

  const auto count = [&](Fate fate) {
    return static_cast<std::size_t>(std::ranges::count(fates, fate));
  };
  return {.samples = samples,
          .beside = count(Fate::beside),
          .seen_through = count(Fate::seen_through) + count(Fate::still),
          .still = count(Fate::still)};
}

double share_of(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

/// Overlap, contradictions and distances at the alignment's pose, from every `step`-th point. The
/// number of matches and the information are those of all points.
void describe_fit(const PreparedView& first, const PreparedView& second, std::size_t step,
                  PairAlignment& alignment) {
  constexpr double off_surface = 6;  // standard deviations

  // 1. How each view's points lie to the other view.
  const Comparison of_second = compare(second, first, alignment.pose, step);
  const Comparison of_first = compare(first, second, alignment.pose.inverse(), step);
  alignment.overlap = std::max(share_of(of_second.beside, of_second.samples),
                               share_of(of_first.beside, of_first.samples));

  const std::size_t through = of_second.seen_through + of_first.seen_through;
  const std::size_t beside = of_second.beside + of_first.beside;
  alignment.contradictions = share_of(through, through + beside);

  // A pose that fits what moved contradicts points that stood still, and these meet the other view
  // without any motion. A pose that fits what stood still is hardly a motion.
  constexpr double most = 0.5;
  const double moved = largest_displacement(alignment.pose, Eigen::Isometry3d::Identity(),
                                            second.middle(), second.reach());
  alignment.moved_in_part = share_of(of_second.still + of_first.still, through) > most ||
                            (through > 0 && moved < first.keypoints().cell);

  // 2. The distances.
  const auto matches = match_surfaces(fine_surface(first), fine_surface(second), alignment.pose,
                                      compared_distance(first, second), step);
  const auto each = static_cast<double>(step);  // points that a compared one stands for
  alignment.matches = step * matches.size();
  if (matches.empty()) return;

  std::vector<double> sizes, sigmas;
  for (const SurfaceMatch& match : matches) {
    sizes.push_back(std::abs(match.distance));
    sigmas.push_back(match.sigma);
  }
  alignment.median = quantile(sizes, 0.5);
  alignment.percentile_95 = quantile(sizes, 0.95);
  alignment.noise = quantile(sigmas, 0.5) / deviation_from_median(1);

  // A little error beyond the noise is taken for granted: interpolation between points errs by a
  // twentieth of their spacing.
  const double spacing = std::max(first.view().spacing, second.view().spacing);
  const double interpolation = spacing / 20;
  std::size_t off = 0;
  Squares within;
  for (const SurfaceMatch& match : matches) {
    const double sigma = std::hypot(match.sigma, interpolation);
    if (std::abs(match.distance) > off_surface * sigma) {
      ++off;
    } else {
      within.add(match.distance * match.distance);
    }
  }
  alignment.misfits = share_of(off, matches.size());
  alignment.rms = within.rms();

  // 3. The information of the matches about the pose, as if only independent ones counted.
  alignment.centre = centre_of(matches);
  const SurfaceEquations equations = equations_of(matches, alignment.centre);
  PatchScatter scatter(patch_of(first));
  scatter.add(0, 1, alignment.pose, matches, alignment.centre, Matrix6::Identity());
  const double independent = each / scatter.matches_each();
  alignment.information = independent * equations.information;

  const WeakestMotion weakest = weakest_motion(equations, extent_of(matches, alignment.centre));

  // Interpolation errs by the same at all points of a side or an edge, so that a motion is not
  // known better than by it, however small the noise.
  const double noise = std::max(quantile(sigmas, 0.5), 1e-3 * interpolation);
  alignment.weakest_sigma =
      weakest.sigma / std::sqrt(independent) * std::hypot(1, interpolation / noise);
  alignment.weakest_slope = weakest.slope;
}

/// Sets why the pose is refused, or that it is joined.
void judge(const AlignmentSettings& settings, double reach, PairAlignment& alignment) {
  const auto refuse = [&](Refusal refusal, std::string reason) {
    alignment.refusal = refusal;
    alignment.reason = std::move(reason);
  };

  if (alignment.overlap < settings.least_overlap) {
    refuse(Refusal::no_overlap,
           fmt::format("they share only {:.0f} % of the surface of the smaller one; {:.0f} % or "
                       "more is needed",
                       100 * alignment.overlap, 100 * settings.least_overlap));
  } else if (alignment.matches < fewest_matches) {
    refuse(Refusal::no_overlap, fmt::format("they share only {} points; {} or more are needed",
                                            alignment.matches, fewest_matches));
  } else if (alignment.contradictions > settings.most_contradictions) {
    refuse(Refusal::sees_through,
           fmt::format("one camera sees through {:.1f} % of the other's surface{}",
                       100 * alignment.contradictions,
                       alignment.moved_in_part
                           ? ": a part of the scene moved between the views, and the rest did not"
                           : ""));
  } else if (alignment.misfits > settings.most_misfits) {
    refuse(Refusal::misfit,
           fmt::format("{:.0f} % of the common surface differ by more than the noise, in the "
                       "median by {:.3g} mm",
                       100 * alignment.misfits, alignment.median));
  } else if (alignment.weakest_slope < settings.least_slope) {
    refuse(Refusal::slides,
           fmt::format("their common surface fits as well when it slides or turns along itself, "
                       "as a plane, sphere, cylinder or corridor does (slope {:.3f}, {:.3f} or "
                       "more is needed)",
                       alignment.weakest_slope, settings.least_slope));
  } else if (alignment.weakest_sigma > settings.most_uncertain * reach) {
    refuse(Refusal::slides,
           fmt::format("their common surface leaves a motion along itself uncertain by {:.2g} mm; "
                       "{:.2g} mm or less is needed",
                       alignment.weakest_sigma, settings.most_uncertain * reach));
  } else {
    refuse(Refusal::none, {});
  }
}

/// Compared points that speak for the pose, less those against it.
double score_of(const PairAlignment& alignment) {
  const auto matches = static_cast<double>(alignment.matches);
  const double against = alignment.misfits + 10 * alignment.contradictions;
  return matches * std::max(1 - 3 * against, 0.0);
}

PairAlignment fitted(const PreparedView& first, const PreparedView& second,
                     const Eigen::Isometry3d& start, std::size_t step, int rounds) {
  const float spacing = std::max(first.view().spacing, second.view().spacing);
  const float cell = first.keypoints().cell;
  const float nearest = std::min(3 * spacing, cell);
  const SurfaceSamples one = fine_surface(first), other = fine_surface(second);
  PairAlignment alignment;

  // Comes near the pose with a part of the points, and settles with every `step`-th.
  alignment.pose = settled_pose(one, other, start, cell, nearest, rounds, std::max(step, sparse));
  if (step < sparse) {
    alignment.pose = settled_pose(one, other, alignment.pose, nearest, nearest, rounds, step);
  }

  describe_fit(first, second, step, alignment);
  return alignment;
}

/// Brings a rough pose to about a third of a keypoint's cell.
Eigen::Isometry3d roughly_settled(const PreparedView& first, const PreparedView& second,
                                  const Eigen::Isometry3d& start) {
  constexpr int rounds = 10;
  constexpr std::size_t step = 3;
  const float cell = first.keypoints().cell;
  return settled_pose(coarse_surface(first), coarse_surface(second), start, 3 * cell, cell, rounds,
                      step);
}

/// Refines a pose with a part of the points; adds it if it is distinct from the others.
void add_fit(const PreparedView& first, const PreparedView& second, const Eigen::Isometry3d& start,
             std::vector<PairAlignment>& fits) {
  constexpr int rounds = 8;
  constexpr double distinct = 3;          // cells
  constexpr double least_to_go_on = 0.2;  // of the best overlap so far

  const auto is_known = [&](const Eigen::Isometry3d& pose) {
    return std::any_of(fits.begin(), fits.end(), [&](const PairAlignment& other) {
      return largest_displacement(pose, other.pose, second.middle(), second.reach()) <
             distinct * first.keypoints().cell;
    });
  };
  const Eigen::Isometry3d rough = roughly_settled(first, second, start);
  if (is_known(rough)) return;

  double best = 0;
  for (const PairAlignment& other : fits) best = std::max(best, other.overlap);
  if (overlap_at(first, second, rough) < least_to_go_on * best) return;

  const PairAlignment fit = fitted(first, second, rough, sparse, rounds);
  if (!is_known(fit.pose)) fits.push_back(fit);
}

void put_best_first(std::vector<PairAlignment>& fits) {
  std::stable_sort(fits.begin(), fits.end(), [](const PairAlignment& a, const PairAlignment& b) {
    return score_of(a) > score_of(b);
  });
}

/// Refuses the best of the fits if another is about as good.
void refuse_if_repeated(const PreparedView& second, const AlignmentSettings& settings,
                        const std::vector<PairAlignment>& fits, PairAlignment& best) {
  // A pose that leaves the surface free to slide has less to say.
  constexpr double alike_if_sliding = 0.75;

  const double score = score_of(fits.front());
  for (std::size_t k = 1; k < fits.size(); ++k) {
    PairAlignment other = fits[k];
    judge(settings, second.reach(), other);
    const bool slides = other.refusal == Refusal::slides;
    if (!other.joined() && !slides) continue;
    if (score_of(other) < (slides ? alike_if_sliding : settings.alike) * score) continue;

    best.refusal = Refusal::repeats;
    best.reason = fmt::format(
        "another pose, {:.0f} mm away, fits as well: their common surface repeats itself or is "
        "symmetric",
        largest_displacement(best.pose, other.pose, second.middle(), second.reach()));
    return;
  }
}

}  // namespace

std::string_view name_of(Refusal refusal) {
  static constexpr std::array<std::string_view, 6> names{"none",   "no overlap", "sees through",
                                                         "misfit", "slides",     "repeats"};
  return names[static_cast<std::size_t>(refusal)];
}

PairAlignment align_views(const PreparedView& first, const PreparedView& second,
                          const AlignmentSettings& settings) {
  constexpr std::size_t most_correspondences = 2500, most_poses = 20;

  // 1. A surface that slides along itself leaves no pose to find.
  PairAlignment best;
  const bool first_slides = first.weakest_slope() < 0.75 * settings.least_slope;
  if (first_slides || second.weakest_slope() < 0.75 * settings.least_slope) {
    best.refusal = Refusal::slides;
    best.reason = fmt::format(
        "the surface of {} fits as well when it slides or turns along itself, as a plane, sphere "
        "or "
        "cylinder does",
        first_slides ? first.view().name : second.view().name);
    return best;
  }

  // 2. Poses that similar features agree on, each refined by the distances of the surfaces.
  const auto similar =
      similar_keypoints(first.keypoints(), second.keypoints(), most_correspondences);
  const auto starts = consensus_poses(first.keypoints(), second.keypoints(), similar, most_poses);
  std::vector<PairAlignment> fits;
  for (const ConsensusPose& start : starts) add_fit(first, second, start.pose, fits);
  if (fits.empty()) {
    best.reason = "no common shape was found";
    return best;
  }
  put_best_first(fits);

  // 3. The poses that a symmetry of a view makes similar.
  const Eigen::Isometry3d found = fits.front().pose;
  for (const Eigen::Isometry3d& symmetry : second.symmetries()) {
    add_fit(first, second, found * symmetry, fits);
  }
  for (const Eigen::Isometry3d& symmetry : first.symmetries()) {
    add_fit(first, second, symmetry * found, fits);
  }
  put_best_first(fits);

  // 4. The best once more, with all points. No other may fit about as well.
  best = fitted(first, second, fits.front().pose, 1, 40);
  judge(settings, first.reach(), best);
  if (best.joined()) refuse_if_repeated(second, settings, fits, best);
  return best;
}

PairAlignment refine_alignment(const PreparedView& first, const PreparedView& second,
                               const Eigen::Isometry3d& start, const AlignmentSettings& settings) {
  PairAlignment alignment = fitted(first, second, roughly_settled(first, second, start), 1, 40);
  judge(settings, first.reach(), alignment);
  return alignment;
}

PairAlignment alignment_at(const PreparedView& first, const PreparedView& second,
                           const Eigen::Isometry3d& pose, const AlignmentSettings& settings) {
  PairAlignment alignment;
  alignment.pose = pose;
  describe_fit(first, second, 1, alignment);
  judge(settings, first.reach(), alignment);
  return alignment;
}

double overlap_at(const PreparedView& first, const PreparedView& second,
                  const Eigen::Isometry3d& pose) {
  constexpr std::size_t step = 20;
  const Comparison of_second = compare(second, first, pose, step);
  const Comparison of_first = compare(first, second, pose.inverse(), step);
  return std::max(share_of(of_second.beside, of_second.samples),
                  share_of(of_first.beside, of_first.samples));
}

double rough_overlap_at(const PreparedView& first, const PreparedView& second,
                        const Eigen::Isometry3d& pose) {
  constexpr std::size_t step = 5;
  constexpr float farthest = 3;  // cells
  const float cell = first.keypoints().cell;
  const auto matches =
      match_surfaces(coarse_surface(first), coarse_surface(second), pose, farthest * cell, step);

  // The keypoints of both views are matched.
  const std::size_t fewer =
      std::min(first.keypoints().points.size(), second.keypoints().points.size());
  return std::min(share_of(step * matches.size(), 2 * fewer), 1.0);
}

}  // namespace slipstream
