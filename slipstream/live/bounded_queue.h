#pragma once

#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

namespace slipstream {

/// Passes values from one thread to another, in order, `capacity` of them waiting at most. Its
/// memory is allocated once.
template <class Value>
class BoundedQueue {
 public:
  explicit BoundedQueue(std::size_t capacity) : places_(capacity) {}

  /// Waits for room and takes nothing: for the only thread that pushes. False where the queue is
  /// closed.
  bool wait_for_room() {
    std::unique_lock lock(mutex_);
    room_.wait(lock, [&] { return closed_ || waiting_ < places_.size(); });
    return !closed_;
  }

  /// Waits for room. False where the queue is closed: the value is not taken.
  bool push_when_room(Value value) {
    std::unique_lock lock(mutex_);
    room_.wait(lock, [&] { return closed_ || waiting_ < places_.size(); });
    return push(std::move(value), lock);
  }

  /// Waits for nothing: where there is no room the oldest value is thrown away and given back.
  std::optional<Value> push_over_oldest(Value value) {
    std::unique_lock lock(mutex_);
    std::optional<Value> overwritten;
    if (waiting_ == places_.size()) overwritten = take_oldest();
    push(std::move(value), lock);
    return overwritten;
  }

  /// Throws the oldest value away where there is one.
  std::optional<Value> drop_oldest() {
    const std::lock_guard lock(mutex_);
    if (waiting_ == 0) return std::nullopt;
    return take_oldest();
  }

  /// The oldest value, as soon as there is one; none once the queue is closed and empty.
  std::optional<Value> pop() {
    std::unique_lock lock(mutex_);
    filled_.wait(lock, [&] { return closed_ || waiting_ > 0; });
    if (waiting_ == 0) return std::nullopt;
    Value value = take_oldest();
    lock.unlock();
    room_.notify_one();
    return value;
  }

  /// Nothing goes in any more; what waits can still be taken.
  void close() {
    {
      const std::lock_guard lock(mutex_);
      closed_ = true;
    }
    room_.notify_all();
    filled_.notify_all();
  }

  [[nodiscard]] std::size_t waiting() const {
    const std::lock_guard lock(mutex_);
    return waiting_;
  }
  [[nodiscard]] std::size_t capacity() const { return places_.size(); }

 private:
  bool push(Value value, std::unique_lock<std::mutex>& lock) {
    if (closed_) return false;
    places_[(first_ + waiting_) % places_.size()] = std::move(value);
    ++waiting_;
    lock.unlock();
    filled_.notify_one();
    return true;
  }

  Value take_oldest() {
    Value value = std::exchange(places_[first_], Value());
    first_ = (first_ + 1) % places_.size();
    --waiting_;
    return value;
  }

  mutable std::mutex mutex_;
  std::condition_variable filled_, room_;
  std::vector<Value> places_;
  std::size_t first_ = 0, waiting_ = 0;
  bool closed_ = false;
};

}  // namespace slipstream
