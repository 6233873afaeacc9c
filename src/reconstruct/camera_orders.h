#pragma once

#include <cstdint>
#include <vector>

#include "reconstruct/epipolar_tables.h"

namespace slipstream {

/// Fringe orders that the depth range leaves to each pixel of a camera: first + 0 to first + count
/// - 1.
struct CandidateOrders {
  Image<std::int16_t> first{};
  Image<std::uint8_t> count{};
  int most = 0;  ///< the largest count
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
  void find_candidates(const CameraPhases& camera, const Image<float>& phase);
  void vote(const CameraPhases& camera, const Image<float>& phase, const CameraPhases& other);
  void sum_windows(const CameraPhases& camera, const Image<float>& phase, bool along_rows);

  [[nodiscard]] std::size_t at(int column, int row) const {
    return static_cast<std::size_t>(row * coordinate_.width() + column) *
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
  /// For every pixel and candidate: in the low bits the disagreement of the two cameras' phases, 1
  /// - cos of their difference, in steps of 1 / 4096, in the high ones the pixels that the other
  /// camera sees.
  std::vector<std::uint32_t> votes_, summed_;

  Image<float> coordinate_;
};

}  // namespace slipstream
