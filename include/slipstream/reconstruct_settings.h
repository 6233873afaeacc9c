#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "slipstream/cleaner.h"
#include "slipstream/frame_set.h"
#include "slipstream/maps.h"
#include "slipstream/scanner.h"
#include "slipstream/sequence.h"

namespace slipstream {

/// Implementation that turns frames into a cloud.
enum class EngineKind {
  automatic,  ///< `fused` if possible, else `reference`; no GPU, see docs/how-to/gpu.md
  reference,  ///< in double, stage by stage over the whole image: any layout, frames and lens
  fused,      ///< in float, one pass over the pixels; if not possible, `reference`, with a reason
  gpu,        ///< `fused` on a GPU, through Vulkan; if not possible or on failure, `fused`
};

/// Requested outputs of a scan; null: not requested. At most one of cloud, depth, depth16 and
/// points, and no maps with points. Outputs that have the image's size already keep their memory.
struct Outputs {
  Cloud* cloud = nullptr;
  Depth* depth = nullptr;
  Image<std::uint16_t>* depth16 = nullptr;  ///< depth by `scale`, without validity
  PackedPoints* points = nullptr;           ///< from the fused pass only
  Maps* maps = nullptr;  ///< coordinates from each pixel alone, not confirmed by its neighbours
  Image<float>* modulation = nullptr;  ///< as in `maps`, if the rest is not requested
  DepthScale scale{};

  [[nodiscard]] bool makes_points() const {
    return cloud != nullptr || depth != nullptr || depth16 != nullptr || points != nullptr;
  }
};

/// Your own engine, in place of slipstream's.
struct OwnEngine {
  std::string name;  ///< returned by Engine::backend_for
  /// Computes the requested outputs, never points, from the adapted frames of a scan. Called from
  /// all threads that have a copy of the Engine.
  std::function<void(const FrameViews& frames, const Outputs& outputs)> run;
};

/// Settings that decide whether a pixel becomes a point, and how the point is computed.
struct ReconstructSettings {
  EngineKind engine = EngineKind::automatic;
  std::shared_ptr<const OwnEngine> own_engine{};   ///< replaces `engine` unless null
  PhaseMethod phase_method = PhaseMethod::tables;  ///< of the reference engine

  double minimum_modulation = 15;  ///< least modulation B^c, grey levels of 255 for any bit depth
  /// Drops pixels with a saturated frame; `false` keeps them, biased.
  bool drop_saturated = true;

  /// When to trust a fringe order from several bands or from a cue.
  FringeOrderConsensus fringe_order{};
  /// For strategies whose fringe order comes from a cue in the same frames.
  CueRule cue_rule = CueRule::consensus;
  /// For the same strategies: share of the least modulation from which even dark pixels vote.
  double least_voting_share = 0.8;

  /// How far outside the field a point may lie, as a share of its length across the stripes.
  double field_margin = 0.02;
  std::optional<double> nearest{};   ///< mm, least depth; nullopt: see depth_range
  std::optional<double> farthest{};  ///< mm, largest depth; nullopt: see depth_range

  /// Which points of a finished cloud are removed.
  CleanSettings clean{};

  /// For EngineKind::gpu: the device, see gpu_devices; nullopt: Gpu::open chooses one.
  std::optional<int> gpu{};

  /// All except `clean` and settings with named values: see set_backend and cue_rule_named.
  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    // Light.
    visit({.name = "minimum_modulation",
           .option = "min-modulation",
           .help = "least modulation, grey levels of 255 for any bit depth of the camera",
           .unit = "grey levels",
           .least = 0,
           .most = std::numeric_limits<double>::max(),
           .live = {"least modulation of a point", "grey levels of 255", 0, 127}},
          self.minimum_modulation);
    visit({.name = "drop_saturated",
           .option = "keep-saturated",
           .help = "keep pixels with a saturated frame",
           .option_clears = true,
           .live = {"pixels with a saturated frame become points"}},
          self.drop_saturated);

    // Fringe orders.
    FringeOrderConsensus::for_each_setting(self.fringe_order, visit);
    visit({.name = "least_voting_share"}, self.least_voting_share);

    // Where a point may lie.
    visit({.name = "field_margin", .least = 0}, self.field_margin);
    visit({"nearest", "nearest", "least depth, mm; default: half the nearest calibrated depth"},
          self.nearest);
    visit(
        {"farthest", "farthest", "largest depth, mm; default: twice the farthest calibrated depth"},
        self.farthest);
  }

  friend bool operator==(const ReconstructSettings&, const ReconstructSettings&) = default;
};

inline constexpr const char* backend_forms =
    "fused, gpu or gpu:NUMBER (see `gpu_list()`), lut, closed-form, equation or "
    "intensity-ratio";

/// Sets engine and phase method by one of these names; the last four select the reference engine.
/// Throws Error for other names.
void set_backend(ReconstructSettings& settings, std::string_view name);

/// Everything that an engine is made from.
struct EngineSetup {
  Scanner scanner{};
  Sequence sequence{};
  ReconstructSettings settings{};

  friend bool operator==(const EngineSetup&, const EngineSetup&) = default;
};

/// Depths at which points are valid, mm: as set, else from half the nearest to twice the farthest
/// depth of the calibration boards, else any.
DepthRange depth_range(const EngineSetup& setup);

/// Throws Error if scanner or settings are invalid or measure no depth along the axis, or if the
/// strategy is too fine for the projector. An unknown ambient light counts as 0.
void require_valid(const EngineSetup& setup);

/// As require_valid; also if one camera's frames give no coordinate, alone or by the depth range.
void require_reconstructible(const EngineSetup& setup);

/// Throws Error, naming `scanner`, if a cue needs the ambient light and the scanner lacks it.
void require_ambient_known(const EngineSetup& setup, std::string_view scanner);

/// Effect of noise in 8-bit frames on depth, to first order and without the projector's
/// distortion: Eq. (3.40) or (3.63) through the derivative of the point.
DepthNoise depth_noise(const EngineSetup& setup);

}  // namespace slipstream
