#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "slipstream/check.h"
#include "slipstream/cloud.h"
#include "slipstream/engine.h"
#include "slipstream/gamma.h"
#include "slipstream/image.h"
#include "slipstream/maps.h"
#include "slipstream/scan.h"
#include "slipstream/scanner.h"
#include "slipstream/surface.h"

// From a scan to its results: response, check, reconstruction by one camera or two, comparison of
// both axes, doubts. The program, the Python module and other programs take this one way.
namespace slipstream {

struct FusedModel;

/// The kind of result of a scan. Only points need a scanner.
enum class ScanOutput { points, maps };

/// The results that a user wants of scans, and how they are made.
struct ScanJobSettings {
  ReconstructSettings reconstruct{};
  /// How the response is chosen that phases are corrected for: see choose_gamma. Two cameras match
  /// phases as measured.
  std::string gamma = "scanner";
  /// Ambient light and noise, which replace those of the first camera's scanner, if set; without a
  /// scanner all of it is used.
  PhotometricCalibration photometry{};

  ScanOutput output = ScanOutput::points;
  bool maps = false;              ///< also ScanResult::maps, beside points
  bool uncertainty = false;       ///< also ScanResult::uncertainty
  bool sure_coordinates = false;  ///< the maps' coordinate only where neighbours confirm it

  /// Reconstructs a scan although its check says that no point can be right, and keeps a result
  /// without points, or whose axes contradict each other.
  bool keep_refused = false;
  bool moving = false;  ///< the scene may move, see CheckSettings
  /// With two cameras, half the width, pixels, of the window whose matches are smoothed by a plane;
  /// 0: each match as found. See PhaseMatcher.
  int match_window = 5;
  /// Two cameras beside a calibrated projector: fuses the points that each measures with it,
  /// instead of matching the cameras. Three or more are always fused.
  bool fuse = false;
};

/// A scan that was checked, and repaired if that was certain.
struct CheckedJob {
  Scan scan{};
  EngineSetup setup{};                ///< for its engine, with the chosen response
  GammaChoice gamma{};                ///< the response in use
  CheckedScan checked{};              ///< of all cameras
  double choosing = 0, checking = 0;  ///< time taken, s

  bool fuses = false;  ///< with the points of other cameras
  /// If it fuses, the jobs of further cameras, unless the cameras find each other's fringe orders:
  /// then `scan` has both cameras.
  std::vector<CheckedJob> further{};
};

/// Chooses the response and checks the scan; puts slipped frames in order. Does not refuse it: see
/// any_wrong. `name`: of the scan in messages. Throws Error if it cannot be reconstructed: without
/// a scanner or a camera pair (RefusedScan if its frames alone are wrong), if the scanner does not
/// fit it, or if its frames give no depth. May be called from several threads.
CheckedJob checked_job(Scan scan, const ScanJobSettings& settings,
                       const std::string& name = "the scan");

/// Whether camera and projector stand as in the scanner, by a scan's guard.
struct GuardResult {
  std::optional<EpipolarCheck> epipolar{};  ///< nullopt if nothing was compared
  std::vector<Finding> findings{};
};

/// Compares a scan of one camera, which was checked, with its guard: see Scan::guard. Does nothing
/// without a guard or scanner, or if the frames alone give no coordinate. Throws Error as
/// setup_for and Engine do.
GuardResult compare_with_guard(const Scan& scan, const ReconstructSettings& settings = {});

/// The check of a scan, without its reconstruction.
struct ScanCheck {
  CheckedScan checked{};                 ///< findings of its frames, then of its guard; repairs
  std::optional<EpipolarCheck> guard{};  ///< nullopt if nothing was compared
};

/// Chooses the response, which the scan's scanner receives as it does the light and noise of the
/// settings; checks the scan, with or without a scanner, and puts slipped frames in order; then,
/// unless it is refused, compares it with its guard. Throws Error as compare_with_guard.
ScanCheck check(Scan& scan, const ScanJobSettings& settings = {});

/// A source of error of a scan's points.
struct ErrorSource {
  std::string name;             ///< such as "noise"
  std::optional<double> depth;  ///< RMS of its error of depth over the points, mm; nullopt: unknown
  std::string found;            ///< how it was found, or what would show it
};

/// The sources of a scan's errors of depth, which count as independent.
struct ErrorBudget {
  std::vector<ErrorSource> sources{};

