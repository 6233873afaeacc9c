#pragma once

#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

namespace slipstream {

/// Passes values in order between threads; at most `capacity` wait. Allocates memory only once.
template <class Value>
class BoundedQueue {
 public:
  explicit BoundedQueue(std::size_t capacity) : places_(capacity) {}

  /// Waits for room; only for the one thread that pushes. False once the queue is closed.
  bool wait_for_room() {
    std::unique_lock lock(mutex_);
    room_.wait(lock, [&] { return closed_ || waiting_ < places_.size(); });
    return !closed_;
  }

  /// The same, then adds the value unless the queue is closed.
  void push_when_room(Value value) {
    if (wait_for_room()) push_over_oldest(std::move(value));
  }

  /// Never waits: if the queue is full, removes the oldest value and returns it. Does nothing if
  /// the queue is closed.
  std::optional<Value> push_over_oldest(Value value) {
    std::unique_lock lock(mutex_);
    if (closed_) return std::nullopt;

    std::optional<Value> overwritten;
    if (waiting_ == places_.size()) overwritten = take_oldest();

    places_[(first_ + waiting_) % places_.size()] = std::move(value);
    ++waiting_;
    lock.unlock();
    filled_.notify_one();

    return overwritten;
  }

  /// Removes the oldest value, if there is one, and returns it.
  std::optional<Value> drop_oldest() {
    const std::lock_guard lock(mutex_);
    if (waiting_ == 0) return std::nullopt;
    return take_oldest();
  }

  /// Waits for the oldest value; nullopt once the queue is closed and empty.
  std::optional<Value> pop() {
    std::unique_lock lock(mutex_);
    filled_.wait(lock, [&] { return closed_ || waiting_ > 0; });
    if (waiting_ == 0) return std::nullopt;

    Value value = take_oldest();
    lock.unlock();
    room_.notify_one();
    return value;
  }

  /// Accepts no more values; waiting ones can still be taken.
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
