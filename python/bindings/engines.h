#pragma once

#include <memory>
#include <optional>

#include "python/bindings/arrays.h"
#include "python/bindings/held.h"
#include "slipstream/reconstruct/engine.h"

namespace slipstream::python {

/// An engine that any number of threads may use at a time: each call takes one of its copies.
class SharedEngine {
 public:
  explicit SharedEngine(const EngineSetup& setup) : first_(setup) {}

  [[nodiscard]] const EngineSetup& setup() const { return first_.setup(); }
  std::shared_ptr<HeldCloud> cloud(const FrameViews& frames);
  std::shared_ptr<Maps> maps(const FrameViews& frames);
  std::pair<std::shared_ptr<HeldCloud>, std::shared_ptr<Maps>> cloud_and_maps(
      const FrameViews& frames);
  std::shared_ptr<Uncertainty> uncertainty(const HeldCloud& cloud, const Maps& maps,
                                           const FrameViews& frames);
  std::string backend_for(const FrameViews& frames) { return engine()->backend_for(frames); }

 private:
  std::shared_ptr<Engine> engine() {
    return engines_.take([this] { return std::make_unique<Engine>(first_); });
  }
  std::shared_ptr<HeldCloud> free_cloud() {
    return clouds_.take([] { return std::make_unique<HeldCloud>(); });
  }
  std::shared_ptr<Maps> free_maps() {
    return maps_.take([] { return std::make_unique<Maps>(); });
  }

  const Engine first_;  // is copied and does nothing else
  Reused<Engine> engines_;
  Reused<HeldCloud> clouds_;
  Reused<Maps> maps_;
};

}  // namespace slipstream::python
