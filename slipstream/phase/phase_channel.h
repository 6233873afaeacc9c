#pragma once

#include <span>
#include <vector>

#include "slipstream/capture/frame_set.h"

namespace slipstream {

/// Weights 2/N cos(2 pi m n / N) and 2/N sin(2 pi m n / N) that the N frames have in phase channel
/// m: Liu 2010, Eqs. (1.5), (1.6) for m = 1, (3.85), (3.86) for m = 2.
std::vector<double> channel_cosines(int steps, int channel);
std::vector<double> channel_sines(int steps, int channel);

/// Weights of the frames in the DC channel, (1.3), and of 4 frames in the half phase channel,
/// (3.70).
std::vector<double> mean_weights(int steps);
std::vector<double> half_phase_weights();

/// sum_n weights[n] I_n of every pixel, grey levels of the frames; the frames from `first` on.
Image<double> weighted_sum(const FrameSet& frames, int first, std::span<const double> weights);

/// The modulation in phase channel m of the first `steps` frames: (1.4) for m = 1, (3.87)
/// for m = 2. Grey levels of the frames.
Image<double> channel_modulation(const FrameSet& frames, int steps, int channel);

}  // namespace slipstream
