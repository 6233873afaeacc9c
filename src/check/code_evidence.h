#pragma once

#include <array>
#include <cmath>
#include <string_view>

#include "check/frame_model.h"
#include "check/scan_samples.h"
#include "slipstream/finding.h"

namespace slipstream {

/// What the frames of a code, or of single frames, reveal without geometry. All 0 if right.
struct CodeEvidence {
  /// Share of the pixels in which the middle of white and black does not part dark bits from bright
  /// ones.
  double disordered = 0;
  double unlisted = 0;  ///< share of the pixels whose code word numbers no stripe
  /// Share of the pixels in which a bit and its inverse together are too bright, or too dark,
  /// whichever is smaller: of the worst bit. Blur through a tone curve does only one of both.
  double unpaired = 0;
  /// Between neighbours that differ in one bit of a Gray code, the finer bits are 1, 0, 0, ... if
  /// the stripes are next to each other: the share that contradicts, of the worst bit. Ignores as
  /// many of the finest bits as have stripes narrower than two pixels, or blurred ones.
  double torn = 0;
  /// Share of the pixels in which a bit is half way between dark and bright, less the share of a
  /// finer bit, at most: blur spoils finer stripes first. 0 with a base.
  double blurred = 0;
  double incoherence = 0;  ///< of the phase at the code's edges: 1 - |mean exp(i phi)|
  /// Mean phase at the code's edges, or error of the origin by single frames, periods, -0.5 to 0.5;
  /// within the limit if blur, a tenth of a pixel, may be the cause.
  double offset = 0;
  /// Change of that phase across the field, periods: of stripes that are not as wide as a period.
  double drift = 0;
  double against = 0;  ///< share of the edges across which the phase runs against the code
  double doubt = 0;    ///< median of the coordinate's doubt: see PixelCoordinate
  /// Share of pixels in which a bit equals its inverse, for a code alone with inverses: of the
  /// worst bit whose stripes the camera resolves. 1 for others. Its bits need no other evidence: a
  /// camera may change their brightness as it likes.
  double unsure = 1;
  bool has_edges = false;  ///< whether enough edges were found to compare phases with the code

  /// Right scans reach 0.1; a lost or exchanged frame leaves half of the pixels unsure.
  [[nodiscard]] bool bits_are_sure() const { return unsure <= 0.25; }

  /// Drifts from a rounded width of the stripes on, up to less than another number of periods.
  static constexpr double least_drift = 0.1, most_drift = 0.7;
  [[nodiscard]] bool drifts() const {
    return std::abs(drift) >= least_drift && std::abs(drift) <= most_drift;
  }
};

/// `phases`: whether to compare phases with the code, which takes most of the time.
CodeEvidence code_evidence(const FrameModel& model, const ScanSamples& samples,
                           const FrameOrder& order, bool phases = true);

/// A likely cause, and its words.
struct SymptomCause {
  CauseKind kind = CauseKind::unclear;
  std::string_view text{};
};

/// One kind of contradiction, its limit, and the cause and advice to give if no tried remedy fits.
struct CodeSymptom {
  FindingKind kind;
  std::string_view what;      ///< with {} for the limit in percent
  std::string_view quantity;  ///< name of the value
  double CodeEvidence::*value;
  double limit;
  std::array<SymptomCause, 2> causes;  ///< the second without text: there is only one
  std::string_view compare;            ///< "SOMETHING with": the patterns follow
};

extern const std::array<CodeSymptom, 9> code_symptoms;

}  // namespace slipstream
