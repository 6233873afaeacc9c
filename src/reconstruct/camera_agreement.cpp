#include "reconstruct/camera_agreement.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "base/numbers.h"
#include "decode/surface_orders.h"
#include "reconstruct/fused/match_rows.h"

namespace slipstream {
namespace {

/// Pixels of a surface, spread evenly, with their orders up to one number.
struct SurfaceSample {
  struct Pixel {
    int column, row, order;
  };

  std::vector<Pixel> pixels;
  std::size_t lit = 0;  ///< pixels of the whole surface
};

std::vector<SurfaceSample> large_surfaces(const Image<float>& phase) {
  // Pixels: a smaller surface may fit a wrong order by chance; 2000 are enough of a large one.
  constexpr std::size_t fewest = 1500, sampled = 2000;
  std::vector<SurfaceSample> samples;
  SurfaceOrders orders;

  // This pass only collects samples; no surface gets a final order.
  orders(phase, [&](const ConnectedSurface& surface) -> std::optional<int> {
    if (surface.pixels < fewest) return std::nullopt;

    const std::size_t every = std::max<std::size_t>(1, surface.pixels / sampled);
    SurfaceSample& sample = samples.emplace_back();
    sample.lit = surface.pixels;

    std::size_t seen = 0;
    surface.for_each([&](int column, int row, int order) {
      if (seen++ % every == 0) sample.pixels.push_back({column, row, order});
    });

    return std::nullopt;
  });

  return samples;
}

/// How well a surface fits with one number added to its orders.
struct Fit {
  int shift = 0;
  double misfit = 2;  ///< mean of 1 - cos of the phases' difference
  double next = 2;    ///< of the best other shift

  [[nodiscard]] bool is_clear() const {
    constexpr double fits = 0.1, clearly = 0.15;  // as for a window, see CameraOrders
    return misfit < fits && next > misfit + clearly;
  }
};

class Agreement {
 public:
  Agreement(const EpipolarTables& tables, double periods, const DepthRange& set,
            const Image<float>& phase, const CameraPhases& first, const CameraPhases& second)
      : tables_(tables),
        periods_(periods),
        set_(set),
        phase_(phase),
        first_(first),
        second_(second) {}

  /// Inverse depth of a pixel; nullopt outside the field and the depths.
  [[nodiscard]] std::optional<float> inverse_depth(const SurfaceSample::Pixel& pixel, int shift,
                                                   double phase_shift) const {
    const double turns = (phase_(pixel.column, pixel.row) + phase_shift) / two_pi;
    const double y = (turns + pixel.order + shift) / periods_;

    const float w = tables_.inverse_depth(pixel.column, pixel.row, static_cast<float>(y));
    const bool possible =
        y >= 0 && y <= 1 && w > 0 && 1 / w > set_.nearest && 1 / w < set_.farthest;
    return possible ? std::optional(w) : std::nullopt;
  }

  /// The best shift of a surface's orders, among all for which half of it can be there and is seen.
  [[nodiscard]] Fit best(const SurfaceSample& surface, double phase_shift) const {
    const auto [low, high] =
        std::ranges::minmax_element(surface.pixels, {}, &SurfaceSample::Pixel::order);

    // 1. The pixels' points with all shifts that keep at least one pixel's order inside the field.
    const int first = -high->order, last = static_cast<int>(std::ceil(periods_)) - low->order;
    PointPhases points{.step = static_cast<float>(1 / periods_), .most = last - first + 1};
    for (const auto& [column, row, order] : surface.pixels) {
      const double turns = (phase_(column, row) + phase_shift) / two_pi;
      points.pixels.push_back(row * phase_.width() + column);
      points.coordinates.push_back(static_cast<float>((turns + order + first) / periods_));
    }
    points.counts.assign(points.pixels.size(), points.most);
    compare_phases(tables_.lines(), first_, second_, set_, false, points);

    // 2. The mean misfit of each shift.
    Fit best;
    const std::uint32_t* votes = points.votes.data();
    for (int shift = first; shift <= last; ++shift, ++votes) {
      double sum = 0;
      int seen = 0;
      for (std::size_t i = 0; i < surface.pixels.size(); ++i) {
        const double y = points.coordinates[i] + (shift - first) / periods_;
        const std::uint32_t vote = votes[i * static_cast<std::size_t>(points.most)];
        if (y < 0 || y > 1 || vote == 0) continue;
        sum += Disagreement(vote).sum;
        ++seen;
      }

      if (2 * seen < static_cast<int>(surface.pixels.size())) continue;

      const double misfit = sum / seen;
      if (misfit < best.misfit) {
        best = {.shift = shift, .misfit = misfit, .next = best.misfit};
      } else {
        best.next = std::min(best.next, misfit);
      }
    }

    return best;
  }

