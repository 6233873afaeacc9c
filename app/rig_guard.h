#pragma once

#include <cstdint>
#include <future>
#include <mutex>
#include <string>
#include <vector>

#include "app/output.h"
#include "frames/stepped_source.h"
#include "slipstream/named_source.h"
#include "slipstream/scan_job.h"

namespace slipstream::app {

/// Compares a checked scan with its guard and prints how well they meet. A guard that cannot be
/// compared is a warning: the scan may be read with other settings.
GuardResult compared_with_guard(const Scan& scan, const ReconstructSettings& settings,
                                Output& output);

/// The patterns of the guard that `live` takes beside these; empty if they can have none.
std::vector<Image<std::uint8_t>> guard_pictures(const EngineSetup& setup,
                                                const NamedSource& opened);

/// Compares the rig with its calibration while a session runs, by the guards of its source.
class RigWatch {
 public:
  /// `source`: it takes guards; it and `output` must outlive this.
  RigWatch(SteppedSource& source, Output& output) : source_(source), output_(output) {}

  // Main thread:
  /// Prints the result of a comparison, and begins one if a guard has come.
  void look(const EngineSetup& setup);
  /// Waits for the comparison; says so if no guard has been taken.
  void finish(const EngineSetup& setup);

  // Any thread:
  void want(bool wanted) { source_.want_guard(wanted); }
  [[nodiscard]] bool wants() const { return source_.wants_guard(); }
  /// What the newest guard shows, in a line; empty before the first.
  [[nodiscard]] std::string state() const;

 private:
  void tell(const GuardResult& result);
  void set_state(std::string state);

  SteppedSource& source_;
  Output& output_;
  std::future<GuardResult> comparing_;
  mutable std::mutex mutex_;  ///< guards the state
  std::string state_;
};

}  // namespace slipstream::app
