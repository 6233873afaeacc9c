#pragma once

#include "spatial/methods.h"

namespace slipstream {

Orders orders_by_least_squares(const WrappedCycles& wrapped);

}  // namespace slipstream
