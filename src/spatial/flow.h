#pragma once

#include "spatial/methods.h"

namespace slipstream {

Orders orders_by_flow(const WrappedCycles& wrapped);

}  // namespace slipstream
