#include "io/depth_truth.h"

#include <cmath>

#include "base/statistics.h"
#include "base/throw_if-inl.h"
#include "io/image_file.h"

namespace slipstream {
namespace fs = std::filesystem;

std::optional<double> error_against_truth(const fs::path& folder, const Cloud& cloud) {
  const fs::path file = folder / "truth" / "depth.tiff";
  if (!fs::exists(file)) return std::nullopt;

  const Image<double> truth = read_map(file);
  throw_if(truth.size() != cloud.size(), "{} is {}, the frames are {}; both must have one size",
           file.string(), text_of(truth.size()), text_of(cloud.size()));

  Squares errors;
  for_each_pixel_in_order(truth.size(), [&](int column, int row) {
    constexpr double far = 0.01;  // of the depth
    const double z = cloud.z(column, row), at_centre = z - truth(column, row);

    // At an edge the lens mixes both sides: use the nearest surface around the pixel.
    const double error =
        std::abs(at_centre) > far * z ? nearest_error(z, truth, column, row) : at_centre;

    if (std::isfinite(error)) errors.add(error * error);
  });

  return errors.count > 0 ? std::optional(errors.rms()) : std::nullopt;
}

}  // namespace slipstream
