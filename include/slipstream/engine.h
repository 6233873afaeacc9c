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
#include "slipstream/scan.h"
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
struct CustomEngine {
  std::string name;  ///< returned by Engine::backend_for
  /// Computes the requested outputs, never points, from the adapted frames of a scan. Called from
  /// all threads that have a copy of the Engine.
  std::function<void(const FrameViews& frames, const Outputs& outputs)> run;
};

/// Settings that decide whether a pixel becomes a point, and how the point is computed.
struct ReconstructSettings {
  EngineKind engine = EngineKind::automatic;
  std::shared_ptr<const CustomEngine> custom_engine{};  ///< replaces `engine` unless null
  PhaseMethod phase_method = PhaseMethod::tables;       ///< of the reference engine

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

  /// Whether points of clouds are moved to where they would lie without the camera's blur, which
  /// pulls coordinates towards the brighter side where reflectivity changes. Needs the whole
  /// picture, and phases: codes alone have none. Depths and packed points stay as measured.
  bool correct_contrast = false;

  /// Which points of a finished cloud are removed.
  CleanSettings clean{};

  /// For EngineKind::gpu: the device, see gpu_devices; nullopt: Gpu::open chooses one.
  std::optional<int> gpu{};

  /// All except `clean` and settings with named values: see set_backend and cue_rule_named.
  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    // Light.
    visit({.name = "minimum_modulation",
           .option = "minimum-modulation",
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
    visit({.name = "least_voting_share",
           .help = "share of the minimum modulation from which a pixel votes"},
          self.least_voting_share);

    // Where a point may lie.
    visit({.name = "field_margin",
           .help = "how far points may lie outside the projector's field, as a share of it",
           .least = 0},
          self.field_margin);
    visit({"nearest", "nearest", "least depth, mm; default: half the nearest calibrated depth"},
          self.nearest);
    visit(
        {"farthest", "farthest", "largest depth, mm; default: twice the farthest calibrated depth"},
        self.farthest);
    visit({.name = "correct_contrast",
           .option = "correct-contrast",
           .help = "move points back to where they lie without the camera's blur, which pulls them "
                   "at edges of print"},
          self.correct_contrast);
  }

  friend bool operator==(const ReconstructSettings&, const ReconstructSettings&) = default;
};

inline constexpr const char* backend_forms =
    "fused, gpu or gpu:NUMBER (see `gpu_list()`), lut, closed-form, equation or "
    "intensity-ratio";

/// Sets engine and phase method by one of these names; the last four select the reference engine.
/// Throws Error for other names.
void set_backend(ReconstructSettings& settings, std::string_view name);

/// Keeps all points: without cleaning, and without a limit of depth that is not set.
void keep_all_points(ReconstructSettings& settings);

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

/// Converts frames to clouds and maps for one scanner and one sequence; all reconstruction goes
/// through it. Builds its tables once and reuses its memory: from the second call on it does not
/// allocate if it gets the same outputs. Corrects phases for the scanner's response if known, and
/// cleans clouds as the settings say; CleanSettings::none() turns cleaning off. A scanner without
/// geometry (see has_geometry) gives maps only; other outputs throw Error.
///
/// For one thread at a time. Copies share the tables but not the memory: make one per thread.
class Engine {
 public:
  /// Throws Error as require_reconstructible does; as require_valid without geometry.
  explicit Engine(const EngineSetup& setup);
  Engine(const Scanner& scanner, const Sequence& sequence,
         const ReconstructSettings& settings = {});

  Engine(const Engine& other);
  Engine(Engine&& other) noexcept = default;
  Engine& operator=(Engine other) noexcept;

  [[nodiscard]] const EngineSetup& setup() const;

  /// Frames with exposures merged and multiplexed frames separated, in memory that lasts until the
  /// next call; other frames are returned unchanged. All calls below do this themselves.
  [[nodiscard]] const FrameViews& merged(const FrameViews& frames);

  /// Computes the requested outputs with the chosen engine or, failing that, the next in this
  /// order: GPU, fused pass, reference engine. In windows longer than a cycle, rejects pixels whose
  /// frames differ by more than noise and uniform motion explain; of clouds, if set, points that
  /// other surfaces light, and moves those that contrast pulled; then cleans the cloud. Returns how
  /// many points cleaning removed, by reason. Throws Error for a wrong size or frame count.
  ValidityCounts run(const FrameViews& frames, const Outputs& outputs);

  ValidityCounts cloud(const FrameViews& frames, Cloud& cloud) {
    return run(frames, {.cloud = &cloud});
  }

  /// Computes and writes less than a cloud does; not cleaned.
  void depth(const FrameViews& frames, Depth& depth) { run(frames, {.depth = &depth}); }

  /// Depth only, quantised to 16 bits; pixels without a point are 0.
  void depth(const FrameViews& frames, const DepthScale& scale, Image<std::uint16_t>& numbers) {
    run(frames, {.depth16 = &numbers, .scale = scale});
  }

  /// Only the valid points, not cleaned, in an order that does not depend on the number of threads.
  /// Written by the fused pass unless frames are merged or a motion window, else copied.
  void points(const FrameViews& frames, PackedPoints& points) { run(frames, {.points = &points}); }

