#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "slipstream/capture/pool.h"
#include "slipstream/live/live_cloud.h"
#include "slipstream/live/live_pipeline.h"
#include "slipstream/live/live_statistics.h"
#include "slipstream/phase/phase_correction.h"
#include "slipstream/strategy/strategy.h"

namespace slipstream::view {

/// What the viewer shows and what it can ask for: a live pipeline, or a cloud that stands still.
/// What is empty, and must not be, is said; where another function is empty, the viewer does not
/// offer what it is for. All but `save` are called by the viewer's thread.
struct ViewSource {
  std::string title;                          ///< of the window
  std::function<Pooled<LiveCloud>()> newest;  ///< never empty; its share is, before the first cloud
  std::function<void(const LiveCloud&)> shown;
  std::function<LiveStatistics()> statistics;

  LiveScan scan;            ///< what is looked for in the frames at first
  double full_scale = 255;  ///< the largest grey level of the frames
  /// Looks for something else from now on. May throw: the viewer shows why and keeps the old.
  std::function<void(const LiveScan&)> change;
  std::vector<std::pair<std::string, Strategy>> strategies;      ///< to choose from, by label
  std::vector<std::pair<std::string, PhaseCorrections>> gammas;  ///< likewise

  /// Writes the cloud and all its maps; returns where. Called in a thread of its own.
  std::function<std::string(const LiveCloud&, const LiveScan&)> save;
  std::function<void(bool on)> record;     ///< begins or ends a recording
  std::function<std::string()> recording;  ///< how it goes, in a few words; empty where it does not
};

}  // namespace slipstream::view
