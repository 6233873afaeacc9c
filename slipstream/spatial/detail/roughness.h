#pragma once

#include "slipstream/spatial/detail/methods.h"

namespace slipstream {

/// How little the phase of each pixel is to be trusted: how far it is from the mean of two
/// neighbours, the square in periods, in the mean over row, column and diagonals, as far as they
/// are there; over the square of the quality, where that is known.
Image<float> roughness(const WrappedCycles& wrapped);

/// The weight of each pixel, 0 to 1: less the rougher it is than most.
Image<float> smoothness(const WrappedCycles& wrapped);

}  // namespace slipstream
