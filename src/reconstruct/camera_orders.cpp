#include "reconstruct/camera_orders.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

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
constexpr float vote_step = 1 / 4096.0F;
constexpr std::uint32_t one_pixel = 1U << 24U;

/// A vote or a sum of votes.
struct Disagreement {
  explicit Disagreement(std::uint32_t votes)
      : sum(vote_step * static_cast<float>(votes % one_pixel)),
        seen(static_cast<float>(votes / one_pixel)) {}

  float sum, seen;
};

/// The only candidate that fits; -1 if there is none.
int best_order(const std::uint32_t* votes, int count) {
  constexpr float fits = 0.1F;      // mean for phases half a radian apart
  constexpr float clearly = 0.15F;  // margin to the second best
  constexpr float fewest = 40;      // regions of fewer pixels may match by chance

  float most = 0;
  for (int k = 0; k < count; ++k) most = std::max(most, Disagreement(votes[k]).seen);

  int best = -1;
  float least = 2, second = 2;
  for (int k = 0; k < count; ++k) {
    const auto [sum, seen] = Disagreement(votes[k]);
    if (seen < std::max(fewest, 0.5F * most)) continue;
    const float mean = sum / seen;
    if (mean < least) {
      second = least;
      least = mean;
      best = k;
    } else {
      second = std::min(second, mean);
    }
  }

  return least < fits && second > least + clearly ? best : -1;
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

/// Sums the votes of up to `reach` pixels on either side of each pixel of a line, order by order,
/// as far as the phase continues.
class LineSums {
 public:
  LineSums(const Line& line, const CandidateOrders& candidates,
           const std::vector<std::uint32_t>& votes, std::vector<std::uint32_t>& summed)
      : line_(line),
        candidates_(candidates),
        votes_(votes),
        summed_(summed),
        shift_(static_cast<std::size_t>(line.length)) {}

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
    for (int i = begin; i < std::min(end, begin + reach); ++i) change(i, true);
    for (int i = begin; i < end; ++i) {
      if (i + reach < end) change(i + reach, true);
      if (i - reach > begin) change(i - reach - 1, false);

      std::copy_n(window_.begin() + (shift_[i] - least_), count(i),
                  summed_.begin() + static_cast<std::ptrdiff_t>(index(i)));
    }
  }

  /// Subtracts by adding 0 - votes, modulo 2^32: the sums stay exact.
  void change(int i, bool enters) {
    const std::uint32_t* const votes = votes_.data() + index(i);
    std::uint32_t* const sums = window_.data() + (shift_[i] - least_);
    const int candidates = count(i);
    for (int k = 0; k < candidates; ++k) sums[k] += enters ? votes[k] : 0 - votes[k];
  }

  /// Number of candidates of pixel i of the line.
  [[nodiscard]] int count(int i) const { return candidates_.count.begin()[line_.pixel(i)]; }

  /// Where its votes begin.
  [[nodiscard]] std::size_t index(int i) const {
    return line_.pixel(i) * static_cast<std::size_t>(candidates_.most);
  }

  const Line& line_;
  const CandidateOrders& candidates_;
  const std::vector<std::uint32_t>& votes_;
  std::vector<std::uint32_t>& summed_;

  std::vector<int> shift_;             ///< first candidate of each pixel
  int least_ = 0;                      ///< the least of these
  std::vector<std::uint32_t> window_;  ///< running sums, one for each order from `least_` on
};

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
  candidates_.count = Image<std::uint8_t>(tables.size());
}

const Image<float>& CameraOrders::operator()(const CameraPhases& camera, const Image<float>& phase,
                                             const CameraPhases& other) {
  find_candidates(camera, phase);
  vote(camera, phase, other);
  sum_windows(camera, phase, true);
  sum_windows(camera, phase, false);

  for_each_pixel(phase.size(), [&](int column, int row) {
    const int k = best_order(votes_.data() + at(column, row), candidates_.count(column, row));
    coordinate_(column, row) =
        k < 0 ? std::numeric_limits<float>::quiet_NaN()
              : static_cast<float>(unwrapped_coordinate(
                    phase(column, row), candidates_.first(column, row) + k, periods_));
  });

  return coordinate_;
}

void CameraOrders::find_candidates(const CameraPhases& camera, const Image<float>& phase) {
  // Largest count of each row: rows are visited in parallel.
  std::vector<int> most(static_cast<std::size_t>(phase.height()));
  for_each_pixel(phase.size(), [&](int column, int row) {
    const float turn = phase(column, row) / static_cast<float>(two_pi);
    const Bounds& bounds = bounds_(column, row);

    // Orders k for which turn + k lies between the bounds and in the field.
    const int first = std::max(0, static_cast<int>(std::ceil(bounds.least - turn)));
    const int last = std::min(static_cast<int>(std::ceil(periods_)) - 1,
                              static_cast<int>(std::floor(bounds.largest - turn)));

    const bool valid = camera.validity(column, row) == Validity::valid;
    const int count = valid ? std::max(0, last - first + 1) : 0;
    candidates_.first(column, row) = static_cast<std::int16_t>(first);
    candidates_.count(column, row) = static_cast<std::uint8_t>(std::min(count, 255));
    most[row] = std::max(most[row], count);
  });

  candidates_.most = std::min(255, *std::ranges::max_element(most));
}

void CameraOrders::vote(const CameraPhases& camera, const Image<float>& phase,
                        const CameraPhases& other) {
  const std::size_t size = phase.pixel_count() * static_cast<std::size_t>(candidates_.most);
  votes_.resize(size);
  summed_.resize(size);

  for_each_row(phase.height(), [&](int row) {
    // 1. The first candidates of a row's pixels.
    PointPhases points{.step = 1 / periods_, .points = candidates_.most};
    std::vector<int> columns;
    for (int column = 0; column < phase.width(); ++column) {
      if (candidates_.count(column, row) == 0) continue;
      columns.push_back(column);
      points.pixels.push_back(row * phase.width() + column);
      points.coordinates.push_back(static_cast<float>(
          unwrapped_coordinate(phase(column, row), candidates_.first(column, row), periods_)));
    }

    // 2. A vote of each candidate that the other camera sees in the depth range.
    compare_phases(tables_.lines(), camera, other, depths_, of_other_, points);
    for (std::size_t i = 0; i < columns.size(); ++i) {
      std::uint32_t* const votes = votes_.data() + at(columns[i], row);
      for (int k = 0; k < candidates_.count(columns[i], row); ++k) {
        const float apart = points.apart[static_cast<std::size_t>(k) * points.pixels.size() + i];
        votes[k] =
            std::isnan(apart) ? 0 : one_pixel + static_cast<std::uint32_t>(apart / vote_step);
      }
    }
  });
}

/// Sums the votes in a window along each row or column.
void CameraOrders::sum_windows(const CameraPhases& camera, const Image<float>& phase,
                               bool along_rows) {
  for_each_row(along_rows ? phase.height() : phase.width(), [&](int number) {
    const Line line(camera, phase, along_rows, number);
    LineSums(line, candidates_, votes_, summed_).sum();
  });

  std::swap(votes_, summed_);
}

}  // namespace slipstream
