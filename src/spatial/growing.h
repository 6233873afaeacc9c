#pragma once

#include "spatial/methods.h"

namespace slipstream {

Orders orders_by_rows(const WrappedCycles& wrapped);
Orders orders_by_flood(const WrappedCycles& wrapped);
Orders orders_by_regions(const WrappedCycles& wrapped);
Orders orders_by_quality(const WrappedCycles& wrapped);
Orders orders_by_branch_cuts(const WrappedCycles& wrapped);

}  // namespace slipstream
