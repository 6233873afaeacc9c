#include "reconstruct/camera_orders.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <vector>

#include <hwy/cache_control.h>

#include "base/numbers.h"
#include "base/parallel_rows.h"
#include "decode/band_unwrapper.h"
#include "geometry/stripe_geometry.h"
#include "reconstruct/fused/match_rows.h"
#include "slipstream/unwrapping.h"

namespace slipstream {
namespace {

/// Half width of a window, pixels: 225 pixels of a vote of up to 8192 do not overflow.
constexpr int reach = 7;

/// Votes of a pixel are stored in groups of as many, so that they are summed several at a time.
constexpr int group = 4;

/// The only candidate that fits; -1 if there is none.
int best_order(const std::uint32_t* votes, int count) {
  constexpr float fits = 0.1F;      // mean for phases half a radian apart
  constexpr float clearly = 0.15F;  // margin to the second best
  constexpr std::uint32_t one_pixel = Disagreement::one_pixel;
  constexpr std::uint32_t fewest = 40;  // regions of fewer pixels may match by chance

  // The high bits count the pixels that are seen: at least half of the most.
  std::uint32_t most = 0;
  for (int k = 0; k < count; ++k) most = std::max(most, votes[k]);
  const std::uint32_t enough = std::max(fewest, (most / one_pixel + 1) / 2) * one_pixel;

  // Most candidates are so bad that they change nothing, and cost no division.
  int best = -1;
  float least = fits + 2 * clearly, second = least;
  for (int k = 0; k < count; ++k) {
    if (votes[k] < enough) continue;
    const auto [sum, seen] = Disagreement(votes[k]);
    if (sum >= second * seen) continue;

    const float mean = sum / seen;
    if (mean < least) {
      second = least;
      least = mean;
      best = k;
    } else {
      second = mean;
    }
  }

  return least < fits && second > least + clearly ? best : -1;
}

/// std::floor of a number that fits into an int, without a call.
int whole_below(float number) {
  const int cut = static_cast<int>(number);  // towards zero
  return static_cast<float>(cut) > number ? cut - 1 : cut;
}

/// One line of pixels through the image.
struct Line {
  Line(const CameraPhases& camera, const Image<float>& phase, bool along_row, int number)
      : validity(along_row ? camera.validity.row(number) : camera.validity.begin() + number),
        phi(along_row ? phase.row(number) : phase.begin() + number),
        first(along_row ? number * phase.width() : number),
        stride(along_row ? 1 : phase.width()),
        length(along_row ? phase.width() : phase.height()) {}

  /// Index in the image of pixel i of the line.
  [[nodiscard]] std::size_t pixel(int i) const {
    return static_cast<std::size_t>(first + i * stride);
  }

  [[nodiscard]] bool is_valid(int i) const { return validity[i * stride] == Validity::valid; }

  /// Whole periods from pixel i - 1 to i; nullopt where the phase is not continuous.
  [[nodiscard]] std::optional<int> turn_before(int i) const {
    // A step of more than half a turn is the jump of a wrapped phase.
    const float rise = phi[i * stride] - phi[(i - 1) * stride];
    const int turn = rise > std::numbers::pi_v<float>    ? -1
                     : rise < -std::numbers::pi_v<float> ? 1
                                                         : 0;

    // Still more than a quarter turn: an edge of a surface.
    const float step = rise + static_cast<float>(two_pi) * static_cast<float>(turn);
    if (!(std::abs(step) < std::numbers::pi_v<float> / 2)) return std::nullopt;
    return turn;
  }

  const Validity* validity;
  const float* phi;
  int first;  ///< index in the image of its first pixel
  int stride, length;
};

/// Memory of a thread for the sums of a line.
struct LineMemory {
  std::vector<int> shift{};             ///< first candidate of each pixel
  std::vector<std::uint32_t> window{};  ///< running sums, one for each order
};

/// Sums the votes of up to `reach` pixels on either side of each pixel of a line, order by order,
/// as far as the phase continues. `votes(i)`: the first of pixel i, 0 for further candidates than
/// it has. Calls `take(i, sums)` for each valid pixel.
template <class Votes, class Take>
class LineSums {
 public:
  LineSums(const Line& line, const CandidateOrders& candidates, const Votes& votes,
           const Take& take, LineMemory& memory)
      : line_(line),
        candidates_(candidates),
        votes_(votes),
        take_(take),
        shift_(memory.shift),
        window_(memory.window) {
    shift_.resize(static_cast<std::size_t>(line.length));
  }

