#pragma once

#include <atomic>
#include <optional>

#include "python/bindings/arrays.h"
#include "slipstream/capture/frame_source.h"

namespace slipstream::python {

/// A camera of Python's: anything that gives arrays rows x columns one after another, all of one
/// size and type. They are counted as they come; each is copied once.
class PythonSource : public FrameSource {
 public:
  /// Takes the first frame, which says what the others are.
  PythonSource(const py::iterable& frames, std::optional<int> bits);
  ~PythonSource() override;

  [[nodiscard]] FrameFormat format() const override { return first_.format(); }
  [[nodiscard]] bool has_own_pace() const override { return false; }
  void start() override {}
  Arrival next(Frame& frame, std::chrono::milliseconds timeout) override;
  void stop() override {}
  [[nodiscard]] SourceCounters counters() const override { return {.delivered = given_}; }
  [[nodiscard]] std::string state() const override { return {}; }

 private:
  py::object frames_;  // an iterator; touched with the interpreter's lock alone
  std::optional<int> bits_;
  Frame first_;
  std::atomic<std::uint64_t> given_ = 0;
};

/// A copy of one array. Throws Error for float64.
void copy_frame(const py::object& array, std::optional<int> bits, Frame& frame);

}  // namespace slipstream::python
