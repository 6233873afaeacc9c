#pragma once

#include <vector>

#include "geometry/map_form.h"
#include "slipstream/check.h"
#include "slipstream/finding.h"
#include "slipstream/image.h"
#include "slipstream/scanner.h"

namespace slipstream {

/// Makes pixels NaN that share a value exactly with many others, as invalid ones that were written
/// as 0, -1 or 65535. Warns of each such value.
std::vector<Finding> leave_out_shared_values(Image<double>& map);

/// Checks that the coordinates of a map fit the scanner as those of a scan do, and that they end
/// where the projector's light ends. If not, names the mistakes that explain it: another unit,
/// origin, number of periods or direction, another axis, turned pictures, or another scanner file.
/// `coordinates`: as coordinates_of_map reads them by `form`. The scanner must be valid.
CheckedScan check_map(const Image<double>& coordinates, const MapForm& form, const Scanner& scanner,
                      Axis axis);

}  // namespace slipstream
