#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "slipstream/capture/frame_views.h"
#include "slipstream/image/image.h"
#include "slipstream/reconstruct/detail/fused_stages.h"
#include "slipstream/unwrap/neighbourhood_vote.h"

namespace slipstream {

/// Rows of coordinates around those that become points next: so many that the neighbourhood's vote
/// on them is the same as in the whole picture. A pixel's shift depends on its like within 9 rows
/// (three passes over windows of 5 x 5, three over 3 x 3), and those on phases 4 rows further.
class VoteBlock {
 public:
  static constexpr int most_rows = 88;  ///< that become points at once
  static constexpr int voters = 10;     ///< rows around them in which pixels choose
  static constexpr int seen = 14;       ///< rows around them of which phases are seen
  static constexpr int looks_past = 4;  ///< rows that a vote looks past the last phase

  /// Room for rows of that width, the same as before or another.
  void prepare(int width);

  /// The row's coordinates, NaN before the first pixel and after the last. Only the last rows that
  /// were written are kept.
  [[nodiscard]] float* coordinates(int row) { return coordinate_.row(place(row)) + side; }
  [[nodiscard]] const float* coordinates(int row) const {
    return coordinate_.row(place(row)) + side;
  }
  [[nodiscard]] std::int32_t* flags(int row) { return flags_.row(place(row)); }
  [[nodiscard]] const std::int32_t* flags(int row) const { return flags_.row(place(row)); }
  /// Of NeighbourhoodVote; 0 between votes.
  [[nodiscard]] std::int16_t& shift(PixelPlace at) { return shift_(at.column, place(at.row)); }
  [[nodiscard]] std::int16_t shift(PixelPlace at) const { return shift_(at.column, place(at.row)); }

  /// Makes rows NaN: those outside the picture, or not yet known.
  void clear(int first, int last);

  /// Takes back what a vote has changed, so that the next begins with what each pixel said alone.
  void forget_vote();

  /// What a vote has changed, as it was.
  struct Moved {
    PixelPlace at;
    float coordinate = 0;
    std::int32_t flags = 0;
  };
  std::vector<Moved> moved;
  std::vector<PixelPlace> disagreeing;
  NeighbourhoodVoteLists lists;

 private:
  static constexpr int kept_rows =
      128;                         // a power of two, at least most_rows + 2 (seen + looks_past)
  static constexpr int side = 16;  // as looks_past, so that rows start at whole vectors

  static int place(int row) { return row & (kept_rows - 1); }

  Image<float> coordinate_;
  Image<std::int32_t> flags_;
  Image<std::int16_t> shift_;
};

/// One scan as NeighbourhoodVote looks at it.
template <class Pixel>
class VoteField {
 public:
  /// `some_dim`: pixels that have no say may have coordinates.
  VoteField(const FusedStages::Cue& cue, const Frames<Pixel>& frames, double full_scale,
            bool some_dim, VoteBlock& block)
      : cue_(cue),
        frames_(frames),
        to_8_bits_(255 / full_scale),
        some_dim_(some_dim),
        block_(block) {}

  [[nodiscard]] double periods(int column, int row) const {
    const double y = block_.coordinates(row)[column];
    if (some_dim_ && y == y && (block_.flags(row)[column] & PixelFlag::dim) != 0) {
      return std::numeric_limits<double>::quiet_NaN();
    }
    return y * cue_.f_h;
  }
  void periods_around(int column, int row, PhaseWindow& window) const {
    constexpr int reach = VoteBlock::looks_past;
    for (int r = 0; r < 2 * reach + 1; ++r) {
      auto& line = window[static_cast<std::size_t>(r)];
      const float* y = block_.coordinates(row + r - reach) + column - reach;
      for (std::size_t c = 0; c < line.size(); ++c) line[c] = cue_.f_h * y[c];
      if (!some_dim_) continue;
      for (std::size_t c = 0; c < line.size(); ++c) {
        line[c] = periods(column + static_cast<int>(c) - reach, row + r - reach);
      }
    }
  }
  struct Evidence {
    CuePixel pixel;
    double y = 0;
  };
  [[nodiscard]] Evidence evidence(int column, int row) const {
    return {pixel(column, row), block_.coordinates(row)[column]};
  }
  [[nodiscard]] double cost(const Evidence& evidence, int shift) const {
    const double y = evidence.y + shift / cue_.f_h;
    if (!cue_.exact.near_field(y, cue_.projector_length))
      return std::numeric_limits<double>::infinity();
    return cue_.exact.cost(evidence.pixel, y);
  }
  /// On the circle the nearest order is the likeliest.
  [[nodiscard]] bool own_order_costs_least() const { return cue_.exact.is_circle(); }
  [[nodiscard]] int shift(int column, int row) const { return block_.shift({row, column}); }
  void set_shift(int column, int row, int shift) {
    block_.shift({row, column}) = static_cast<std::int16_t>(shift);
  }

  /// Without its wrapped phase.
  [[nodiscard]] CuePixel pixel(int column, int row) const {
    double C = 0, S = 0;
    CuePixel pixel;
    for (std::size_t n = 0; n < frames_.size(); ++n) {
      const double I = to_8_bits_ * frames_[n](column, row);
      C += cue_.cosines[n] * I;
      S += cue_.sines[n] * I;
      pixel.cue += cue_.cue[n] * I;
      pixel.cue_sine += cue_.cue_sine[n] * I;
    }
    pixel.modulation = std::sqrt(C * C + S * S);
    return pixel;
  }

 private:
  const FusedStages::Cue& cue_;
  const Frames<Pixel>& frames_;
  double to_8_bits_;
  bool some_dim_;
  VoteBlock& block_;
};

}  // namespace slipstream
