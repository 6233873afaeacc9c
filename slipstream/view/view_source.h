#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "slipstream/check/finding.h"
#include "slipstream/codes/response.h"
#include "slipstream/codes/strategy.h"
#include "slipstream/frames/camera_controls.h"
#include "slipstream/live/live_statistics.h"
#include "slipstream/reconstruct/reconstruct_settings.h"
#include "slipstream/view/shown_cloud.h"

namespace slipstream::view {

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

}  // namespace slipstream::view
