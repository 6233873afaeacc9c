#pragma once

#include <optional>
#include <string>
#include <vector>

#include "decode/cue_evidence.h"
#include "decode/phase_decoder.h"
#include "geometry/ray_blocks.h"
#include "geometry/ray_table.h"
#include "reconstruct/fused/cue_rows.h"
#include "reconstruct/fused/order_rows.h"
#include "reconstruct/fused/point_rows.h"
#include "reconstruct/fused/sinusoid_rows.h"
#include "reconstruct/fused/unwrap_rows.h"
#include "reconstruct/fused/vote_rows.h"
#include "slipstream/engine.h"

namespace slipstream {

/// Stages of the fused pass for one scanner, layout and axis, in the order of execution.
struct FusedStages {
  struct BandStage {
    SinusoidStage sinusoid;
    int first_frame = 0;  ///< first frame of the band
    double periods = 1;
    float weight = 0;  ///< of its coordinate, see band_weights
  };

  /// A sum of the bands' turns, unwrapped by the result of the link before.
  struct Link {
    std::vector<int> of;  ///< a factor for each of `bands`
    UnwrapStage unwrap{};
  };

  /// A binary code that starts the chain, or stands alone.
  struct CodeBits {
    CodeStage stage;
    bool against_mean = false;  ///< compare with the mean of the measuring band
    /// Otherwise a weight per frame; empty with inverse frames, and if bits are compared with the
    /// darkest and the brightest of them.
    std::vector<float> reference;
  };

  /// A cue in the frames of the first band identifies the period, with the neighbours' vote.
  struct Cue {
    CueStage stage;
    CueEvidence exact;  ///< for single pixels
    double f_h = 12;
    int projector_length = 0;  ///< pixels along the axis
    OrderCostStage costs;
  };

  int frames = 0;
  /// The measuring band first; with a cue it is the only one. Mirrored sinusoids last.
  std::vector<BandStage> bands{};
  std::vector<int> measured{};  ///< sum of `bands` that is the phase in maps; empty: the first
  std::vector<int> coarse{};    ///< start of the chain: a factor for each band; else empty
  std::optional<CodeBits> code{};
  bool coarse_given = false;       ///< the coordinate is an input, see unwraps_by_picture
  bool coarse_in_field = false;    ///< apply `coarse_stage`: the chain is not circular
  CoordinateStage coarse_stage{};  ///< brings the coordinate into the field
  std::vector<Link> chain{};  ///< empty: one band of one period, `orders`, a code alone or a cue
  std::optional<OrderStage> orders{};
  bool only_adds = false;     ///< the chain only adds up the sinusoids of a band of one period
  bool weighs_bands = false;  ///< the coordinate is a weighted mean over several bands
  std::optional<Cue> cue{};
  ConsensusStage consensus;  ///< with several bands or a cue
  /// Places coordinates in the field: from turns of a single band, or from fields with several.
  CoordinateStage coordinate;
  PointStage point;
  RayTable rays;
  /// Empty for small images. With one band the blocks cover only turns before the cut of
  /// `coordinate`.
  std::optional<RayBlocks> blocks;

  /// Whether the fringe order depends on the modulation of each band: Unwrapping::likelihood.
  [[nodiscard]] bool weighs_modulations() const { return orders && orders->steps == 0; }
  [[nodiscard]] bool reads_stripes() const { return code && code->stage.alone; }
  /// Whether neighbours confirm the fringe orders, so that rows become points one row late.
  [[nodiscard]] bool asks_neighbours() const { return !chain.empty() || orders || code || cue; }
  /// Whether maps tell the doubt of the fringe order.
  [[nodiscard]] bool has_doubt() const { return asks_neighbours() && !only_adds; }
};

/// Returns nullopt, and sets `why_not` unless it is null, if the fused pass cannot replace the
/// reference engine: a cue with a reference of one's own, with other weights in less than 7 frames
/// or in a second channel of shifted steps, a rule other than CueRule::consensus, a method of one's
/// own, carriers whose order comes from elsewhere than the bands, too many sinusoids to compare, no
/// coordinate, a lens whose model is not invertible over its picture, an image narrower than
/// `least_row_width`, a frequency above 16384 with a cue, or a field margin above a quarter.
std::optional<FusedStages> fused_stages(const EngineSetup& setup,
                                        const PhaseCorrections& corrections,
                                        std::string* why_not = nullptr);

/// Limits of one sinusoid for frames with this full scale and saturation, see FrameViews.
/// `mean_of`: levels of the mean per grey level of the frames.
SinusoidLimits sinusoid_limits(const SinusoidStage& stage, const ReconstructSettings& settings,
                               double full_scale, double saturation, double mean_of);

/// Limits of the cue for frames with this full scale.
CueLimits cue_limits(const FusedStages& stages, const ReconstructSettings& settings,
                     double full_scale);

}  // namespace slipstream
