#pragma once

#include <array>
#include <mutex>
#include <string>
#include <vector>

#include "python/bindings/bindings.h"
#include "slipstream/cloud.h"

namespace slipstream::python {

/// A cloud owned by Python; its arrays view it, and nothing writes to it any more.
class HeldCloud {
 public:
  using Points = Image<std::array<float, 3>>;

  /// X, Y, Z of each pixel side by side, made on first use. From any thread.
  const Points& points();

  /// Resets it for reuse.
  Cloud& fresh() {
    has_points_ = false;
    remarks.clear();
    return cloud;
  }

  Cloud cloud{};
  std::vector<std::string> remarks{};  ///< its diagnostics, for the header of its file

 private:
  std::mutex mutex_;
  bool has_points_ = false;
  Points points_;
};

}  // namespace slipstream::python
