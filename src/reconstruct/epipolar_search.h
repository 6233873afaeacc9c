#pragma once

#include <cmath>
#include <limits>
#include <vector>

#include "reconstruct/epipolar_tables.h"
#include "slipstream/layout.h"

namespace slipstream {

/// Where the phases agree.
struct EpipolarMatch {
  float w = std::numeric_limits<float>::quiet_NaN();    ///< inverse depth 1 / Z, 1 / mm
  Eigen::Vector2f at = Eigen::Vector2f::Zero();         ///< pixel of the second camera
  Eigen::Vector2f direction = Eigen::Vector2f::Zero();  ///< change of the pixel over w
  /// Change of the phase along the line, rad per pixel of the second camera.
  float slope = std::numeric_limits<float>::quiet_NaN();

  [[nodiscard]] bool is_found() const { return w > 0 && std::isfinite(w); }
};

/// Angle of a complex number, rad, to 1e-5: a polynomial within an eighth of a turn.
inline float angle_of(Phasor z) {
  if (!(std::abs(z.imag()) <= z.real())) return std::atan2(z.imag(), z.real());

  // arctan t as an odd polynomial, for |t| up to 1.
  const float t = z.imag() / z.real(), t2 = t * t;
  return t * (0.9998660F +
              t2 * (-0.3302995F + t2 * (0.1801410F + t2 * (-0.0851330F + t2 * 0.0208351F))));
}

/// The ray of one pixel of the first camera, in the second.
class EpipolarSearch {
 public:
  EpipolarSearch(const EpipolarTables& tables, const CameraPhases& first,
                 const CameraPhases& second, int column, int row)
      : tables_(tables), first_(first), second_(second), column_(column), row_(row) {}

  /// Phase of band i in the second camera less that in the first, wrapped, rad; NaN beside an
  /// invalid pixel.
  [[nodiscard]] float difference(std::size_t i, const Eigen::Vector2f& at) const {
    return difference(i, phasor_at(second_, second_.bands[i], at));
  }

  /// The same, faster, to a few hundredths of the phase's change from pixel to pixel.
  [[nodiscard]] float near_difference(std::size_t i, const Eigen::Vector2f& at) const {
    return difference(i, near_phasor(second_, second_.bands[i], at));
  }

  /// The agreement of band i nearest to `start` by Newton's method; not found unless it converges
  /// within `farthest` pixels.
  [[nodiscard]] EpipolarMatch by_newton(std::size_t i, float start, int farthest) const;

  /// The same by trying one place after the other, `stride` pixels apart.
  [[nodiscard]] EpipolarMatch by_places(std::size_t i, float start, int farthest,
                                        int stride = 1) const;

 private:
  [[nodiscard]] float difference(std::size_t i, Phasor seen) const {
    if (seen == Phasor(0)) return std::numeric_limits<float>::quiet_NaN();
    return angle_of(seen * std::conj(first_.bands[i](column_, row_)));
  }

  [[nodiscard]] Eigen::Vector2f place(float w) const { return tables_.place(column_, row_, w); }

  /// Change of the pixel in the second camera over w, from its place at w.
  [[nodiscard]] Eigen::Vector2f pixels_per_w(float w, const Eigen::Vector2f& at) const {
    const float step = 1e-3F * w;
    return (place(w + step) - at) / step;
  }

  /// Change of the phase of band i at a place, over one `pixel` along the line; NaN beside an
  /// invalid pixel.
  [[nodiscard]] float slope(std::size_t i, const Eigen::Vector2f& at,
                            const Eigen::Vector2f& pixel) const;

  const EpipolarTables& tables_;
  const CameraPhases &first_, &second_;
  int column_, row_;
};

/// Search ranges of the bands, from few periods to many.
struct BandSearch {
  std::vector<float> fringes;  ///< a period of each, in rad of the band before
  int reach = 12;              ///< of the first, pixels
  int stride = 1;              ///< pixels over which the phase of the first changes little
};

/// `width`: of the second camera.
BandSearch band_search(const Layout& layout, int width);

/// Matches band by band, from few periods to many; `guess`: inverse depth by the projector.
EpipolarMatch match_pixel(const EpipolarSearch& line, float guess, const BandSearch& bands);

}  // namespace slipstream
