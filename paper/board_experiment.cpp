#include "paper/board_experiment.h"

#include <cmath>
#include <cstddef>
#include <numbers>

#include "decode/phase_decoder.h"
#include "paper/cloud_views.h"
#include "response/correction.h"
#include "slipstream/frame_set.h"
#include "slipstream/named_scenes.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/strategy.h"

namespace slipstream {
namespace {

constexpr double two_pi = 2 * std::numbers::pi;

PatternSet patterns(int steps) {
  return pattern_set(PhaseMeasuring{steps, BoardExperiment::frequency}, Axis::x);
}

VirtualScan scan_of(const Scanner& scanner, BoardExperiment::Surface surface) {
  using enum BoardExperiment::Surface;
  Scene scene = scene_named(surface == fish ? "fish" : "board", scanner);
  if (surface == textured) scene.front().texture = veined_texture(0.35, 0.85, 40);
  return take_scan(scanner, scene, patterns(3));
}

}  // namespace

BoardExperiment::BoardExperiment(Size camera, Surface surface, std::uint64_t seed)
    : seed_(seed), scanner_(example_scanner(camera)), scan_(scan_of(scanner_, surface)) {}

Photometry BoardExperiment::photometry(double gamma, double ambient) const {
  return {.ambient = ambient,
          .response = PowerLaw{gamma},
          .noise_variance = 1.55,
          .bits = 8,
          .seed = seed_};
}

FrameSet BoardExperiment::averaged(int steps, double gamma, double ambient, int count) const {
  return averaged(patterns(steps), photometry(gamma, ambient), count);
}

FrameSet BoardExperiment::averaged(const PatternSet& shown, Photometry light, int count) const {
  MeanFrames frames;
  for (; count > 0; --count, ++light.seed) frames.add(take_again(scan_, shown, light));
  return frames.mean();
}

FrameSet BoardExperiment::precompensated(int steps, double gamma, double ambient,
                                         const Response& response) const {
  PatternSet shown = slipstream::precompensated(patterns(steps), response);
  shown.shape = [exact = shown.shape](int n, double y, double across) {
    return std::round(255 * exact(n, y, across)) / 255;
  };
  return averaged(shown, photometry(gamma, ambient), repetitions);
}

FrameSet BoardExperiment::grey_levels(int count, double gamma, double ambient) const {
  PatternSet uniform;
  uniform.count = count;
  uniform.shape = [count](int n, double) { return static_cast<double>(n) / (count - 1); };
  return take_again(scan_, uniform, photometry(gamma, ambient));
}

FrameSet BoardExperiment::once(int steps, double gamma, double ambient) const {
  return take_again(scan_, patterns(steps), photometry(gamma, ambient));
}

Image<double> BoardExperiment::phase(const FrameSet& frames, const PhaseCorrections& corrections) {
  const int steps = frames.count();
  return PhaseDecoder(PhaseMethod::equation, {steps}, corrections)(frames, 0, steps).wrapped_phase;
}

Image<double> BoardExperiment::error(const Image<double>& phase) const {
  Image<double> error(phase.size());
  for (std::size_t i = 0; i < phase.pixel_count(); ++i) {
    const double truth = two_pi * frequency * scan_.coordinate.begin()[i];
    error.begin()[i] = std::remainder(phase.begin()[i] - truth, two_pi) / frequency;
  }
  return error;
}

Cloud BoardExperiment::surface(const Image<double>& phase) const {
  Image<double> coordinate = error(phase);
  for (std::size_t i = 0; i < coordinate.pixel_count(); ++i) {
    coordinate.begin()[i] = scan_.coordinate.begin()[i] + coordinate.begin()[i] / two_pi;
  }
  return cloud_of(scanner_, coordinate, Image<double>(phase.size()));
}

double BoardExperiment::rms_error(const Image<double>& phase,
                                  const Image<std::uint8_t>& lit) const {
  const Image<double> errors = error(phase);
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < errors.pixel_count(); ++i) {
    const double value = errors.begin()[i];
    if (lit.begin()[i] == 0 || std::isnan(value)) continue;
    sum += value * value;
    ++count;
  }
  return std::sqrt(sum / count);
}

double BoardExperiment::rms_error(const FrameSet& frames, const PhaseCorrections& corrections,
                                  const Image<std::uint8_t>& lit) const {
  return rms_error(phase(frames, corrections), lit);
}

}  // namespace slipstream
