#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "decode/phase_decoder.h"
#include "geometry/triangulator.h"
#include "slipstream/engine.h"

namespace slipstream {

/// The published system (Liu 2010, Chapter 2), pixel by pixel: sums of 8-bit intensities, Eqs.
/// (2.4)-(2.9) and (2.16)-(2.18), are looked up in MLUT and PLUT, and the coordinate becomes a
/// point by the third form, Eqs. (2.29)-(2.31), whose coefficients are in a table. Beyond print, a
/// table corrects the projector's lens: for each pixel, a polynomial in the coordinate.
///
/// Validity, depth range and results are the ReferenceEngine's, points to a hundred-thousandth of
/// their depth. Thread-safe.
class TableEngine {
 public:
  /// nullopt, with the reason, unless the patterns are N = 3, 4 or 6 steps of one period from
  /// phase 0, decoded by tables, and the lens table is that exact. `corrections` are those of the
  /// engine.
  static std::optional<TableEngine> make(const EngineSetup& setup,
                                         const PhaseCorrections& corrections, std::string* why_not);

  /// Whether the tables have entries for all values of such frames, 8 bits.
  [[nodiscard]] static bool takes(const FrameViews& frames);

  /// Computes all outputs but packed points. Throws Error if the frames have not the camera's size
  /// or number.
  void operator()(const FrameViews& frames, const Outputs& outputs) const;

 private:
  struct Block;
  struct Tables;

  explicit TableEngine(std::shared_ptr<const Tables> tables) : tables_(std::move(tables)) {}

  template <int N>
  void run(const Frames<std::uint8_t>& frames, const Outputs& outputs) const;
  void judge(int column, int row, int count, Block& block) const;
  static void write_phases(const Block& block, int column, int row, int count,
                           const Outputs& outputs);
  static void write_points(const Block& block, int column, int row, int count,
                           const Outputs& outputs);

  std::shared_ptr<const Tables> tables_;
};

}  // namespace slipstream
