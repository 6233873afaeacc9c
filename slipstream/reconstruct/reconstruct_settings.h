#pragma once

#include <limits>
#include <optional>
#include <string_view>

#include "slipstream/base/setting.h"
#include "slipstream/cloud/cleaner.h"
#include "slipstream/codes/sequence.h"
#include "slipstream/decode/cue_evidence.h"
#include "slipstream/decode/maps.h"
#include "slipstream/decode/phase_decoder.h"
#include "slipstream/geometry/scanner.h"

namespace slipstream {

/// What turns frames into a cloud.
enum class EngineKind {
  automatic,  ///< `fused` where it can, else `reference`; no GPU, see docs/gpu.md
  reference,  ///< in double, stage by stage over the whole picture: any layout, frames and lens
  fused,      ///< in float, one pass over the pixels; `reference` stands in where it cannot
  gpu,        ///< what `fused` computes, by Vulkan; `fused` stands in where it cannot or fails
};

/// What decides whether a pixel becomes a point, and how it is computed.
struct ReconstructSettings {
  EngineKind engine = EngineKind::automatic;
  PhaseMethod phase_method = PhaseMethod::tables;  ///< of the reference engine
  double minimum_modulation = 15;  ///< least modulation B^c, grey levels of 255 whatever the bits
  /// A pixel with a saturated frame is dropped (`false` keeps it, biased).
  bool drop_saturated = true;
  /// When the fringe order of several bands, or of a cue, is believed.
  FringeOrderConsensus fringe_order{};
  /// Of a strategy whose fringe order comes from a cue in the same frames.
  CueRule cue_rule = CueRule::consensus;
  /// Likewise: a pixel is asked for its neighbours' orders from this share of the least modulation
  /// on, though it may be too dark for a point.
  double least_voting_share = 0.8;
  /// How far past the ends of the projector's field, as a share of its length across the stripes, a
  /// point may lie.
  double field_margin = 0.02;
  std::optional<double> nearest{};   ///< mm, least depth; none: see depth_range
  std::optional<double> farthest{};  ///< mm, largest depth; none: see depth_range
  /// Which points of a finished cloud are left out.
  CleanSettings clean{};
  /// Of EngineKind::gpu: the device, see gpu_devices; none: that which Gpu::open chooses.
  std::optional<int> gpu{};

  /// Without those of `clean`, and those that have names: see set_backend and cue_rule_named.
  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    visit({.name = "minimum_modulation",
           .unit = "grey levels",
           .least = 0,
           .most = std::numeric_limits<double>::max(),
           .flag = "--min-modulation",
           .help = "least modulation, grey levels of 255 whatever the camera's bits",
           .live = {"least modulation of a point", "grey levels of 255", 0, 127}},
          self.minimum_modulation);
    visit({.name = "drop_saturated",
           .flag = "--keep-saturated",
           .help = "keep pixels with a saturated frame",
           .flag_clears = true,
           .live = {"pixels with a saturated frame become points"}},
          self.drop_saturated);
    FringeOrderConsensus::for_each_setting(self.fringe_order, visit);
    visit({.name = "least_voting_share"}, self.least_voting_share);
    visit({.name = "field_margin", .least = 0}, self.field_margin);
    visit({.name = "nearest",
           .flag = "--nearest",
           .help = "least depth, mm; half of the nearest calibrated where not given"},
          self.nearest);
    visit({.name = "farthest",
           .flag = "--farthest",
           .help = "largest depth, mm; twice the farthest calibrated where not given"},
          self.farthest);
  }

  friend bool operator==(const ReconstructSettings&, const ReconstructSettings&) = default;
};

inline constexpr const char* backend_forms =
    "fused, gpu or gpu:NUMBER (see slipstream gpu list), lut, closed-form, equation or "
    "intensity-ratio";

/// Sets engine and method by one of these names; the last four are of the reference engine. Throws
/// Error for another.
void set_backend(ReconstructSettings& settings, std::string_view name);

/// All that an engine is made of.
struct EngineSetup {
  Scanner scanner{};
  Sequence sequence{};
  ReconstructSettings settings{};

  friend bool operator==(const EngineSetup&, const EngineSetup&) = default;
};

/// The depths that may become points, mm. Where the settings say none: from half the nearest to
/// twice the farthest that the calibration's boards covered; any where the scanner does not know
/// these.
DepthRange depth_range(const EngineSetup& setup);

/// Whether the fringe order comes from the range of depth: frames that give no projector coordinate
/// alone, and both ends of the range named.
bool unwraps_by_depth(const EngineSetup& setup);

/// Whether it comes from the whole picture rather than from a pixel's frames: that, or surfaces.
bool unwraps_by_picture(const EngineSetup& setup);

/// Throws Error where the scanner or the settings are not valid or see no depth along that axis, or
/// where the strategy is too fine for the projector. An ambient light that is not known is taken
/// for none: see needs_ambient_light.
void require_valid(const EngineSetup& setup);

/// Likewise, and where the frames of one camera give no projector coordinate, alone or by the range
/// of depth.
void require_reconstructible(const EngineSetup& setup);

/// Throws Error, naming `scanner`, where the layout has a cue that cannot be read without an
/// ambient light that the scanner does not know.
void require_ambient_known(const EngineSetup& setup, std::string_view scanner);

/// What a cue needs beside the frames: light of patterns and room, noise, the rule.
CueSettings cue_settings(const EngineSetup& setup);

/// What is added to each band's phase so that the scanner's response does not show; none where it
/// is not known.
PhaseCorrections phase_corrections(const EngineSetup& setup);

/// What the frames' noise does to depth, to first order and but for the projector's distortion:
/// Eq. (3.40) or (3.63) through the derivative of the point. For frames of 8 bits.
DepthNoise depth_noise(const EngineSetup& setup);

/// Projector pixels along the axis of the patterns.
int projector_length(const EngineSetup& setup);

/// The least modulation of a point, grey levels of 255: the settings', or more where noise would
/// hide the fringe order, see CueEvidence::least_modulation.
double least_modulation(const EngineSetup& setup);

/// Raises that of the settings to it; who has a vote stays the same.
void raise_least_modulation(EngineSetup& setup);

/// The modulation threshold, grey levels of frames whose largest is `full_scale`.
double least_modulation(const ReconstructSettings& settings, double full_scale);

/// That from which a pixel is asked for its neighbours' orders, likewise.
double least_neighbour_modulation(const ReconstructSettings& settings, double full_scale);

}  // namespace slipstream
