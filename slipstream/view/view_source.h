#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "slipstream/check/finding.h"
#include "slipstream/cloud/cloud.h"
#include "slipstream/codes/response.h"
#include "slipstream/codes/strategy.h"
#include "slipstream/frames/frame_set.h"
#include "slipstream/frames/frame_source.h"
#include "slipstream/live/live_statistics.h"
#include "slipstream/reconstruct/reconstruct_settings.h"

namespace slipstream {
class LivePipeline;
}

namespace slipstream::view {

/// A cloud to be shown, and the frames that it was made of where there are any. A copy shares both:
/// neither changes, and both stay in memory, as long as there is one.
struct ShownCloud {
  std::shared_ptr<const Cloud> cloud{};              ///< keeps the memory of the frames too
  std::shared_ptr<const Uncertainty> uncertainty{};  ///< where it came with the cloud
  FrameViews frames{};  ///< in pattern order; none of a cloud from a file
  std::chrono::steady_clock::time_point
      captured{};  ///< when the newest frame was; 0 without frames

  /// False before there is a first cloud.
  explicit operator bool() const { return cloud != nullptr; }
  /// Whether it is the very same cloud, not one like it.
  [[nodiscard]] bool is(const ShownCloud& other) const { return cloud == other.cloud; }
};

/// What the viewer shows and what can be asked for in it. Only `newest` must be set. Each other
/// function belongs to one part of the viewer (a button, a key, a section of the panel), which is
/// left out where the function is empty. The viewer calls all of them from its own thread, but
/// `save` from another.
struct ViewSource {
  std::string title{};                                   ///< of the window
  std::function<ShownCloud()> newest{};                  ///< asked before each picture
  std::string waits_for = "waiting for the first scan";  ///< said until there is a cloud
  std::function<void(const ShownCloud&)> shown{};  ///< told that the cloud is on the screen now
  std::function<LiveStatistics()> statistics{};    ///< of the pipeline that makes the clouds

  /// The setup that clouds are made with at first; where its scanner has no geometry the clouds are
  /// empty and the frames are looked at. None for clouds that come without frames: no
  /// pictures stand beside them then, and nothing can be changed or saved.
  std::optional<EngineSetup> setup{};
  /// What is amiss with the frames, where they do not come through a pipeline, whose statistics say
  /// that.
  std::vector<Finding> findings{};
  /// Makes clouds with another setup from now on. May throw: the viewer then shows the reason and
  /// keeps the old setup.
  std::function<void(const EngineSetup&)> change{};
  /// The setup that clouds are made with now, where it or the camera was changed since this was
  /// asked last; by others too.
  std::function<std::optional<EngineSetup>()> changed{};
  std::vector<std::pair<std::string, Strategy>> strategies{};  ///< to choose from, by label
  /// Responses to choose from, by label: phases are corrected for the one chosen, and are not
  /// corrected where it is none.
  std::vector<std::pair<std::string, std::optional<MeasuredResponse>>> gammas{};

  CameraControls* camera = nullptr;  ///< what can be set of it; null where nothing
  std::string camera_region{};       ///< the part of its sensor, for people

  /// What to show in place of this: a file or a folder that the user names. Throws for what cannot
  /// be opened.
  std::function<ViewSource(const std::string& path)> open{};
  std::function<std::vector<std::string>()> openable{};  ///< paths to choose from

  /// Writes the cloud's frames and all that is made of them; returns the folder, for people.
  std::function<std::string(const ShownCloud&, const EngineSetup&)> save{};
  std::function<void(bool on)> record{};  ///< begins or ends a recording
  /// How the recording goes, in a few words; empty where none is made.
  std::function<std::string()> recording{};
};

/// A cloud that stands still, and how sure its points are where that is known.
ViewSource still_source(Cloud cloud, std::optional<Uncertainty> uncertainty = std::nullopt);

/// Frames that are reconstructed anew whenever another setup is asked for; `save` is left to
/// whoever knows of files. Throws Error as Engine does.
ViewSource still_source(FrameSet frames, const EngineSetup& setup);

/// The clouds of a pipeline that runs, made by `setup` at first; it must live longer than what is
/// returned. Other responses can be chosen and, where the patterns can change, other strategies;
/// files are left to whoever knows of them.
ViewSource live_source(LivePipeline& pipeline, const EngineSetup& setup, bool patterns_can_change);

}  // namespace slipstream::view
