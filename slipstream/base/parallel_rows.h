#pragma once

#include <functional>

namespace slipstream {

/// Calls `body(row)` for every row in [0, height), in no order, on as many threads as oneTBB is
/// allowed (limit it with `tbb::global_control`). What `body` throws comes out here, once.
void for_each_row(int height, const std::function<void(int row)>& body);

/// On how many threads at most for_each_row would call now.
int parallel_threads();

}  // namespace slipstream
