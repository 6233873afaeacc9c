#include "app/joined_recording.h"

#include <utility>

#include "base/throw_if-inl.h"
#include "io/file.h"

namespace slipstream::app {

JoinedRecording::JoinedRecording(std::string path, std::size_t inputs)
    : path_(std::move(path)), inputs_(inputs) {}

void JoinedRecording::begin(RecordingHeader header, const std::string& input) {
  const bool is_alike = header.format == header_.format && header.sequence == header_.sequence &&
                        header.scanner == header_.scanner && header.in_colour == header_.in_colour;
  throw_if(writer_ && !is_alike,
           "{}: camera, strategy or scanner differs from the inputs before it", input);

  throw_if(inputs_ != 1 && header.white.count() != 0,
           "{}: has a white picture, and a recording holds only one; convert it on its own", input);

  // At once: an input that cannot be read leaves an existing file as it was.
  if (!writer_) writer_.emplace(path_, header, FileWriting::at_once);
  header_ = std::move(header);

  // Number of this input's first frame: rounded up to a whole cycle of patterns.
  const auto cycle =
      static_cast<std::uint64_t>(header_.sequence ? cycle_length(*header_.sequence) : 1);
  first_ = (next_ + cycle - 1) / cycle * cycle;
}

void JoinedRecording::add(Frame& frame) {
  frame.stamp.sequence += first_;
  next_ = frame.stamp.sequence + 1;
  writer_->append(frame);
}

std::uint64_t JoinedRecording::finish() {
  throw_if(!writer_ || writer_->count() == 0, "no frames to write");
  writer_->finish();
  return writer_->count();
}

}  // namespace slipstream::app
