#include "slipstream/io/height_file.h"

#include <algorithm>
#include <array>
#include <bit>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/io/file.h"
#include "slipstream/io/image_file.h"

namespace slipstream {
namespace {

constexpr int members = sizeof(HeightCurve) / sizeof(float);
using Members = std::array<float, members>;

}  // namespace

void write_height_curves(const std::filesystem::path& path, const Image<HeightCurve>& curves) {
  require_ending(path, "calibration of heights", {".npy"});
  Image<float> numbers({members * curves.width(), curves.height()});
  float* to = numbers.begin();
  for (const HeightCurve& curve : curves)
    to = std::ranges::copy(std::bit_cast<Members>(curve), to).out;
  write_map(path, numbers);
}

Image<HeightCurve> read_height_curves(const std::filesystem::path& path) {
  require_ending(path, "calibration of heights", {".npy"});
  const Image<double> numbers = read_map(path);
  try {
    if (numbers.width() % members != 0) throw Error("five numbers for each pixel are wanted");
    Image<HeightCurve> curves({numbers.width() / members, numbers.height()});
    const double* from = numbers.begin();
    for (HeightCurve& curve : curves) {
      Members row{};
      for (float& member : row) member = static_cast<float>(*from++);
      curve = std::bit_cast<HeightCurve>(row);
    }
    require_valid(curves);
    return curves;
  } catch (const Error& error) {
    throw Error(fmt::format("{}: {}", path.string(), error.what()));
  }
}

}  // namespace slipstream