 private:
  const EpipolarTables& tables_;
  double periods_;
  DepthRange set_;
  const Image<float>& phase_;
  const CameraPhases &first_, &second_;
};

/// Depths of the surfaces that fit, with a margin for others beside them.
DepthRange depths_of(const Agreement& agreement, const std::vector<SurfaceSample>& surfaces,
                     const std::vector<Fit>& fits, double phase_shift, const DepthRange& set) {
  std::vector<float> inverse;
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    if (!fits[i].is_clear()) continue;
    for (const SurfaceSample::Pixel& pixel : surfaces[i].pixels) {
      if (const auto w = agreement.inverse_depth(pixel, fits[i].shift, phase_shift))
        inverse.push_back(*w);
    }
  }

  // The extremes without half a percent of the pixels at either end.
  std::ranges::sort(inverse);
  const double nearest = 1 / inverse[inverse.size() - 1 - inverse.size() / 200];
  const double farthest = 1 / inverse[inverse.size() / 200];

  // Half of the depth found on both sides, for flat scenes 4 % of the distance.
  const double margin = std::max(0.5 * (farthest - nearest), 0.04 * farthest);
  return {std::max(set.nearest, nearest - margin), std::min(set.farthest, farthest + margin)};
}

}  // namespace

std::optional<CameraAgreement> camera_agreement(const EpipolarTables& tables, double periods,
                                                const DepthRange& set, const Image<float>& phase,
                                                const CameraPhases& first,
                                                const CameraPhases& second) {
  const std::vector<SurfaceSample> surfaces = large_surfaces(phase);
  const Agreement agreement(tables, periods, set, phase, first, second);

  std::vector<Fit> fits(surfaces.size());
  std::size_t lit = 0;
  for (const SurfaceSample& surface : surfaces) lit += surface.lit;

  /// Pixels of the surfaces that fit with this shift of the phase.
  const auto fitting = [&](double phase_shift) {
    std::size_t pixels = 0;
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
      fits[i] = agreement.best(surfaces[i], phase_shift);
      if (fits[i].is_clear()) pixels += surfaces[i].lit;
    }
    return pixels;
  };

  // 1. The origin as given.
  constexpr double most = 0.5;  // of the light of large surfaces
  const auto enough = [&](std::size_t pixels) {
    return pixels > 0 && static_cast<double>(pixels) > most * static_cast<double>(lit);
  };
  if (enough(fitting(0))) return CameraAgreement{0, depths_of(agreement, surfaces, fits, 0, set)};

  // 2. Every other one: the one that fits best.
  constexpr int tried = 24;
  std::map<double, double> misfits;  // of the fitting surfaces, by phase shift
  for (int i = 1; i < tried; ++i) {
    const double shift = std::remainder(two_pi * i / tried, two_pi);
    if (!enough(fitting(shift))) continue;

    // The mean misfit of the surfaces that fit, weighted by their pixels.
    double sum = 0, weight = 0;
    for (std::size_t k = 0; k < surfaces.size(); ++k) {
      if (!fits[k].is_clear()) continue;
      const auto pixels = static_cast<double>(surfaces[k].lit);
      sum += pixels * fits[k].misfit;
      weight += pixels;
    }
    misfits[shift] = sum / weight;
  }

  if (misfits.empty()) return std::nullopt;
  const auto best = std::ranges::min_element(misfits, {}, [](const auto& of) { return of.second; });

  const double shift = best->first;

  // Each attempt overwrites the fits: find those of the best one again.
  fitting(shift);
  return CameraAgreement{shift, depths_of(agreement, surfaces, fits, shift, set)};
}

}  // namespace slipstream
