#include "reconstruct/camera_phases.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "base/parallel_rows.h"
#include "decode/phase_decoder.h"
#include "reconstruct/engine_setup.h"
#include "reconstruct/fused/pair_rows.h"
#include "reconstruct/fused/rows.h"
#include "reconstruct/points.h"
#include "slipstream/unwrapping.h"

namespace slipstream {
namespace {

EngineSetup for_phases(EngineSetup setup) {
  // Phases are matched as measured: no correction for the response, and no geometry.
  PhotometricCalibration light = setup.scanner.photometry;
  light.response.reset();
  setup.scanner = without_geometry(setup.scanner.camera.size, setup.scanner.projector.size, light);

  setup.sequence = merged_sequence(setup.sequence);
  raise_least_modulation(setup);

  return setup;
}

/// Whether C and S of all bands are plain sums of the frames.
bool are_sums(const Layout& layout) {
  return std::ranges::all_of(layout.bands, [](const Band& band) { return band.carrier == 0; });
}

}  // namespace

PhaseReader::PhaseReader(const EngineSetup& setup)
    : setup_(for_phases(setup)),
      maps_(setup_),
      decode_(setup_.sequence.strategy.layout(), projector_length(setup_),
              setup_.settings.phase_method),
      order_(coarse_to_fine(decode_.layout())) {}

void PhaseReader::operator()(const FrameViews& captured, CameraPhases& to) {
  const FrameViews& frames = maps_.merged(captured);

  // 1. Phasors of the bands, maps, and which pixels are valid.
  read_bands(frames, to);
  if (has_coordinate(decode_.layout())) {
    maps_.maps(frames, to.maps);
  } else {
    read_maps(frames, to);
  }
  judge(frames, to);

  // 2. Which places between pixels can be interpolated: those with four valid pixels around them.
  const Size size = frames.size();
  if (to.surrounded.size() != size) to.surrounded = Image<std::int32_t>(size);
  for_each_row(size.height - 1, [&](int row) {
    const Validity *const here = to.validity.row(row), *const below = to.validity.row(row + 1);

    const auto is_valid = [&](int column) {
      return here[column] == Validity::valid && below[column] == Validity::valid;
    };

    std::int32_t* const inside = to.surrounded.row(row);
    for (int column = 0; column + 1 < size.width; ++column) {
      inside[column] = is_valid(column) && is_valid(column + 1) ? 1 : 0;
    }
  });
}

/// Each band by itself: gamma may put the coordinate in different fringes in the two cameras.
void PhaseReader::read_bands(const FrameViews& frames, CameraPhases& to) const {
  const Layout& layout = decode_.layout();
  to.bands.resize(order_.size());
  for (Image<Phasor>& band : to.bands) {
    if (band.size() != frames.size()) band = Image<Phasor>(frames.size());
  }

  // 8 to 16 bits, plain sums: several pixels at a time.
  const bool fits_vectors = frames.size().width >= least_row_width;
  if (frames.quantised() && fits_vectors && are_sums(layout)) {
    for_each_row(frames.size().height, [&](int row) {
      for (std::size_t i = 0; i < order_.size(); ++i) {
        phasor_row(layout.bands[order_[i]], frames, row, to.bands[i].row(row));
      }
    });
    return;
  }

  // Other numbers, plain sums: over the whole image in double.
  if (are_sums(layout)) {
    for (std::size_t i = 0; i < order_.size(); ++i) {
      const Band& band = layout.bands[order_[i]];
      std::ranges::transform(
          weighted_sum(frames, band.cosine), weighted_sum(frames, band.sine), to.bands[i].begin(),
          [](double C, double S) { return Phasor(static_cast<float>(C), static_cast<float>(S)); });
    }
    return;
  }

  // Carriers or other demodulation: by the reference decoder.
  const LayoutPhases decoded = decode_.demodulate(frames);
  for (std::size_t i = 0; i < order_.size(); ++i) {
    const PhaseMaps& band = decoded.bands[order_[i]];
    std::ranges::transform(
        band.modulation, band.wrapped_phase, to.bands[i].begin(),
        [](double B, double phi) { return static_cast<Phasor>(std::polar(B, phi)); });
  }
}

/// The maps of a single band, without a coordinate.
void PhaseReader::read_maps(const FrameViews& frames, CameraPhases& to) const {
  const Image<Phasor>& band = to.bands.front();
  for (Image<float>* const map : {&to.maps.modulation, &to.maps.wrapped_phase}) {
    if (map->size() != band.size()) *map = Image<float>(band.size());
  }

  polar_pixels(band, to.maps.modulation, to.maps.wrapped_phase);
  convert(weighted_sum(frames, decode_.layout().bands.front().mean), to.maps.mean);
}

void PhaseReader::judge(const FrameViews& frames, CameraPhases& to) const {
  // Unless bands alone give the order, neighbours may contradict it: the full judgement.
  if (order_source(decode_.layout()) != OrderSource::bands) {
    BasicMaps<double> maps;
    convert(to.maps, maps);
    to.validity = judged(maps, {}, frames, setup_);
    return;
  }

  // Bands alone: only the light decides.
  const auto least = static_cast<float>(least_modulation(setup_.settings, frames.full_scale()));
  if (to.validity.size() != frames.size()) to.validity = Image<Validity>(frames.size());
  std::ranges::transform(to.maps.modulation, saturation_mask(frames), to.validity.begin(),
                         [&](float B, std::uint8_t saturated) {
                           if (!(B >= least)) return Validity::too_dark;
                           return setup_.settings.drop_saturated && saturated != 0
                                      ? Validity::saturated
                                      : Validity::valid;
                         });
}

}  // namespace slipstream
