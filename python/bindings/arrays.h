#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "slipstream/capture/frame_views.h"
#include "slipstream/image/image.h"

namespace pybind11::detail {

/// (width, height)
template <>
struct type_caster<slipstream::Size> {
  PYBIND11_TYPE_CASTER(slipstream::Size, const_name("tuple[int, int]"));

  bool load(handle source, bool convert) {
    make_caster<std::pair<int, int>> pair;
    if (!pair.load(source, convert)) return false;
    const auto [width, height] = cast_op<std::pair<int, int>>(pair);
    value = {width, height};
    return true;
  }
  static handle cast(slipstream::Size size, return_value_policy, handle) {
    return make_tuple(size.width, size.height).release();
  }
};

}  // namespace pybind11::detail

namespace slipstream::python {
namespace py = pybind11;

/// Pixels as numpy has them: an enumeration as its number, several numbers as a last axis.
template <class Pixel>
struct Element {
  using Type = Pixel;
  static constexpr py::ssize_t count = 1;
};
template <class Pixel>
requires std::is_enum_v<Pixel>
struct Element<Pixel> {
  using Type = std::underlying_type_t<Pixel>;
  static constexpr py::ssize_t count = 1;
};
template <class Number, std::size_t numbers>
struct Element<std::array<Number, numbers>> {
  using Type = Number;
  static constexpr py::ssize_t count = numbers;
};

/// The pixels themselves, rows x columns; the array keeps `owner` alive.
template <class Pixel>
py::array array_over(ImageView<const Pixel> image, const py::object& owner) {
  using Type = typename Element<Pixel>::Type;
  constexpr py::ssize_t count = Element<Pixel>::count, pixel = sizeof(Pixel), one = sizeof(Type);
  std::vector<py::ssize_t> shape{image.height(), image.width()};
  std::vector<py::ssize_t> strides{image.stride() * pixel, pixel};
  if (count > 1) {
    shape.push_back(count);
    strides.push_back(one);
  }
  return {py::dtype::of<Type>(), shape, strides, image.row(0), owner};
}

/// The same, to read.
template <class Pixel>
py::array array_of(ImageView<const Pixel> image, const py::object& owner) {
  py::array array = array_over(image, owner);
  array.attr("flags").attr("writeable") = false;
  return array;
}

/// None of an image without pixels.
template <class Pixel>
py::object array_of(const Image<Pixel>& image, const py::object& owner) {
  if (image.empty()) return py::none();
  return array_of(ImageView<const Pixel>(image), owner);
}

/// An image that is the array's alone: it may be written.
template <class Pixel>
py::array array_from(Image<Pixel> image) {
  auto held = std::make_unique<Image<Pixel>>(std::move(image));
  const ImageView<const Pixel> view = *held;
  const py::capsule owner(held.get(), [](void* one) { delete static_cast<Image<Pixel>*>(one); });
  held.release();
  return array_over(view, owner);
}

/// A copy of an array, rows x columns.
template <class Number>
Image<Number> image_from(const py::array_t<Number, py::array::forcecast>& array) {
  if (array.ndim() != 2) throw py::type_error("an array of rows x columns is wanted");
  const auto pixels = array.template unchecked<2>();
  Image<Number> image({static_cast<int>(pixels.shape(1)), static_cast<int>(pixels.shape(0))});
  for (int row = 0; row < image.height(); ++row) {
    for (int column = 0; column < image.width(); ++column) image(column, row) = pixels(row, column);
  }
  return image;
}

/// Frames where they stand, and what keeps them there.
struct BorrowedFrames {
  std::vector<py::object> owners;
  FrameViews views;
};

/// Of `Frames`, of one array frames x rows x columns or of a list of arrays rows x columns: uint8,
/// uint16 of `bits` (16 where not said), or float64. Nothing is copied. Throws Error where the
/// pixels of a row do not lie side by side, or the arrays are no frames.
BorrowedFrames borrowed(const py::object& frames, std::optional<int> bits);

/// Frames as `Frames` gives them, of any FrameSet.
py::array frame_at(const FrameViews& frames, int n, const py::object& owner);

}  // namespace slipstream::python