  /// Root of the sum of squares of the known sources, mm. The true error is larger if a source is
  /// unknown.
  [[nodiscard]] double total() const;
};

/// The results of one scan, in the first camera's picture and frame. Those of several cameras that
/// are fused are the first camera's, or their match where that gives the fringe orders.
struct ScanResult {
  Cloud cloud{};            ///< with ScanOutput::maps only the validity of its pixels
  ValidityCounts counts{};  ///< pixels by validity; first the points
  /// If wanted, or needed for the rest: with two cameras, both axes,
  /// uncertainty or correction of contrast.
  Maps maps{};
  /// Pixels that contrast had pulled, with or without a point in the end; nullopt if not corrected.
  std::optional<std::ptrdiff_t> pulled_pixels{};
  std::optional<Uncertainty> uncertainty{};
  std::optional<ErrorBudget> budget{};      ///< with the uncertainty, of one camera
  std::optional<EpipolarCheck> epipolar{};  ///< with patterns along both axes
  std::optional<EpipolarCheck> guard{};     ///< with a guard

  /// The points of several cameras as one cloud, see fused_points(); null if they are not fused.
  std::shared_ptr<const FusedModel> fused{};
  std::vector<std::size_t> points_of_cameras{};  ///< that were fused

  EngineSetup setup{};
  GammaChoice gamma{};
  /// Findings of the check, then those of the reconstruction; repairs.
  CheckedScan checked{};

  std::string backend{};          ///< see Engine::backend_for; "coordinates" for a camera pair
  std::string fallback_reason{};  ///< see Engine::fallback_reason
  double least_modulation = 0;    ///< minimum modulation of a point, grey levels of 255
  /// Time taken, s; `computing` without the uncertainty.
  double choosing = 0, checking = 0, tables = 0, computing = 0;
};

/// The points of cameras that were fused, in one row, with their normals, in the first camera's
/// frame, mm. Throws Error if none were fused.
ModelPoints fused_points(const ScanResult& result);

/// Reconstructs scans one after another. Keeps the engine's tables from scan to scan as long as the
/// setup stays the same. For one thread at a time.
class ScanJob {
 public:
  explicit ScanJob(ScanJobSettings settings = {});

  [[nodiscard]] const ScanJobSettings& settings() const { return settings_; }

  /// Two cameras match their phases (with a calibrated projector) or their coordinates (a camera
  /// pair), or are fused, see ScanJobSettings::fuse; one camera meets the projector's light.
  /// Patterns along both axes check each other by the epipolar lines, and so does a guard, which
  /// rejects no point. `name`: of the scan in messages. Throws Error as checked_job, and
  /// RefusedScan if the scan is refused and ScanJobSettings::keep_refused is off.
  [[nodiscard]] ScanResult operator()(Scan scan, const std::string& name = "the scan");

  /// The same for a scan that was checked before, with these settings.
  [[nodiscard]] ScanResult operator()(const CheckedJob& job, const std::string& name = "the scan");

  /// Standard deviations of a result of this job, of one camera's `frames`, whose maps it computes.
  [[nodiscard]] Uncertainty uncertainty_of(const ScanResult& result, const FrameViews& frames);

  /// Takes a cloud that the caller no longer needs; the next result reuses its memory.
  void reuse(Cloud cloud) { clouds_.push_back(std::move(cloud)); }

 private:
  [[nodiscard]] ScanResult result_of(const CheckedJob& job, const std::string& name);
  void match_cameras(const CheckedJob& job, ScanResult& result);
  void fuse_cameras(const CheckedJob& job, const std::string& name, ScanResult& result);
  void compute(const CheckedJob& job, ScanResult& result);

  ScanJobSettings settings_;
  std::optional<Engine> engine_{};
  std::vector<Cloud> clouds_{};
  std::vector<ScanJob> further_{};  ///< of further cameras that are fused
};

/// One scan, once.
ScanResult reconstruct(Scan scan, const ScanJobSettings& settings = {});

/// Points of a map of projector coordinates, 0 to 1, made by any instrument: see
/// cloud_of_coordinates. `modulation`: grey levels of 255; empty: all pixels are lit. `checked`:
/// findings of a check of the map, to which those of the reconstruction are added.
ScanResult reconstruct_map(const Image<double>& coordinates, const EngineSetup& setup,
                           const Image<float>& modulation = {}, CheckedScan checked = {});

}  // namespace slipstream
