#include <optional>
#include <string>
#include <utility>

#include "io/image_file.h"
#include "python/bindings/arguments.h"
#include "python/bindings/bindings.h"
#include "slipstream/spatial_unwrapping.h"

namespace slipstream::python {
namespace {

py::object unwrapped_in_space(const ArrayOf<float>& phase,
                              const std::optional<ArrayOf<float>>& quality,
                              const std::string& method) {
  const Image<float> wrapped = image_from(phase);
  const Image<float> sure = quality ? image_from(*quality) : Image<float>();

  auto unwrapped = unlocked([&] { return unwrap_in_space(wrapped, sure, method); });
  return results("phase"_a = array_from(std::move(unwrapped.phase)),
                 "region"_a = array_from(std::move(unwrapped.region)));
}

}  // namespace

void bind_map_files(py::module_& module) {
  const auto write_array = [](const fs::path& path, const ArrayOf<float>& map) {
    write_map(path, image_from(map));
  };

  module.def("write_map", write_array, "path"_a, "map"_a, R"(
      Writes 32-bit floats, keeping NaN.

      Args:
          path (str | PathLike): .tiff or .npy.
          map (ArrayLike): rows x columns.

      Raises:
          Error: if the ending is not supported.
          WorldError: if the file cannot be written.

      Example:
          >>> slipstream.write_map("depth.tiff", cloud.z)
  )");

  const auto load_array = [](const fs::path& path) { return array_from(read_map(path)); };

  module.def("load_map", load_array, "path"_a, R"(
      Reads a file of `write_map`.

      Args:
          path (str | PathLike): file, by its ending.

      Returns:
          NDArray[float64]: rows x columns.

      Raises:
          Error: if the file is missing or malformed, or its ending not supported.
          WorldError: if it cannot be read.

      Example:
          >>> slipstream.write_map("depth.tiff", cloud.z)
          >>> slipstream.load_map("depth.tiff").shape
          (120, 160)
  )");
}

void bind_spatial_unwrapping(py::module_& module) {
  module.def("unwrap_in_space", &unwrapped_in_space, "phase"_a, "quality"_a = py::none(),
             "method"_a = "flow", R"(
      Unwraps a wrapped phase map by neighbouring pixels, without a code.

      Args:
          phase (ArrayLike): rad, rows x columns, NaN if invalid.
          quality (ArrayLike | None): higher where the phase is more reliable.
          method (str): as in `slipstream unwrap`.

      Returns:
          SimpleNamespace: the unwrapped phase.
              phase (NDArray[float32]): rad, rows x columns, NaN if invalid.
              region (NDArray): number of each pixel's connected region, 0 if invalid.

      Example:
          >>> slipstream.unwrap_in_space(maps.wrapped_phase, maps.modulation).phase.shape
          (120, 160)
  )");
}

}  // namespace slipstream::python
