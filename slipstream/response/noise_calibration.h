#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "slipstream/base/image.h"
#include "slipstream/geometry/scan.h"

namespace slipstream {

/// sigma_w^2 as measured over the pixels of a picture.
struct NoiseEstimate {
  double variance = 0;        ///< sigma_w^2, grey levels^2
  double standard_error = 0;  ///< of the variance, were the noise Gaussian
  std::size_t pixels = 0;     ///< that it was measured over
};

/// How sigma_w^2 depends on the grey level.
struct NoiseLine {
  double at_half = 0;     ///< sigma_w^2 at half of full scale, grey levels^2
  double gain = 0;        ///< by which it grows with each grey level
  double gain_error = 0;  ///< one standard error of the gain
};

// The images below are of one unmoved scene, in grey levels; `measured` is 1 where a pixel counts.
// Each throws Error where fewer than 100 pixels do.

/// From the means A^c of two scans of N_1 and N_2 frames: Liu 2010, Eqs. (3.17), (3.19), and (3.20)
/// where both are alike, which a response that is not linear leaves right.
NoiseEstimate noise_from_means(const Image<double>& mean_1, int steps_1,
                               const Image<double>& mean_2, int steps_2,
                               const Image<std::uint8_t>& measured);

/// The same as a line over the pixels' grey level, from two scans of N frames each.
NoiseLine noise_line_from_means(const Image<double>& mean_1, const Image<double>& mean_2, int steps,
                                const Image<std::uint8_t>& measured);

/// From the half phase channel B_cos^c of one 4-pattern scan: Eq. (3.79). A response that is not
/// linear shows in it as noise.
NoiseEstimate noise_from_half_phase(const Image<double>& b_cos,
                                    const Image<std::uint8_t>& measured);

/// From the half phase channels of two 4-pattern scans: Eq. (3.82), which a response that is not
/// linear leaves right.
NoiseEstimate noise_from_half_phases(const Image<double>& b_cos_1, const Image<double>& b_cos_2,
                                     const Image<std::uint8_t>& measured);

/// From the two modulations of one PCMP scan of N >= 5 steps: Eq. (3.99), whose alpha_p goes into
/// alpha = 2 B / (alpha_p c). Right for small noise, and a response that is not linear shows.
NoiseEstimate noise_from_modulations(const Image<double>& modulation_1,
                                     const Image<double>& modulation_2, int steps, double c1,
                                     const Image<std::uint8_t>& measured);

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
struct NoiseScan {
  explicit NoiseScan(const Scan& scan);

  Strategy strategy;
  int steps = 0;                 ///< of the first band
  Image<std::uint8_t> measured;  ///< bright enough, and no frame clipped
  Image<double> mean;            ///< grey levels of 255, as all that follow
  Image<double> b_cos;           ///< 4 steps without a cue in their half phase channel
  Image<double> modulations[2];  ///< of two bands in the same frames
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
