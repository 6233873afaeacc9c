#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <tbb/concurrent_queue.h>

#include "slipstream/image.h"

namespace pybind11::detail {

/// (width, height)
template <>
struct type_caster<slipstream::Size> {
  PYBIND11_TYPE_CASTER(slipstream::Size, const_name("tuple[int, int]"));

  bool load(handle source, bool convert) {
    make_caster<std::pair<int, int>> pair;
    if (!pair.load(source, convert)) return false;
    std::tie(value.width, value.height) = cast_op<std::pair<int, int>>(pair);
    return true;
  }

  static handle cast(slipstream::Size size, return_value_policy, handle) {
    return make_tuple(size.width, size.height).release();
  }
};

}  // namespace pybind11::detail

namespace slipstream::python {
namespace py = pybind11;
namespace fs = std::filesystem;
using namespace py::literals;
using Unlocked = py::call_guard<py::gil_scoped_release>;

template <class Number>
using ArrayOf = py::array_t<Number, py::array::forcecast>;

/// Adds a part of the module.
using Bind = void(py::module_& module);

// Later ones use the types of earlier ones.
Bind bind_sequences, bind_scanners, bind_scans, bind_findings, bind_clouds, bind_map_files,
    bind_spatial_unwrapping, bind_engine, bind_virtual_world, bind_calibration, bind_live;

/// A text of the library, see Error, with the module's names in backquotes: "`camera_bits 12`"
/// becomes "`bits 12`". Names of settings that only the program has become its commands:
/// "`slipstream view`".
std::string with_keywords(std::string_view text);

/// A getter of a member's member.
template <class Owner, class Outer, class Inner>
auto within(Outer Owner::*outer, Inner Outer::*inner) {
  return [=](const Owner& self) -> Inner { return (self.*outer).*inner; };
}

/// Several results by their names, as a types.SimpleNamespace that prints in one line.
template <class... Named>
py::object results(Named&&... named) {
  static const py::handle type =
      py::object(py::module_::import("slipstream").attr("_Results")).release();
  return type(std::forward<Named>(named)...);
}

/// Calls `compute` without the interpreter's lock.
template <class Compute>
auto unlocked(const Compute& compute) {
  const py::gil_scoped_release release;
  return compute();
}

/// The pixels without a copy, rows x columns, x 3 for points; the array keeps `owner` alive.
template <class Pixel>
py::array array_over(const ImageView<const Pixel>& image, const py::object& owner) {
  constexpr auto pixel = static_cast<py::ssize_t>(sizeof(Pixel));
  std::vector<py::ssize_t> shape{image.height(), image.width()};
  std::vector<py::ssize_t> strides{image.stride() * pixel, pixel};

  if constexpr (std::is_arithmetic_v<Pixel>) {
    return {py::dtype::of<Pixel>(), shape, strides, image.row(0), owner};
  } else if constexpr (std::is_enum_v<Pixel>) {
    return {py::dtype::of<std::underlying_type_t<Pixel>>(), shape, strides, image.row(0), owner};
  } else {
    shape.push_back(3);
    strides.push_back(sizeof(float));
    return {py::dtype::of<float>(), shape, strides, image.row(0), owner};
  }
}

/// The same, read-only; None for an image without pixels.
template <class Pixel>
py::object array_of(const ImageView<const Pixel>& image, const py::object& owner) {
  if (image.width() == 0) return py::none();

  py::array array = array_over(image, owner);
  array.attr("flags").attr("writeable") = false;
  return array;
}

template <class Pixel>
py::object array_of(const Image<Pixel>& image, const py::object& owner) {
  return array_of(ImageView<const Pixel>(image), owner);
}

/// An image owned by the array: writable.
template <class Pixel>
py::array array_from(Image<Pixel> image) {
  auto held = std::make_unique<Image<Pixel>>(std::move(image));
  const ImageView<const Pixel> view = *held;

  // The array's owner deletes the image.
  const py::capsule owner(held.release(),
                          [](void* self) { delete static_cast<Image<Pixel>*>(self); });

  return array_over(view, owner);
}

/// Recycles up to 16 values when their last owner is gone, in any thread: fresh memory from the
/// system costs about as much as a cloud.
template <class Value>
class Reused {
 public:
  Reused() { free_->set_capacity(16); }

  /// A recycled value, unchanged since its last use, or a new one made from the arguments.
  template <class... Arguments>
  std::shared_ptr<Value> take(const Arguments&... arguments) {
    std::unique_ptr<Value> value;
    if (!free_->try_pop(value)) value = std::make_unique<Value>(arguments...);

    // The deleter puts the value back; it shares the queue, so it may outlive this object.
    return {value.release(),
            [free = free_](Value* self) { free->try_push(std::unique_ptr<Value>(self)); }};
  }

 private:
  using Free = tbb::concurrent_bounded_queue<std::unique_ptr<Value>>;
  std::shared_ptr<Free> free_ = std::make_shared<Free>();
};

}  // namespace slipstream::python
