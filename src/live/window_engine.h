#pragma once

#include <bitset>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "check/fit.h"
#include "reconstruct/phase_matcher.h"
#include "slipstream/check.h"
#include "slipstream/engine.h"
#include "slipstream/live_pipeline.h"
#include "slipstream/scan_job.h"

namespace slipstream {

/// Checks that the frames of a live scan still fit their patterns, the scanner and each other. The
/// first frames get the full check. Of later ones only a few pixels are sampled, which is cheap
/// enough for every cycle; if they look suspicious, the full check runs. For one thread.
class LiveCheck {
 public:
  /// Without a scanner fewer checks are possible: see check_frames.
  LiveCheck(const Sequence& sequence, const std::optional<Scanner>& scanner, Size camera,
            const CheckSettings& settings = {});

  /// Diagnostics of frames in pattern order, of the camera's size. Allocates only if there are any.
  std::vector<Finding> look(const FrameViews& window);

 private:
  using Clock = std::chrono::steady_clock;

  /// Which samples look wrong: residual, bands, seam, brightness.
  using Suspicion = std::bitset<4>;

  Suspicion suspicion(const FrameViews& window);

  Sequence sequence_;
  std::optional<Scanner> scanner_;
  CheckSettings settings_;
  FrameModel model_;
  FrameOrder order_;
  FrameJudge judge_;
  ScanSamples samples_;
  Fit fit_;
  Suspicion harmless_;              ///< raised, but cleared by the full check
  double harmless_residual_ = 0;    ///< residual of the cleared frames, with a margin
  std::vector<double> right_sums_;  ///< of each frame at the last good check
  std::vector<Finding> findings_;   ///< of the last full check
  Suspicion suspected_;             ///< suspicion that led to it
  Clock::time_point checked_{};     ///< time of the last full check; the epoch before the first
};

/// Builds, checks and reconstructs windows; reuses its memory.
struct WindowEngine {
  WindowEngine(const EngineSetup& setup, const LiveSettings& settings);

  /// Sets the window's cloud (empty without a scanner) and `motion`; returns the points that
  /// cleaning removed.
  ValidityCounts reconstruct(LiveCloud& window);
  /// The same without colours.
  ValidityCounts reconstruct_points(LiveCloud& window);
  /// Whether to check the window: once per cycle, when its last pattern has arrived.
  [[nodiscard]] bool is_due(const LiveCloud& window) const;
  std::vector<Finding> look(const LiveCloud& window);
  /// The same as reconstruct, with a second camera.
  ValidityCounts match_cameras(LiveCloud& window);
  ValidityCounts fuse_cameras(LiveCloud& window);
  [[nodiscard]] const EngineSetup& setup() const { return whole; }

  EngineSetup whole;
  std::shared_ptr<const Sequence> sequence;  ///< the setup's, for the clouds
  /// One for each first pattern of a window; a single one if windows are in pattern order.
  std::vector<Engine> engines;
  std::optional<Engine> still;  ///< for one cycle, if that is enough while nothing moves
  Engine* used = nullptr;       ///< the engine of the newest cloud
  FrameViews views, second_views;
  std::optional<PhaseMatcher> match;  ///< with a second camera
  PhaseMatcher::Result matched;       ///< its newest result, without the cloud
  std::optional<ScanJob> fuse;        ///< with a second camera, instead of `match`
  std::optional<Scanner> second;      ///< with `fuse`: this camera
  std::vector<Finding> of_pair;       ///< with `fuse`: findings of the newest window
  std::function<std::vector<Finding>(const FrameViews&)> check;
  Image<Colour> colour;                 ///< of the points; empty if unknown
  std::optional<std::uint64_t> looked;  ///< sequence number of the newest frame checked
  std::shared_ptr<Pool<Frame>> frames;  ///< pool of the windows' frames
};

}  // namespace slipstream
