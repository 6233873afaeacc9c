#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "slipstream/frame_set.h"
#include "slipstream/scanner.h"
#include "slipstream/sequence.h"

namespace slipstream {

/// A camera beside the scanner that took only a picture of the scene's colours.
struct ColourCamera {
  Image<Colour> picture{};  ///< sRGB
  Lens lens{};
  /// From the frame of the scan's camera to its own, mm.
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
};

/// Frames with their sequence and scanner: from a folder, a recording or the virtual scanner.
struct Scan {
  FrameSet frames{};
  /// Original indices if the frames were reordered: frame n was frame order[n]; otherwise empty.
  std::vector<int> order{};

  Sequence sequence{};
  std::optional<Scanner> scanner{};  ///< if known
  /// Two cameras without a calibrated projector: the first, and the second as projector.
  std::optional<Scanner> camera_pair{};
  std::vector<double> exposures{1};  ///< merged into these frames; a single one if not merged

  /// With patterns along both axes: the scan along y.
  std::vector<Scan> other_axis{};
  /// A few frames along the other axis, at most one scan, which show whether camera and projector
  /// still stand as in the scanner's calibration. Makes no point.
  std::vector<Scan> guard{};
  /// Scans of further cameras, taken at the same time with the same projector, each with its own
  /// scanner. World coordinates are in the frame of this scan's camera.
  std::vector<Scan> further_cameras{};
  /// Colours of the first camera's pixels, sRGB; empty if unknown.
  Image<Colour> colour{};
  /// If another camera took the colours, see colours_seen_by; `colour` is then empty.
  std::optional<ColourCamera> colour_camera{};

  std::vector<std::string> warnings{};  ///< about reading the frames, for the user
};

/// The scans of one pose of a calibration board, each read on demand.
struct BoardScans {
  std::string name;  ///< of the pose
  std::function<Scan(Axis)> along;
};

/// Prepares a scan for decoding: merges exposures, separates multiplexed frames (see FrameAdapter),
/// and moves frames along the other axis to other_axis. Throws Error if the number of frames does
/// not match.
Scan merged(Scan scan);

}  // namespace slipstream
