#include "slipstream/check/scan_check.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "slipstream/check/explanations.h"
#include "slipstream/check/fit.h"
#include "slipstream/check/frame_faults.h"
#include "slipstream/image/quantile.h"

namespace slipstream {
namespace {

LightEvidence light_of(const FrameModel& model, const ScanSamples& samples, int bits,
                       double least_modulation) {
  LightEvidence light{.bits = bits, .least_modulation = least_modulation};
  std::vector<double> modulations, means;
  for (std::size_t g = 0; g < samples.groups(); ++g) {
    const float* const levels = samples.levels(g, ScanSamples::middle);
    means.push_back(std::accumulate(levels, levels + samples.frames(), 0.0) / samples.frames());
    modulations.push_back(
        model.decode(samples, g, ScanSamples::middle, model.identity()).modulation);
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

ScanFindings check_frames(const FrameViews& frames, const Sequence& sequence,
                          const std::optional<Scanner>& scanner, const CheckSettings& settings) {
  const double least = settings.minimum_modulation.value_or(15 * frames.full_scale() / 255) * 255 /
                       frames.full_scale();
  const PhotometricCalibration photometry =
      scanner ? scanner->photometry : PhotometricCalibration{};
  const FrameModel model(sequence, photometry);
  ScanSamples samples(frames.size(), frames.count());
  // Frames of a sinusoid differ by at least 1.5 modulations, of a share of one by that of it.
  samples.take(frames, {.least_range = 1.5 * least});

  ScanFindings result;
  result.findings = light_faults(samples, light_of(model, samples, frames.bits(), least));
  if (any_wrong(result.findings)) return result;
  append(result.findings, damaged_frames(samples));
  std::vector<Finding> of_scanner = scanner ? check_scanner(*scanner) : std::vector<Finding>{};
  const bool usable = scanner && !any_wrong(of_scanner);
  append(result.findings, std::move(of_scanner));
  if (any_wrong(result.findings)) return result;
  Explained explained =
      explain({model, samples, sequence, usable ? &*scanner : nullptr, photometry});
  append(result.findings, std::move(explained.findings));
  result.order = std::move(explained.order);
  return result;
}

}  // namespace

ScanFindings check_scan(const Scan& scan, const CheckSettings& settings) {
  ScanFindings result = check_frames(scan.frames, scan.sequence, scan.scanner, settings);
  for (std::size_t i = 0; i < scan.further_cameras.size(); ++i) {
    const Scan& further = scan.further_cameras[i];
    for (Finding& finding :
         check_frames(further.frames, further.sequence, further.scanner, settings).findings) {
      finding.what = fmt::format("camera {}: {}", i + 2, finding.what);
      result.findings.push_back(std::move(finding));
    }
  }
  return result;
}

}  // namespace slipstream
