#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "slipstream/capture/frame_set.h"
#include "slipstream/image/image.h"
#include "slipstream/phase/neighbourhood_vote.h"
#include "slipstream/reconstruct/fused_stages.h"
#include "slipstream/reconstruct/multiplexed_rows.h"

namespace slipstream {

/// What is known of a whole picture between the pass over its frames and the pass over its points,
/// where the neighbourhood has a vote on the fringe orders.
class MultiplexedPicture {
 public:
  /// Room for a picture, the same as before or another.
  void prepare(Size size);

  /// The row's coordinates, from row -margin to height + margin - 1; as many NaN stand before the
  /// first and after the last pixel and fill the rows outside.
  [[nodiscard]] float* coordinates(int row) { return coordinate_.row(row + margin) + side; }
  [[nodiscard]] const float* coordinates(int row) const {
    return coordinate_.row(row + margin) + side;
  }
  [[nodiscard]] std::uint8_t* flags(int row) { return flags_.row(row); }
  [[nodiscard]] const std::uint8_t* flags(int row) const { return flags_.row(row); }
  /// NeighbourhoodVote's shift; it may not be asked for outside the picture.
  [[nodiscard]] std::int16_t& shift(PixelPlace at) { return shift_(at.column, at.row); }
  [[nodiscard]] std::int16_t shift(PixelPlace at) const { return shift_(at.column, at.row); }

  NeighbourhoodVoteLists lists;

 private:
  static constexpr int margin = 4;  ///< as far as a vote looks: its radius and two more pixels
  static constexpr int side = 16;   ///< the same beside the rows, so that they start at vectors

  Image<float> coordinate_;
  Image<std::uint8_t> flags_;
  Image<std::int16_t> shift_;
};

/// One scan as NeighbourhoodVote looks at it.
template <class Pixel>
class MultiplexedField {
 public:
  MultiplexedField(const FusedStages::Cue& cue, const Frames<Pixel>& frames, double full_scale,
                   MultiplexedPicture& picture)
      : cue_(cue), frames_(frames), to_8_bits_(255 / full_scale), picture_(picture) {}

  [[nodiscard]] double periods(int column, int row) const {
    const float y = picture_.coordinates(row)[column];
    if (y != y || (picture_.flags(row)[column] & PixelFlag::dim) != 0) {
      return std::numeric_limits<double>::quiet_NaN();
    }
    return static_cast<double>(y) * cue_.f_h;
  }
  [[nodiscard]] double cost(int column, int row, int shift) const {
    const double y = picture_.coordinates(row)[column] + shift / cue_.f_h;
    if (!cue_.exact.near_field(y, cue_.length)) return std::numeric_limits<double>::infinity();
    return cue_.exact.cost(pixel(column, row), y);
  }
  [[nodiscard]] int shift(int column, int row) const { return picture_.shift({row, column}); }
  void set_shift(int column, int row, int shift) {
    picture_.shift({row, column}) = static_cast<std::int16_t>(shift);
  }

  /// Without its wrapped phase.
  [[nodiscard]] MultiplexedPixel pixel(int column, int row) const {
    double C = 0, S = 0;
    MultiplexedPixel pixel;
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
  MultiplexedPicture& picture_;
};

}  // namespace slipstream
