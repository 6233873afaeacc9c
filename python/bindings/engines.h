#pragma once

#include <mutex>

#include "python/bindings/bindings.h"
#include "slipstream/reconstruct/engine.h"

namespace slipstream::python {

/// A cloud in Python's hands; its arrays show it and nothing writes to it any more.
class HeldCloud {
 public:
  using Points = Image<std::array<float, 3>>;

  /// X, Y, Z of each pixel side by side: made when first asked for. From any thread.
  const Points& points();
  /// To be written anew.
  Cloud& fresh() {
    has_points_ = false;
    remarks.clear();
    return cloud;
  }

  Cloud cloud{};
  std::vector<std::string> remarks{};  ///< of what is wrong with it: for the header of its file

 private:
  std::mutex mutex_;
  bool has_points_ = false;
  Points points_;
};

/// Values that come back with the last share in them and are given out again, in any thread: memory
/// that is fresh from the system costs about as much as a cloud.
template <class Value>
class Reused {
 public:
  /// One that came back, as its last holder left it, or else a new one made of those arguments.
  template <class... Arguments>
  std::shared_ptr<Value> take(const Arguments&... arguments) {
    std::unique_ptr<Value> value;
    {
      const std::lock_guard lock(free_->mutex);
      if (!free_->values.empty()) {
        value = std::move(free_->values.back());
        free_->values.pop_back();
      }
    }
    if (!value) value = std::make_unique<Value>(arguments...);
    return {value.release(), [free = free_](Value* of) {
              std::unique_ptr<Value> back(of);
              const std::lock_guard lock(free->mutex);
              if (free->values.size() < 16) free->values.push_back(std::move(back));
            }};
  }

 private:
  struct Free {
    std::mutex mutex;
    std::vector<std::unique_ptr<Value>> values;
  };
  std::shared_ptr<Free> free_ = std::make_shared<Free>();
};

}  // namespace slipstream::python
