#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "slipstream/cloud/cleaner.h"
#include "slipstream/codes/sequence.h"
#include "slipstream/decode/cue_evidence.h"
#include "slipstream/decode/maps.h"
#include "slipstream/decode/phase_decoder.h"
#include "slipstream/frames/frame_set.h"
#include "slipstream/geometry/scanner.h"

namespace slipstream {

/// What turns frames into a cloud.
enum class EngineKind {
  automatic,  ///< `fused` where it can, else `reference`; no GPU, see docs/how-to/gpu.md
  reference,  ///< in double, stage by stage over the whole picture: any layout, frames and lens
  fused,      ///< in float, one pass over the pixels; where it cannot, `reference`, saying why
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
  /// Likewise: the share of the least modulation from which a pixel votes, too dark for a point or
  /// not.
  double least_voting_share = 0.8;
  /// How far past the projector's field, as a share of its length across the stripes, a point may
  /// lie.
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

/// What is wanted of a scan; null is not. At most one of cloud, depth, depth16 and points, and no
/// maps beside points. An output's memory is used again where it is of the picture's size.
struct Outputs {
  Cloud* cloud = nullptr;
  Depth* depth = nullptr;
  Image<std::uint16_t>* depth16 = nullptr;  ///< depth by `scale`, without reasons
  PackedPoints* points = nullptr;           ///< by the fused pass alone
  Maps* maps = nullptr;  ///< coordinates as each pixel says them, not confirmed by its neighbours
  Image<float>* modulation = nullptr;  ///< that of the maps, where the rest of them is not wanted
  DepthScale scale{};

  [[nodiscard]] bool makes_points() const {
    return cloud != nullptr || depth != nullptr || depth16 != nullptr || points != nullptr;
  }
};

/// An engine of one's own, in the place of slipstream's.
struct OwnEngine {
  std::string name;  ///< what Engine::backend_for says
  /// Makes what is wanted of the adapted frames of a scan, but never points. Called from all
  /// threads that have a copy of the Engine.
  std::function<void(const FrameViews& frames, const Outputs& outputs)> run;
};

/// All that an engine is made of.
struct EngineSetup {
  Scanner scanner{};
  Sequence sequence{};
  ReconstructSettings settings{};
  std::shared_ptr<const OwnEngine> own_engine{};  ///< null: as the settings say

  friend bool operator==(const EngineSetup&, const EngineSetup&) = default;
};

/// Throws Error where the frames are not of the camera's size.
void require_size(const FrameViews& frames, Size camera);

/// The depths that may become points, mm: as set, else from half the nearest to twice the farthest
/// that the calibration's boards covered, else any.
DepthRange depth_range(const EngineSetup& setup);

/// Whether the fringe order comes from the range of depth: both its ends are set, and the frames
/// give no projector coordinate alone.
bool unwraps_by_depth(const EngineSetup& setup);

/// Whether it comes from the whole picture rather than from a pixel's frames: that, or surfaces.
bool unwraps_by_picture(const EngineSetup& setup);

/// Throws Error where scanner or settings are not valid or see no depth along that axis, or where
/// the strategy is too fine for the projector. An unknown ambient light counts as none.
void require_valid(const EngineSetup& setup);

/// Likewise, and where one camera's frames give no coordinate, alone or by the range of depth.
void require_reconstructible(const EngineSetup& setup);

/// Throws Error, naming `scanner`, where a cue needs an ambient light unknown to the scanner.
void require_ambient_known(const EngineSetup& setup, std::string_view scanner);

/// What a cue needs beside the frames: light of patterns and room, noise, the rule.
CueSettings cue_settings(const EngineSetup& setup);

/// What is added to each band's phase to correct for the scanner's response; none if unknown.
PhaseCorrections phase_corrections(const EngineSetup& setup);

/// What the noise of 8-bit frames does to depth, to first order and without the projector's
/// distortion: Eq. (3.40) or (3.63) through the derivative of the point.
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
