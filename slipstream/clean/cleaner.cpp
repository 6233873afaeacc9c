#include "slipstream/clean/cleaner.h"

#include <utility>

namespace slipstream {

struct Cleaner::Memory {};

Cleaner::Cleaner(const CleanSettings& settings)
    : settings_(settings), memory_(std::make_unique<Memory>()) {
  require_valid(settings);
}
Cleaner::Cleaner(const Cleaner& other) : Cleaner(other.settings_) {}
Cleaner::Cleaner(Cleaner&&) noexcept = default;
Cleaner& Cleaner::operator=(Cleaner other) noexcept {
  std::swap(settings_, other.settings_);
  std::swap(memory_, other.memory_);
  return *this;
}
Cleaner::~Cleaner() = default;

ValidityCounts Cleaner::operator()(Cloud&) {
  return {};
}

ValidityCounts Cleaner::operator()(Cloud&, const Image<float>&, const DepthNoise&) {
  return {};
}

}  // namespace slipstream