  /// Coordinates from each pixel alone, not yet confirmed or rejected by its neighbours.
  void maps(const FrameViews& frames, Maps& maps) { run(frames, {.maps = &maps}); }

  /// Both in one pass.
  ValidityCounts cloud_and_maps(const FrameViews& frames, Cloud& cloud, Maps& maps) {
    return run(frames, {.cloud = &cloud, .maps = &maps});
  }

  /// Share of the measured pixels whose phase moves, see MotionMeasurement; 0 for up to one cycle.
  [[nodiscard]] double moving_share(const FrameViews& frames) const;

  /// Standard deviation of each point of a scan under the scanner's noise variance at the pixel's
  /// mean (1.6 if unknown): of y by Eq. (3.40) or (3.63), of X, Y, Z through the derivative of the
  /// point. `frames`: the ones that `cloud` and `maps` were made from.
  [[nodiscard]] Uncertainty uncertainty(const Cloud& cloud, const Maps& maps,
                                        const FrameViews& frames);

  /// Backend used for such frames: "fused", "gpu" until it fails in any copy, or the phase method
  /// of the reference engine: "lut", "equation", "closed-form"; "reference (lut)" if `lut` was
  /// chosen, but the table engine does not take them.
  [[nodiscard]] std::string backend_for(const FrameViews& frames);

  /// Why the chosen or default engine does not take scans such as the newest, and what replaces it,
  /// one line; empty if it does.
  [[nodiscard]] std::string fallback_reason() const;

 private:
  void compute(const FrameViews& frames, const Outputs& outputs, const Image<float>* coarse);
  void compute_by_picture(const FrameViews& frames, const Outputs& outputs);
  void reject_moved(const FrameViews& frames, const Outputs& outputs);
  void reject_reflected(const FrameViews& frames, const Outputs& outputs);

  struct Tables;
  struct Memory;

  std::shared_ptr<Tables> tables_;
  std::shared_ptr<Memory> memory_;  ///< not shared by copies
};

/// Setup of an engine for this scan: its scanner, completed from the scan, its sequence, and the
/// settings. Throws Error if the scan has no scanner, does not fit it, or has a cue that needs the
/// ambient light and the scanner does not know it.
EngineSetup setup_for(const Scan& scan, const ReconstructSettings& settings = {});

/// Result of comparing a scan with patterns along the other axis. It reveals only errors across the
/// epipolar line: where the line runs along x, errors of x alone stay hidden.
///
/// The distance of a pixel from its epipolar line has two parts. A `common` part, a quadratic
/// function of the place in the picture, is an error of the calibration: it moves all points a
/// little and contradicts none. The rest is the pixel's own, and is compared with its noise.
struct EpipolarCheck {
  double median = 0;         ///< of the points' distances, projector pixels
  double median_length = 0;  ///< of their absolute values
  double median_sigma = 0;   ///< of their standard deviations due to noise
  double common = 0;         ///< of the absolute values of the common part, the 90 % quantile
  /// Its sizes: at the picture's centre, and its linear and quadratic terms from there to the
  /// edges.
  double constant = 0, linear = 0, quadratic = 0;
  double own = 0;           ///< of the absolute values of the points' own parts, the median
  std::size_t points = 0;   ///< compared
  std::size_t doubted = 0;  ///< points farther off than the common part and noise explain

  /// The largest doubted share of the points of a scan whose axes agree.
  static constexpr double most_doubted = 1.0 / 3;
  [[nodiscard]] double doubted_share() const;

  /// The largest common part, pixels, that noise and a good calibration explain: half a pixel, or
  /// if more, twice `calibration_rms`, 0 if unknown, see Scanner, or a quarter of the points' own
  /// parts, of few points more.
  [[nodiscard]] double most_common(double calibration_rms) const;

  /// Whether the common part exceeds that.
  [[nodiscard]] bool is_off(double calibration_rms) const;

  /// Whether it exceeds 3 pixels and five times `calibration_rms`: the scanner is another one.
  [[nodiscard]] bool is_far_off(double calibration_rms) const;

  /// Whether the axes contradict each other, so that no point is sure: too many points are doubted,
  /// or the common part is far off.
  [[nodiscard]] bool contradicts(double calibration_rms) const;
};

/// Light in the frames of a scan, with or without a scanner.
struct PictureReport {
  Image<Validity> validity{};  ///< `too_dark`, `saturated` or `valid`
  double modulation = 0;       ///< median of the valid pixels, grey levels of 255; 0 without any
};

/// `maps`: of these frames, which must be merged if there are several exposures: Engine::merged.
PictureReport picture_report(const FrameViews& frames, const Maps& maps,
                             const ReconstructSettings& settings);

/// Projector coordinates of pixels that are lit, not saturated and confirmed by their neighbours,
/// NaN elsewhere; with or without a scanner. Throws Error if the frames alone give none.
Image<double> measured_coordinates(Engine& engine, const FrameViews& frames);
/// The same from the engine's maps of these frames.
Image<double> measured_coordinates(Engine& engine, const FrameViews& frames, const Maps& maps);

}  // namespace slipstream
