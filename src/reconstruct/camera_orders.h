#pragma once

#include <cstdint>
#include <vector>

#include "reconstruct/epipolar_tables.h"

namespace slipstream {

struct PointPhases;

/// Fringe orders that the depth range leaves to each pixel of a camera: first + 0 to first + count
/// - 1.
struct CandidateOrders {
  Image<std::int16_t> first{};
  Image<std::int16_t> count{};
  int most = 0;  ///< no count is larger
};

/// Finds projector coordinates of the pixels of a camera from a single band of many periods:
/// chooses the fringe order whose point the other camera sees under the same phase. Wrong orders
/// can match by chance, so all pixels of a window vote, as far as the phase continues without a
/// jump. Reuses its memory.
class CameraOrders {
 public:
  /// `tables`: of the camera beside the other, outlives this. `depths`: in the frame of this
  /// camera, or of the other if `of_other`. `length`: projector pixels along the axis.
  CameraOrders(const EpipolarTables& tables, double periods, const DepthRange& depths,
               bool of_other, int length);

  /// Coordinates, NaN if two orders fit, or none. `phase`: the camera's wrapped phase, rad, from
  /// the beginning of the field, in [0, 2 pi).
  const Image<float>& operator()(const CameraPhases& camera, const Image<float>& phase,
                                 const CameraPhases& other);

 private:
  void find_candidates(const CameraPhases& camera, const Image<float>& phase, int row,
                       PointPhases& points);

  /// Where a pixel's sums begin. They are stored in strips of eight columns, one strip after the
  /// other, so that a column lies in a few pages of memory, and its strip in the cache.
  [[nodiscard]] std::size_t at(int column, int row) const {
    constexpr int strip = 8;
    const int first_of_row = (column / strip * coordinate_.height() + row) * strip;
    return static_cast<std::size_t>(first_of_row + column % strip) *
           static_cast<std::size_t>(candidates_.most);
  }

  /// Range of the coordinate along a pixel's ray, periods.
  struct Bounds {
    float least = 0, largest = 0;
  };

  const EpipolarTables& tables_;
  float periods_;
  DepthRange depths_;
  bool of_other_;

  Image<Bounds> bounds_;
  CandidateOrders candidates_;
  std::vector<std::uint32_t> sums_;  ///< for every pixel and candidate: see Disagreement
  Image<float> coordinate_;
};

}  // namespace slipstream
