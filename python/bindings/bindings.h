#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <tbb/concurrent_queue.h>

#include "slipstream/check.h"
#include "slipstream/engine.h"
#include "slipstream/error.h"
#include "slipstream/virtual_world.h"

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

// Parts of the module, one per file of this folder; later ones use the types of earlier ones.
void bind_scanners(py::module_& module);
void bind_scans(py::module_& module);
void bind_clouds(py::module_& module);
void bind_engine(py::module_& module);
void bind_virtual_world(py::module_& module);
void bind_calibration(py::module_& module);
void bind_live(py::module_& module);

/// Adds read-only members or functions of the object: add(bound, "gamma", &T::gamma, "size",
/// size_of).
template <class Bound, class Member, class... More>
void add(Bound& bound, const char* name, Member member, const More&... more) {
  if constexpr (std::is_member_object_pointer_v<Member>) {
    bound.def_readonly(name, member);
  } else {
    bound.def_property_readonly(name, member);
  }

  if constexpr (sizeof...(more) > 0) add(bound, more...);
}

/// A member of a member, for `add`.
template <class Owner, class Outer, class Inner>
auto within(Outer Owner::*outer, Inner Outer::*inner) {
  return [=](const Owner& of) -> Inner { return (of.*outer).*inner; };
}

/// Pairs of a name and a value as a dict.
template <class Pairs>
py::dict dict_of(const Pairs& pairs) {
  py::dict named;

  // Keys from std::string or const char*.
  for (const auto& [name, value] : pairs) named[py::str(name)] = value;
  return named;
}

/// Several results by their names, as a types.SimpleNamespace.
template <class... Named>
py::object results(Named&&... named) {
  static const py::handle type =
      py::object(py::module_::import("types").attr("SimpleNamespace")).release();
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
  const py::capsule owner(held.release(), [](void* of) { delete static_cast<Image<Pixel>*>(of); });

  return array_over(view, owner);
}

/// A copy of an array, rows x columns. Throws Error for other shapes.
Image<float> image_from(const ArrayOf<float>& array);

/// Borrowed frames, and the object that keeps them alive.
struct BorrowedFrames {
  std::vector<py::object> owners;
  FrameViews views;
};

/// Takes `Frames`, one array frames x rows x columns, or a list of arrays rows x columns: uint8,
/// uint16 of `bits` (default 16), or float64. Copies nothing. Throws Error if a row's pixels are
/// not contiguous or the arrays are not frames.
BorrowedFrames borrowed(const py::object& frames, std::optional<int> bits);

/// Calls warnings.warn for each line, as "NAME: LINE" or the line alone without a name.
void warn_of(const std::string& name, const std::vector<std::string>& lines);

/// Warns of diagnostics and repairs; throws Error if the scan is refused, unless `anyway`.
void refuse_or_warn(const CheckedScan& checked, const std::string& name, bool anyway);

/// A Scan, or one loaded from a path, checked and with its frames in order, and its name for
/// messages. `of_gamma`: ignores diagnostics that blame the response. Throws Error if it is
/// refused.
std::pair<Scan, std::string> checked_scan(const py::handle& scan, bool of_gamma);

/// Keyword arguments, taken one by one. With a list as `_describe`, describes the accepted keywords
/// instead, for python/stub.py.
class Keywords {
 public:
  explicit Keywords(const py::kwargs& given);

  /// Takes given keywords by name: take("rate", rate, "loop", loop). Throws TypeError for a value
  /// of the wrong type.
  template <class Value, class... More>
  void take(const char* name, Value& value, More&... more) {
    known_.emplace_back(name);
    if (described_) describe<Value>(name, py::cast(value));

    if (left_.contains(name)) {
      const py::object given = left_.attr("pop")(name);
      try {
        value = given.cast<Value>();
      } catch (const py::cast_error&) {
        refuse(name, given);
      }
    }

    if constexpr (sizeof...(more) > 0) take(more...);
  }

  /// Describes the keyword taken next by its setting.
  void explain(const Setting& setting) { help_ = setting.option_clears ? "" : setting.help; }

  /// Takes a required keyword.
  template <class Value>
  void need(const char* name, Value& value) {
    if (described_) return describe<Value>(name, py::ellipsis());
    if (!left_.contains(name)) throw py::type_error(std::string(name) + " is missing");
    take(name, value);
  }

  /// Throws TypeError with a suggestion if any keyword is left, or after describing them.
  void require_none_left() const;

 private:
  [[noreturn]] static void refuse(const char* name, const py::object& given);

  /// Name, a signature with its type, default, and help of its setting.
  template <class Value>
  void describe(const char* name, const py::object& usual) {
    described_->append(py::make_tuple(name, py::cpp_function([](const Value&) {}).doc(), usual,
                                      std::exchange(help_, {})));
  }

  py::dict left_;
  std::optional<py::list> described_;
  std::vector<std::string> known_;
  std::string help_;
};

// Takes the members of CleanSettings, ReconstructSettings and FringeOrderConsensus by name; also
// `backend`, see set_backend, and `raw` for no cleaning and no depth range.
void take(Keywords& keywords, CleanSettings& clean);
void take(Keywords& keywords, ReconstructSettings& settings);

/// Takes the settings that a struct describes: see Setting.
template <class Settings>
void take_described(Keywords& keywords, Settings& settings) {
  Settings::for_each_setting(settings, [&](const Setting& setting, auto& value) {
    using Value = std::remove_reference_t<decltype(value)>;
    keywords.explain(setting);

    if constexpr (std::is_same_v<Value, std::optional<PointBox>>) {
      using Corner = std::array<double, 3>;
      std::optional<std::pair<Corner, Corner>> box;
      keywords.take(setting.name, box);
      if (box) value = PointBox{box->first, box->second};
    } else if constexpr (std::is_same_v<Value, std::vector<PictureCorner>>) {
      std::vector<std::pair<double, double>> corners;
      keywords.take(setting.name, corners);
      for (const auto& [column, row] : corners) value.push_back({column, row});
    } else {
      keywords.take(setting.name, value);
    }
  });
}

/// Settings from keywords, none of which may be left.
template <class Settings>
Settings settings_from(const py::kwargs& given) {
  Keywords keywords(given);
  Settings settings;
  take(keywords, settings);

  keywords.require_none_left();
  return settings;
}

/// Takes the keywords of `simulate`.
VirtualWorld world_from(Keywords& keywords);

/// A cloud owned by Python; its arrays view it, and nothing writes to it any more.
class HeldCloud {
 public:
  using Points = Image<std::array<float, 3>>;

  /// X, Y, Z of each pixel side by side, made on first use. From any thread.
  const Points& points();

  /// Resets it for reuse.
  Cloud& fresh() {
    has_points_ = false;
    remarks.clear();
    return cloud;
  }

  Cloud cloud{};
  std::vector<std::string> remarks{};  ///< its diagnostics, for the header of its file

 private:
  std::mutex mutex_;
  bool has_points_ = false;
  Points points_;
};

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
            [free = free_](Value* of) { free->try_push(std::unique_ptr<Value>(of)); }};
  }

 private:
  using Free = tbb::concurrent_bounded_queue<std::unique_ptr<Value>>;
  std::shared_ptr<Free> free_ = std::make_shared<Free>();
};

}  // namespace slipstream::python
