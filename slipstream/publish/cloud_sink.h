#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "slipstream/cloud/uncertainty.h"
#include "slipstream/codes/sequence.h"
#include "slipstream/frames/pool.h"
#include "slipstream/geometry/lens.h"
#include "slipstream/live/live_cloud.h"
#include "slipstream/publish/run_setting.h"

namespace slipstream {

/// The run whose clouds are published. The functions are called from any thread; they may throw.
struct PublishedRun {
  Lens camera{};           ///< whose pixels the clouds have
  std::string scanner{};   ///< the text of its scanner file; empty where none is known
  bool has_points = true;  ///< whether a scanner is known; else there are pictures alone
  std::function<std::string()> statistics{};  ///< what the run has counted until now, as JSON
  std::function<std::string()> trouble{};     ///< one line; empty where all is well
  /// Writes the newest cloud; returns where. Throws Error within a second of the last time.
  std::function<std::string()> save{};
  /// The phase that the cloud's frames show: of each pixel 1 to 255 over a period, 0 where it is
  /// too dark. Empty where they are not of what is looked for now. One thread at a time.
  std::function<Image<std::uint8_t>(const LiveCloud&)> phase{};
  /// What the frames show now.
  std::function<Sequence()> sequence{};
  /// How sure a cloud's points are; nothing where its frames are not of what is looked for now. One
  /// thread at a time. Null where the noise is not known.
  std::function<std::optional<Uncertainty>(const LiveCloud&)> uncertainty{};
  /// What can be changed now, in an order that stays; a camera that is gone has no settings. All
  /// sinks and the viewer see what any of them has changed.
  std::function<std::vector<RunSetting>()> settings{};
  /// Sets the one of that name to a value that it can have: throws Error as require_settable.
  std::function<void(const std::string& name, const std::string& value)> change{};
};

/// Where clouds go: a file, other programs, a browser. A Publisher gives each its thread.
class CloudSink {
 public:
  virtual ~CloudSink() = default;

  /// Whether the sink is to be given this cloud, of those that come. In the thread that makes them.
  [[nodiscard]] virtual bool wants(const LiveCloud&) { return true; }
  /// Takes the next cloud; what is kept of it keeps its memory from the pipeline, one at most. What
  /// is thrown ends the sink and nothing else. `alone`: clouds were dropped and others wait, so
  /// nothing is added to it that takes time, as its uncertainty and frames do.
  virtual void put(const Pooled<LiveCloud>& cloud, bool alone) = 0;
  /// No more clouds come. Throws likewise.
  virtual void finish() {}
  /// Lines for people that were not told before. From any thread.
  virtual std::vector<std::string> news() { return {}; }
};

}  // namespace slipstream
