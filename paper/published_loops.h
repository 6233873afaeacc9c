#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "decode/equations.h"
#include "decode/phase_decoder.h"
#include "geometry/triangulator.h"
#include "slipstream/frame_set.h"
#include "slipstream/scanner.h"

namespace slipstream {

/// Second form of a point, Eqs. (2.25)-(2.28): 4 multiplications, 1 division, 4 additions.
struct PointForm2 {
  double M_x, N_x, M_y, N_y, M_z, N_z, C;
  [[nodiscard]] Eigen::Vector3d operator()(double y_p) const;
};

/// As for the other forms; NaN where the third form gives it.
PointForm2 point_form2(const PointCoefficients& coefficients, double x, double y);

/// The computations of Liu 2010, Table 2.2, for N frames of one period across the field: one loop
/// over the pixels each, in double, on one thread and, as published, without the projector's lens
/// distortion. Results are public images, so that the compiler cannot remove the loops and tests
/// can read them.
class PublishedLoops {
 public:
  /// The frames must outlive the loops. Throws Error unless there are 3, 4 or 6.
  PublishedLoops(const Scanner& scanner, Axis axis, Frames<std::uint8_t> frames);

  void general();             ///< B and phase by Eqs. (1.4)-(1.7)
  void general_modulation();  ///< B alone
  void general_phase();       ///< phase alone
  void closed_form();         ///< B and phase by Eqs. (2.1)-(2.3), (2.13)-(2.15)
  void closed_modulation();   ///< B alone
  void closed_phase();        ///< phase alone
  void mlut();                ///< B alone
  void plut();                ///< phase alone
  void mlut_plut();
  /// The 3 frames as 2+1 (sine, cosine and mean), by the tables of N = 4: U = I_1 - I_2, V = I_0 -
  /// I_2, and twice the modulation.
  void two_plus_one();
  void inverse();  ///< points from the phase by Eq. (1.15)
  void form1();
  void form2();
  void form3();
  // Frames to points and texture, all stages of a pixel in one loop:
  void equations();    ///< general, then inverse
  void traditional();  ///< closed_form, then inverse: "traditional PMP" of Table 2.2, *2, *3, *1
  void lut();          ///< MLUT and PLUT, then the third form

  Image<double> modulation, phase, x, y, z, texture;

 private:
  /// Calls `sample(I, column, row)` with the N intensities, whose count the compiler knows.
  template <class Number, class Sample>
  void each_pixel(const Sample& sample);
  template <class Number, int N, class Sample>
  void each_of(const Sample& sample);
  void set_point(int column, int row, const Eigen::Vector3d& point);
  template <class Table>
  void points_by(const Image<Table>& table);
  /// Texture of the pixel, and its point by Eq. (1.15) unless it is darker than least_modulation.
  template <std::size_t N>
  void set_inverse(int column, int row, const std::array<double, N>& I, double B, double phi);

  static constexpr double least_modulation = 15;

  int steps_;
  Frames<std::uint8_t> frames_;
  ProjectionMatrices matrices_;
  PhaseEquations equations_;
  PhaseTables tables_, tables_of_4_;
  Image<PixelPosition> pixels_;
  Image<PointForm1> forms1_;
  Image<PointForm2> forms2_;
  Image<PointForm3> forms3_;
};

}  // namespace slipstream
