#pragma once

#include <atomic>
#include <memory>
#include <utility>
#include <vector>

namespace slipstream {

/// A share of a value in a Pool; the value returns to the pool with its last share. Shares may be
/// copied and dropped in any thread, and keep the pool's memory alive.
template <class Value>
class Pooled {
 public:
  Pooled() = default;

  Pooled(const Pooled& other) : slots_(other.slots_), slot_(other.slot_) {
    if (slot_) slot_->shares.fetch_add(1, std::memory_order_relaxed);
  }

  Pooled(Pooled&& other) noexcept
      : slots_(std::move(other.slots_)), slot_(std::exchange(other.slot_, nullptr)) {}

  Pooled& operator=(Pooled other) noexcept {
    std::swap(slots_, other.slots_);
    std::swap(slot_, other.slot_);
    return *this;
  }

  ~Pooled() {
    if (slot_) slot_->shares.fetch_sub(1, std::memory_order_release);
  }

  explicit operator bool() const { return slot_ != nullptr; }
  const Value& operator*() const { return slot_->value; }
  const Value* operator->() const { return &slot_->value; }
  /// Writable access; only for the thread that took it, before the share is first copied.
  [[nodiscard]] Value& fill() { return slot_->value; }

 private:
  template <class>
  friend class Pool;

  struct Slot {
    std::atomic<int> shares = 0;
    Value value;
  };
  using Slots = std::vector<Slot>;

  Pooled(std::shared_ptr<Slots> slots, Slot& slot) : slots_(std::move(slots)), slot_(&slot) {}

  std::shared_ptr<Slots> slots_;
  Slot* slot_ = nullptr;
};

/// Values that are allocated once and reused.
template <class Value>
class Pool {
 public:
  /// `count` values, each made by `make()`.
  template <class Make>
  Pool(std::size_t count, Make make)
      : slots_(std::make_shared<typename Pooled<Value>::Slots>(count)) {
    for (auto& slot : *slots_) slot.value = make();
  }

  /// An unused value, as its last owner left it; empty share if all are in use. Call it from one
  /// thread.
  [[nodiscard]] Pooled<Value> take() {
    for (std::size_t tried = 0; tried < slots_->size(); ++tried) {
      // Round robin; acquire makes the last owner's writes visible.
      next_ = (next_ + 1) % slots_->size();
      auto& slot = (*slots_)[next_];
      int unused = 0;
      if (slot.shares.compare_exchange_strong(unused, 1, std::memory_order_acquire)) {
        return {slots_, slot};
      }
    }

    return {};
  }

 private:
  std::shared_ptr<typename Pooled<Value>::Slots> slots_;
  std::size_t next_ = 0;
};

}  // namespace slipstream
