#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "slipstream/image.h"
#include "slipstream/scan.h"

namespace slipstream {

/// sigma_w^2 measured over the pixels of an image.
struct NoiseEstimate {
  double variance = 0;        ///< sigma_w^2, grey levels^2
  double standard_error = 0;  ///< of the variance, assuming Gaussian noise
  std::size_t pixels = 0;     ///< used for the measurement
};

/// Dependence of sigma_w^2 on the grey level.
struct NoiseLine {
  double at_half = 0;     ///< sigma_w^2 at half of full scale, grey levels^2
  double gain = 0;        ///< increase per grey level
  double gain_error = 0;  ///< standard error of the gain
};

// The images below are of one static scene, in grey levels; `measured` is 1 at pixels to use. Each
// function throws Error if there are fewer than 100.

/// From the means A^c of two scans of N_1 and N_2 frames: Liu 2010, Eqs. (3.17), (3.19), and (3.20)
/// for equal scans, which holds for a nonlinear response too.
NoiseEstimate noise_from_means(const Image<double>& mean_1, int steps_1,
                               const Image<double>& mean_2, int steps_2,
                               const Image<std::uint8_t>& measured);

/// The same as a line over the pixels' grey level, from two scans of N frames each.
NoiseLine noise_line_from_means(const Image<double>& mean_1, const Image<double>& mean_2, int steps,
                                const Image<std::uint8_t>& measured);

/// From the half phase channel B_cos^c of one 4-pattern scan: Eq. (3.79). Counts the effect of a
/// nonlinear response as noise.
NoiseEstimate noise_from_half_phase(const Image<double>& b_cos,
                                    const Image<std::uint8_t>& measured);

/// From the half phase channels of two 4-pattern scans: Eq. (3.82), which holds for a nonlinear
/// response too.
NoiseEstimate noise_from_half_phases(const Image<double>& b_cos_1, const Image<double>& b_cos_2,
                                     const Image<std::uint8_t>& measured);

/// From the two modulations of one PCMP scan of N >= 5 steps: Eq. (3.99), where alpha_p is part of
/// alpha = 2 B / (alpha_p c). Valid for small noise; counts a nonlinear response as noise.
NoiseEstimate noise_from_modulations(const Image<double>& modulation_1,
                                     const Image<double>& modulation_2, int steps, double c1,
                                     const Image<std::uint8_t>& measured);

/// A measurement of sigma_w^2, grey levels^2 of 255, by one equation: the mean over all scans or
/// pairs of scans that allow it, with the pixels of one of them.
struct NoiseMeasurement : NoiseEstimate {
  std::string equation{};  ///< of Liu 2010, e.g. "3.82"
  std::string method{};    ///< description
  int count = 0;           ///< scans or pairs averaged
  std::string reason{};    ///< why it disagrees with the most trusted one; otherwise empty
};

/// Noise data of a scan, without its frames.
struct NoiseScan {
  explicit NoiseScan(const Scan& scan);

  Strategy strategy;
  int steps = 0;                 ///< of the first band
  Image<std::uint8_t> measured;  ///< bright enough, and no frame clipped
  Image<double> mean;            ///< grey levels of 255, also below
  Image<double> b_cos;           ///< for 4 steps without a cue in their half phase channel
  Image<double> modulations[2];  ///< of two bands in the same frames
};

/// All measurements that scans of one static scene allow, most trusted first. Throws Error if there
/// are none, sizes differ, or two scans are identical.
std::vector<NoiseMeasurement> calibrate_noise(std::span<const NoiseScan> scans);

/// Dependence of sigma_w^2 on the grey level, averaged over all pairs of equal scans. nullopt if
/// there are no pairs, or the gain is below four standard errors.
std::optional<NoiseLine> noise_line(std::span<const NoiseScan> scans);

/// Whether the measurement counts a nonlinear response as noise.
bool mistakes_gamma_for_noise(const NoiseMeasurement& measurement);

}  // namespace slipstream
