#pragma once

#include <array>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <tbb/concurrent_queue.h>

#include "slipstream/base/error.h"
#include "slipstream/check/scan_check.h"
#include "slipstream/reconstruct/engine.h"
#include "slipstream/simulate/virtual_world.h"

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

// What each file of this folder adds to the module; those that follow use the types of those
// before.
void bind_scanners(py::module_& module);
void bind_scans(py::module_& module);
void bind_clouds(py::module_& module);
void bind_engine(py::module_& module);
void bind_virtual_world(py::module_& module);
void bind_calibration(py::module_& module);
void bind_live(py::module_& module);

/// Members, or functions of the object, to read: add(bound, "gamma", &T::gamma, "size", size_of).
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

/// The pixels themselves, rows x columns, or x 3 of points; the array keeps `owner` alive.
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

/// The same, to read; None of an image without pixels.
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

/// An image that is the array's alone: it may be written.
template <class Pixel>
py::array array_from(Image<Pixel> image) {
  auto held = std::make_unique<Image<Pixel>>(std::move(image));
  const ImageView<const Pixel> view = *held;
  const py::capsule owner(held.release(), [](void* of) { delete static_cast<Image<Pixel>*>(of); });
  return array_over(view, owner);
}

/// A copy of an array, rows x columns. Throws Error for another shape.
Image<float> image_from(const ArrayOf<float>& array);

/// Frames where they stand, and what keeps them there.
struct BorrowedFrames {
  std::vector<py::object> owners;
  FrameViews views;
};

/// Of `Frames`, of one array frames x rows x columns or of a list of arrays rows x columns: uint8,
/// uint16 of `bits` (16 where not said), or float64. Nothing is copied. Throws Error where the
/// pixels of a row do not lie side by side, or the arrays are no frames.
BorrowedFrames borrowed(const py::object& frames, std::optional<int> bits);

/// As warnings.warn, each as "NAME: LINE", or the line alone where there is no name.
void warn_of(const std::string& name, const std::vector<std::string>& lines);

/// Warns of findings and repairs; throws Error where something is wrong, unless `anyway`.
void refuse_or_warn(const CheckedScan& checked, const std::string& name, bool anyway);

/// A Scan, or the path of one, checked and put in order, and what messages call it. `of_gamma`:
/// what blames the response is no finding. Throws Error where it is refused.
std::pair<Scan, std::string> checked_scan(const py::handle& scan, bool of_gamma);

/// Keyword arguments, taken one by one. Given a list as `_describe`, it describes those that it
/// takes instead: python/stub.py asks for that.
class Keywords {
 public:
  explicit Keywords(const py::kwargs& given);

  /// Those that were given, by name: take("rate", rate, "loop", loop). Throws TypeError for what is
  /// no such value.
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
  /// The same of one that must be given.
  template <class Value>
  void need(const char* name, Value& value) {
    if (described_) return describe<Value>(name, py::ellipsis());
    if (!left_.contains(name)) throw py::type_error(std::string(name) + " is missing");
    take(name, value);
  }
  /// Throws TypeError, and says what was meant, where any is left, or once they are described.
  void require_none_left() const;

 private:
  [[noreturn]] static void refuse(const char* name, const py::object& given);

  /// Its name, a signature that has its type, and its default.
  template <class Value>
  void describe(const char* name, const py::object& usual) {
    described_->append(py::make_tuple(name, py::cpp_function([](const Value&) {}).doc(), usual));
  }

  py::dict left_;
  std::optional<py::list> described_;
  std::vector<std::string> known_;
};

// Those of CleanSettings, ReconstructSettings and FringeOrderConsensus by the names they have
// there; of the second also `backend`, see set_backend, and `raw` for no cleaning and no range of
// depth.
void take(Keywords& keywords, CleanSettings& clean);
void take(Keywords& keywords, ReconstructSettings& settings);

/// Settings of keywords that say nothing else.
template <class Settings>
Settings settings_from(const py::kwargs& given) {
  Keywords keywords(given);
  Settings settings;
  take(keywords, settings);
  keywords.require_none_left();
  return settings;
}

/// By `scene` or `mesh`, `world`, `scanner` or `camera`, `ambient`, `noise_variance`,
/// `reflectivity`, `response`, `bits`, `seed`, `rays`, and how it moves from frame to frame:
/// `step`, mm, and `turn`, degrees about the upright axis.
VirtualWorld world_from(Keywords& keywords);

/// A cloud in Python's hands; its arrays show it and nothing writes to it any more.
class HeldCloud {
 public:
  using Points = Image<std::array<float, 3>>;

  /// X, Y, Z of each pixel side by side: made when first asked for. From any thread.
  const Points& points();
  /// To be written anew.
  Cloud& fresh() {
    has_points_ = false;
    remarks.clear();
    return cloud;
  }

  Cloud cloud{};
  std::vector<std::string> remarks{};  ///< of what is wrong with it: for the header of its file

 private:
  std::mutex mutex_;
  bool has_points_ = false;
  Points points_;
};

/// Values that come back with the last share in them, 16 at most, and are given out again, in any
/// thread: memory that is fresh from the system costs about as much as a cloud.
template <class Value>
class Reused {
 public:
  Reused() { free_->set_capacity(16); }

  /// One that came back, as its last holder left it, or else a new one made of those arguments.
  template <class... Arguments>
  std::shared_ptr<Value> take(const Arguments&... arguments) {
    std::unique_ptr<Value> value;
    if (!free_->try_pop(value)) value = std::make_unique<Value>(arguments...);
    return {value.release(),
            [free = free_](Value* of) { free->try_push(std::unique_ptr<Value>(of)); }};
  }

 private:
  using Free = tbb::concurrent_bounded_queue<std::unique_ptr<Value>>;
  std::shared_ptr<Free> free_ = std::make_shared<Free>();
};

}  // namespace slipstream::python
