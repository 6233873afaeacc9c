#include "python/bindings/arguments.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/throw_if-inl.h"
#include "frames/pattern_windows.h"
#include "python/bindings/given.h"
#include "slipstream/frame_set.h"

namespace slipstream::python {
namespace {

std::string as_text(const py::object& value) {
  return py::str(value).cast<std::string>();
}

template <class Pixel>
FrameViews views_of(const std::vector<py::object>& frames, int bits) {
  constexpr auto pixel = static_cast<py::ssize_t>(sizeof(Pixel));
  Frames<Pixel> views;

  for (const py::object& item : frames) {
    if (!py::isinstance<py::array_t<Pixel>>(item)) throw Error("frames: arrays of different types");

    const auto frame = py::reinterpret_borrow<py::array>(item);
    throw_if(
        (frame.strides(1) != pixel && frame.shape(1) > 1) || frame.strides(0) % pixel != 0,
        "frames: the pixels of a row are not contiguous; pass numpy.ascontiguousarray(frames)");

    const Size size{static_cast<int>(frame.shape(1)), static_cast<int>(frame.shape(0))};
    views.emplace_back(static_cast<const Pixel*>(frame.data()), size, frame.strides(0) / pixel);
  }

  throw_if(sizeof(Pixel) != 2 && bits != 8, "frames: expected 16-bit pixels, got {} bits", bits);
  return {views, bits};
}

/// Advice on an array that is not frames x rows x columns.
std::string advice_on_stack(const py::array& stack, int count) {
  const py::ssize_t dimensions = stack.ndim();
  const bool is_colour = dimensions == 4 && (stack.shape(3) == 3 || stack.shape(3) == 4);
  if (is_colour) return "; of colours give one channel, as numpy.ascontiguousarray(frames[..., 1])";

  const bool has_count_last =
      dimensions == 3 && count != 0 && stack.shape(2) == count && stack.shape(0) != count;
  if (has_count_last) return ", as numpy.ascontiguousarray(numpy.moveaxis(frames, -1, 0))";
  return "";
}

std::string advice_on_picture(const py::array& picture) {
  const bool is_colour = picture.ndim() == 3 && (picture.shape(2) == 3 || picture.shape(2) == 4);
  return is_colour ? "; of colours give one channel, as numpy.ascontiguousarray(frame[..., 1])"
                   : "";
}

/// One array of `count` frames, if that is not 0, or several arrays of one frame.
std::vector<py::object> arrays_in(const py::object& frames, int count) {
  throw_if(is_path(frames), "frames: {}; expected arrays: `load_scan()` reads files",
           shown(frames));

  if (py::isinstance<py::array>(frames)) {
    const auto stack = py::reinterpret_borrow<py::array>(frames);
    const std::string advice = advice_on_stack(stack, count);
    throw_if(stack.ndim() != 3 || !advice.empty(), "frames: {}; expected frames x rows x columns{}",
             shown(stack), advice);
  }

  if (!py::isinstance<py::iterable>(frames)) {
    throw py::type_error(fmt::format("frames cannot be {}; expected arrays", shown(frames)));
  }

  std::vector<py::object> arrays;
  for (const py::handle frame : frames) {
    throw_if(is_path(frame), "frames: {}; expected arrays: `load_scan()` reads files",
             shown(frame));

    const py::array array = py::array::ensure(frame);
    if (!array) throw py::error_already_set();
    throw_if(array.ndim() != 2, "frames: one is {}; expected rows x columns{}", shown(array),
             advice_on_picture(array));
    arrays.push_back(array);
  }

  if (arrays.empty()) throw Error("frames: empty");
  return arrays;
}

bool is_narrow_float(const py::object& array) {
  const std::string type = as_text(array.attr("dtype"));
  return type == "float32" || type == "float16";
}

}  // namespace

Image<float> image_from(const ArrayOf<float>& array) {
  if (array.ndim() != 2) throw Error("expected an array of rows x columns");

  Image<float> image({static_cast<int>(array.shape(1)), static_cast<int>(array.shape(0))});
  for_each_pixel_in_order(image.size(),
                          [&](int column, int row) { image(column, row) = array.at(row, column); });
  return image;
}

BorrowedFrames borrowed(const py::object& frames, std::optional<int> bits, int count) {
  if (py::isinstance<FrameSet>(frames)) return {{frames}, frames.cast<const FrameSet&>().views()};

  std::vector<py::object> arrays = arrays_in(frames, count);
  FrameViews views;

  // Real numbers are decoded with 64 bits.
  for (py::object& array : arrays) {
    if (is_narrow_float(array)) array = array.attr("astype")("float64");
  }

  // All arrays must have the first one's type.
  const py::object& first = arrays.front();
  if (py::isinstance<py::array_t<std::uint8_t>>(first)) {
    views = views_of<std::uint8_t>(arrays, bits.value_or(8));
  } else if (py::isinstance<py::array_t<std::uint16_t>>(first)) {
    views = views_of<std::uint16_t>(arrays, bits.value_or(16));
  } else if (py::isinstance<py::array_t<double>>(first)) {
    views = views_of<double>(arrays, bits.value_or(8));
  } else {
    throw Error(fmt::format("frames: type {}; expected uint8, uint16, float32 or float64",
                            as_text(first.attr("dtype"))));
  }

  return {std::move(arrays), std::move(views)};
}

void require_upright(Size frames, Size camera) {
  const bool exchanged = frames.width != frames.height && frames.width == camera.height &&
                         frames.height == camera.width;
  throw_if(exchanged,
           "frames: {} rows and {} columns, but the scanner's camera_size is ({}, {}): width and "
           "height are exchanged in one of them; camera_size is (columns, rows)",
           frames.height, frames.width, camera.width, camera.height);
}

std::string shown(const py::handle& value) {
  if (py::isinstance<py::array>(value)) {
    return fmt::format("an array of shape {} and type {}", as_text(value.attr("shape")),
                       as_text(value.attr("dtype")));
  }

  constexpr std::size_t longest = 80;
  py::object text = py::repr(value).attr("replace")("\n", " ");
  if (py::len(text) <= longest) return as_text(text);
  return as_text(text[py::slice(0, longest - 3, 1)]) + "...";
}

Keywords::Keywords(const py::kwargs& kwargs) : left_(kwargs.attr("copy")()) {}

void Keywords::require_none_left() const {
  for (const auto& [name, value] : left_) {
    const auto word = name.cast<std::string>();
    throw py::type_error(
        fmt::format("there is no setting '{}'{}", word, did_you_mean(word, known_)));
  }
}

void Keywords::refuse(const char* name, const py::object& given) {
  throw py::type_error(fmt::format("{} cannot be {}", name, shown(given)));
}

std::string keyword_of(std::string_view option) {
  std::string name(option);
  std::ranges::replace(name, '-', '_');
  return name;
}

void take(Keywords& keywords, CleanSettings& clean) {
  take_described(keywords, clean);
}

void take(Keywords& keywords, ReconstructSettings& settings) {
  std::string backend = "fused", cue_rule(name_of(settings.cue_rule));
  bool raw = false;
  keywords.take("backend", backend, "cue_rule", cue_rule, "raw", raw);

  set_backend(settings, backend);
  settings.cue_rule = cue_rule_named(cue_rule);

  take_described(keywords, settings);

  // Single cleaning settings override `raw`.
  if (raw) keep_all_points(settings);
  take_described(keywords, settings.clean);
}

}  // namespace slipstream::python
