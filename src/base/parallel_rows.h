#pragma once

#include <functional>

#include "slipstream/image.h"

namespace slipstream {

/// Calls `body(row)` for every row in [0, height), in any order, on as many threads as oneTBB
/// allows (limit it with `tbb::global_control`), or without oneTBB as the machine has. Rethrows the
/// first exception that `body` throws.
void for_each_row(int height, const std::function<void(int row)>& body);

/// Calls `body(column, row)` for every pixel, rows in parallel as in for_each_row.
template <class Body>
void for_each_pixel(Size size, const Body& body) {
  for_each_row(size.height, [&](int row) {
    for (int column = 0; column < size.width; ++column) body(column, row);
  });
}

/// The most threads for_each_row would use now.
int parallel_threads();

}  // namespace slipstream
