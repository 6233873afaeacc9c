#include "slipstream/check/scan_check.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <numeric>
#include <utility>

#include "slipstream/base/quantile.h"
#include "slipstream/check/explanations.h"
#include "slipstream/check/frame_faults.h"

namespace slipstream {
namespace {

LightEvidence light_of(const FrameModel& model, const ScanSamples& samples, int bits,
                       double least_modulation) {
  LightEvidence light{.bits = bits, .least_modulation = least_modulation};
  const FrameOrder order = model.identity();
  std::vector<double> modulations, means;
  SampleReading reading;
  for (std::size_t g = 0; g < samples.groups(); ++g) {
    const float* const levels = samples.levels(g, ScanSamples::middle);
    means.push_back(std::accumulate(levels, levels + samples.frames(), 0.0) / samples.frames());
    model.read(levels, order, reading);
    double modulation = std::numeric_limits<double>::infinity();
    for (std::size_t b = 0; b < reading.modulation.size(); ++b) {
      modulation = std::min(modulation, reading.modulation[b] / model.layout().bands[b].share);
    }
    modulations.push_back(modulation);
  }
  if (!means.empty()) {
    light.modulation = quantile(modulations, 0.5);
    light.mean = quantile(means, 0.5);
  }
  return light;
}

void append(std::vector<Finding>& findings, std::vector<Finding> more) {
  std::move(more.begin(), more.end(), std::back_inserter(findings));
}

/// Frames of a sinusoid differ by 1.5 modulations at least: of three steps, where one of them is at
/// the crest.
constexpr double range_of_modulation = 1.5;

}  // namespace

double least_range(const CheckSettings& settings) {
  constexpr double dimmest = 10;
  return range_of_modulation * std::max(dimmest, settings.minimum_modulation);
}

ScanFindings check_frames(const FrameViews& frames, const Sequence& sequence,
                          const std::optional<Scanner>& scanner, const CheckSettings& settings) {
  // Frames that are taken out of one are no evidence of each other, and dark along every edge.
  if (sequence.strategy.is_spectral()) {
    return {.findings = scanner ? check_scanner(*scanner) : std::vector<Finding>(), .order = {}};
  }
  const double least = settings.minimum_modulation;
  const PhotometricCalibration& photometry = scanner ? scanner->photometry : settings.photometry;
  const FrameModel model(sequence, photometry);
  ScanSamples samples(frames.size(), frames.count());
  samples.take(frames, {.least_range = least_range(settings)});
  const bool too_dim_to_judge = samples.groups() == 0 && samples.saturated() == 0 &&
                                samples.largest_range() >= range_of_modulation * least;
  if (too_dim_to_judge) return {};

  ScanFindings result;
  result.findings = light_faults(samples, light_of(model, samples, frames.bits(), least));
  if (any_wrong(result.findings)) return result;
  std::vector<Finding> damaged = damaged_frames(samples);
  const bool whole = damaged.empty();
  append(result.findings, std::move(damaged));
  // What a damaged frame does to the rest explains nothing more.
  if (!whole || any_wrong(result.findings)) return result;
  std::vector<Finding> of_scanner;
  if (scanner) of_scanner = check_scanner(*scanner, false);
  if (any_wrong(of_scanner)) {
    append(result.findings, std::move(of_scanner));
    return result;
  }
  Explained explained = explain({model, samples, sequence, scanner ? &*scanner : nullptr,
                                 photometry, settings.moving, settings.order});
  // A picture cut out of the sensor's has its middle elsewhere, and fits.
  if (scanner && !explained.findings.empty()) of_scanner = check_scanner(*scanner, true);
  append(result.findings, std::move(of_scanner));
  append(result.findings, std::move(explained.findings));
  result.order = std::move(explained.order);
  return result;
}

ScanFindings check_scan(const Scan& scan, const CheckSettings& settings) {
  CheckSettings with_order = settings;
  with_order.order = scan.order;
  return check_frames(scan.frames, scan.sequence, scan.scanner, with_order);
}

}  // namespace slipstream
