#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "slipstream/cloud/cloud.h"

namespace slipstream::python {

/// A cloud in Python's hands; its arrays show it and nothing writes to it any more.
class HeldCloud {
 public:
  using Points = Image<std::array<float, 3>>;

  HeldCloud() = default;
  explicit HeldCloud(Cloud of) : cloud(std::move(of)) {}

  /// X, Y, Z of each pixel side by side: made when first asked for. From any thread.
  const Points& points();
  /// To be written anew.
  Cloud& fresh() {
    has_points_ = false;
    remarks.clear();
    return cloud;
  }

  Cloud cloud;
  std::vector<std::string> remarks;  ///< of what is wrong with it: for the header of its file

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
  /// One that came back, as its last holder left it, or else what `make()` gives, a unique_ptr.
  template <class Make>
  std::shared_ptr<Value> take(const Make& make) {
    std::unique_ptr<Value> value = free_->take();
    if (!value) value = make();
    return {value.release(),
            [free = free_](Value* back) { free->give_back(std::unique_ptr<Value>(back)); }};
  }

 private:
  class Free {
   public:
    std::unique_ptr<Value> take() {
      const std::lock_guard lock(mutex_);
      if (values_.empty()) return nullptr;
      std::unique_ptr<Value> value = std::move(values_.back());
      values_.pop_back();
      return value;
    }
    void give_back(std::unique_ptr<Value> value) {
      const std::lock_guard lock(mutex_);
      if (values_.size() < most) values_.push_back(std::move(value));
    }

   private:
    static constexpr std::size_t most = 16;

    std::mutex mutex_;
    std::vector<std::unique_ptr<Value>> values_;
  };

  std::shared_ptr<Free> free_ = std::make_shared<Free>();
};

}  // namespace slipstream::python