  void sum() {
    for (int begin = 0, end = 0; begin < line_.length; begin = end) {
      end = begin + 1;
      if (!line_.is_valid(begin)) continue;

      end = place_candidates(begin);
      move_window(begin, end);
    }
  }

 private:
  /// Finds the first candidate of each pixel over which the phase continues from `begin` on,
  /// counted from the order of the first pixel, and clears the window for them. Returns the end.
  int place_candidates(int begin) {
    int turns = 0, least = 0, most = 0;
    const auto place = [&](int i) {
      const int first = candidates_.first.begin()[line_.pixel(i)] - turns;
      shift_[i] = first;
      least = i == begin ? first : std::min(least, first);
      most = i == begin ? first : std::max(most, first);
    };

    place(begin);
    int end = begin + 1;
    for (; end < line_.length && line_.is_valid(end); ++end) {
      const auto turn = line_.turn_before(end);
      if (!turn) break;
      turns += *turn;
      place(end);
    }

    least_ = least;
    window_.assign(static_cast<std::size_t>(most - least + candidates_.most), 0);
    return end;
  }

  /// The sums of a window that moves over the pixels [begin, end): adds the pixel that enters it
  /// and subtracts the one that leaves.
  void move_window(int begin, int end) {
    // Votes along a column are far apart in memory: fetch them before they are needed.
    constexpr int ahead = 24;

    for (int i = begin; i < std::min(end, begin + reach); ++i) change(i, true);
    for (int i = begin; i < end; ++i) {
      const std::uint32_t* const next = votes_(std::min(i + ahead, line_.length - 1));
      hwy::Prefetch(next);
      hwy::Prefetch(next + candidates_.most - 1);

      if (i + reach < end) change(i + reach, true);
      if (i - reach > begin) change(i - reach - 1, false);

      take_(i, window_.data() + (shift_[i] - least_));
    }
  }

  /// Subtracts by adding 0 - votes, modulo 2^32: the sums stay exact.
  void change(int i, bool enters) {
    const std::uint32_t* votes = votes_(i);
    std::uint32_t* sums = window_.data() + (shift_[i] - least_);

    // A copy, as the compiler would read the number again after each store.
    const int most = candidates_.most;
    for (int k = 0; k < most; k += group, votes += group, sums += group) {
      std::array<std::uint32_t, group> changed{};
      for (int j = 0; j < group; ++j) changed[j] = sums[j] + (enters ? votes[j] : 0 - votes[j]);
      std::ranges::copy(changed, sums);
    }
  }

  const Line& line_;
  const CandidateOrders& candidates_;
  const Votes& votes_;
  const Take& take_;

