#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "slipstream/geometry/scan.h"
#include "slipstream/response/noise_measurement.h"

namespace slipstream {

/// One of the ways to measure sigma_w^2, over all scans or pairs of scans that allow it.
struct NoiseMeasurement {
  std::string equation{};  ///< of Liu 2010: "3.82"
  std::string method{};    ///< in words
  double variance = 0;     ///< sigma_w^2, grey levels^2 of 255
  double standard_error = 0;
  int count = 0;           ///< scans or pairs that it is the mean of
  std::size_t pixels = 0;  ///< of one of them
  std::string reason{};    ///< why it disagrees with the one trusted most; empty where it does not
};

/// What a scan says of the noise in its frames, kept without the frames.
class NoiseScan {
 public:
  explicit NoiseScan(const Scan& scan);

 private:
  friend std::vector<NoiseMeasurement> calibrate_noise(std::span<const NoiseScan> scans);
  friend std::optional<NoiseLine> noise_line(std::span<const NoiseScan> scans);

  Strategy strategy_;
  int steps_ = 0;                 ///< of the first band
  Image<std::uint8_t> measured_;  ///< bright enough, and no frame clipped
  Image<double> mean_;            ///< grey levels of 255, as all that follow
  Image<double> b_cos_;           ///< 4 steps without a cue in their half phase channel
  Image<double> modulations_[2];  ///< of two bands in the same frames
};

/// All that the scans of one unmoved scene allow, the one to be trusted most first. Throws Error
/// where they allow none, are of different sizes or two are one and the same.
std::vector<NoiseMeasurement> calibrate_noise(std::span<const NoiseScan> scans);

/// How sigma_w^2 depends on the grey level, the mean of all pairs of scans alike. None where there
/// are no pairs, or noise does not grow with the light by more than four standard errors.
std::optional<NoiseLine> noise_line(std::span<const NoiseScan> scans);

/// Whether the measurement counts a response that is not linear as noise.
bool mistakes_gamma_for_noise(const NoiseMeasurement& measurement);

}  // namespace slipstream
