#pragma once

#include <cstdint>
#include <string>

#include "slipstream/frames/frame_set.h"
#include "slipstream/geometry/scan.h"

namespace slipstream {

/// 1 where two masks are. Throws Error where their sizes differ.
Image<std::uint8_t> in_both(const Image<std::uint8_t>& a, const Image<std::uint8_t>& b);

/// Scans of one unmoved scene, averaged as they come.
class ScanAverage {
 public:
  /// `name`: what a message calls the scan. Throws Error where it differs from the first in
  /// strategy, size or bits.
  void add(const Scan& scan, const std::string& name);

  [[nodiscard]] int count() const { return frames_.count(); }
  [[nodiscard]] const Sequence& sequence() const { return sequence_; }  ///< of the first scan
  [[nodiscard]] const MeanFrames& frames() const { return frames_; }
  /// 1 where no frame of any scan is at either end of the grey levels.
  [[nodiscard]] const Image<std::uint8_t>& unclipped() const { return unclipped_; }

 private:
  std::string first_name_;
  Sequence sequence_;
  MeanFrames frames_;
  Image<std::uint8_t> unclipped_;
};

}  // namespace slipstream