  std::vector<int>& shift_;
  int least_ = 0;  ///< the least of the shifts, and the order at which the window begins
  std::vector<std::uint32_t>& window_;
};

template <class Votes, class Take>
void sum_line(const CameraPhases& camera, const Image<float>& phase, bool along_row, int number,
              const CandidateOrders& candidates, const Votes& votes, const Take& take) {
  thread_local LineMemory memory;
  const Line line(camera, phase, along_row, number);
  LineSums(line, candidates, votes, take, memory).sum();
}

}  // namespace

CameraOrders::CameraOrders(const EpipolarTables& tables, double periods, const DepthRange& depths,
                           bool of_other, int length)
    : tables_(tables),
      periods_(static_cast<float>(periods)),
      depths_(depths),
      of_other_(of_other),
      bounds_(tables.size()),
      coordinate_(tables.size()) {
  const double end = 1 + farthest_past_field(length);
  for_each_pixel(tables.size(), [&](int column, int row) {
    // Without a range, or where it begins behind the projector: the whole field.
    double least = 0, largest = end;
    if (!tables.has_ray(column, row)) {
      largest = -1;
    } else if (depths.nearest > 0 && std::isfinite(depths.farthest)) {
      const auto coordinate = [&](double depth) {
        return tables.coordinate_at(column, row, tables.inverse_of(column, row, depth, of_other));
      };
      const double near = coordinate(depths.nearest), far = coordinate(depths.farthest);
      if (std::isfinite(near) && std::isfinite(far)) {
        least = std::max(0.0, std::min(near, far));
        largest = std::min(end, std::max(near, far));
      }
    }

    bounds_(column, row) = {static_cast<float>(least * periods),
                            static_cast<float>(largest * periods)};
  });

  candidates_.first = Image<std::int16_t>(tables.size());
  candidates_.count = Image<std::int16_t>(tables.size());

  // Whole numbers in the widest range between bounds, and in the field.
  float widest = 0;
  for (const auto& [least, largest] : bounds_) widest = std::max(widest, largest - least);
  const float most = std::min({widest + 1, std::ceil(periods_), 255.0F - group});
  candidates_.most = (static_cast<int>(most) + group - 1) / group * group;
  const auto [width, height] = tables.size();
  sums_.resize(at(width - 1, height - 1) + static_cast<std::size_t>(candidates_.most));
}

const Image<float>& CameraOrders::operator()(const CameraPhases& camera, const Image<float>& phase,
                                             const CameraPhases& other) {
  const int most = candidates_.most;

  // 1. Votes of each row's pixels, summed along it.
  for_each_row(phase.height(), [&](int row) {
    thread_local PointPhases points;
    find_candidates(camera, phase, row, points);
    compare_phases(tables_.lines(), camera, other, depths_, of_other_, points);

    const auto votes = [most, all = points.votes.data()](int column) {
      return all + column * most;
    };
    const auto keep = [&, most](int column, const std::uint32_t* sums) {
      std::uint32_t* const to = sums_.data() + at(column, row);
      const int count = candidates_.count(column, row);
      for (int k = 0; k < most; ++k) to[k] = k < count ? sums[k] : 0;
    };
    sum_line(camera, phase, true, row, candidates_, votes, keep);
  });

  // 2. Those sums, summed along each column, and the order that they choose.
  std::ranges::fill(coordinate_, std::numeric_limits<float>::quiet_NaN());
  for_each_row(phase.width(), [&](int column) {
    const auto votes = [&](int row) { return sums_.data() + at(column, row); };
    const auto choose = [&](int row, const std::uint32_t* sums) {
      const int k = best_order(sums, candidates_.count(column, row));
      if (k < 0) return;
      coordinate_(column, row) = static_cast<float>(
          unwrapped_coordinate(phase(column, row), candidates_.first(column, row) + k, periods_));
    };
    sum_line(camera, phase, false, column, candidates_, votes, choose);
  });

  return coordinate_;
}

/// The candidates of a row, and their first points.
void CameraOrders::find_candidates(const CameraPhases& camera, const Image<float>& phase, int row,
                                   PointPhases& points) {
  const auto width = static_cast<std::size_t>(phase.width());
  points.step = 1 / periods_;
  points.most = candidates_.most;
  points.pixels.resize(width);
  points.coordinates.assign(width, 0);
  points.counts.assign(width, 0);
  std::iota(points.pixels.begin(), points.pixels.end(), row * phase.width());

  const int last_in_field = static_cast<int>(std::ceil(periods_)) - 1;
  for (int column = 0; column < phase.width(); ++column) {
    if (camera.validity(column, row) != Validity::valid) continue;
    const float turn = phase(column, row) / static_cast<float>(two_pi);
    const auto [least, largest] = bounds_(column, row);

    // Orders k for which turn + k lies between the bounds and in the field.
    const int first = std::max(0, -whole_below(turn - least));
    const int last = std::min(last_in_field, whole_below(largest - turn));
    const int count = std::clamp(last - first + 1, 0, candidates_.most);

    candidates_.first(column, row) = static_cast<std::int16_t>(first);
    candidates_.count(column, row) = static_cast<std::int16_t>(count);
    points.counts[column] = count;
    points.coordinates[column] = (turn + static_cast<float>(first)) / periods_;
  }
}

}  // namespace slipstream
