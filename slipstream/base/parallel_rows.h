#pragma once

#include <functional>

#include "slipstream/base/size.h"

namespace slipstream {

/// Calls `body(row)` for every row in [0, height), in no order, on as many threads as oneTBB is
/// allowed (limit it with `tbb::global_control`). What `body` throws comes out here, once.
void for_each_row(int height, const std::function<void(int row)>& body);

/// Calls `body(column, row)` for every pixel of a picture, its rows as by for_each_row.
template <class Body>
void for_each_pixel(Size size, const Body& body) {
  for_each_row(size.height, [&](int row) {
    for (int column = 0; column < size.width; ++column) body(column, row);
  });
}

/// On how many threads at most for_each_row would call now.
int parallel_threads();

/// The calling thread gets what time the others of the program leave. Called once. Nothing is
/// changed outside Linux, where this would be of the whole program.
void let_others_go_first();

/// The calling thread works for a moment at a time and is to begin at once when it wakes up: it
/// goes before all that computes where the system allows it (`ulimit -r`), else, from Linux 6.12
/// on, before what has had its share.
void go_when_woken();

}  // namespace slipstream
