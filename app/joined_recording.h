#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "slipstream/recording.h"

namespace slipstream::app {

/// Joins frames of several inputs into one recording; each input starts with a new cycle.
class JoinedRecording {
 public:
  JoinedRecording(std::string path, std::size_t inputs);

  /// Begins the next input. Throws Error if it cannot stand in one recording with those before.
  void begin(RecordingHeader header, const std::string& input);

  /// Appends a frame of this input, whose number it changes.
  void add(Frame& frame);

  /// Completes the file; returns the number of frames. Throws Error if there is none.
  std::uint64_t finish();

 private:
  std::string path_;
  std::size_t inputs_;
  RecordingHeader header_;
  std::optional<RecordingWriter> writer_;
  std::uint64_t first_ = 0, next_ = 0;  ///< frame number in the recording
};

}  // namespace slipstream::app
