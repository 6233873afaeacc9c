#pragma once

#include <string>

#include "slipstream/io/scan_folder.h"

namespace slipstream {

/// The pictures of `wanted` patterns, in pattern order: all of the folder's, or those chosen by its
/// `order`, which may leave out others, such as a white picture. Throws Error for an invalid order
/// and for another number of pictures, with the likely extra ones and an order without them.
/// `what`: name of the scan in messages.
std::vector<std::filesystem::path> pattern_pictures(const ScanFiles& files, int wanted,
                                                    const std::string& what);

}  // namespace slipstream
