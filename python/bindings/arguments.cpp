#include "python/bindings/arguments.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/throw_if-inl.h"
#include "frames/pattern_windows.h"
#include "slipstream/frame_set.h"

namespace slipstream::python {
namespace {

template <class Pixel>
FrameViews views_of(const std::vector<py::object>& frames, int bits) {
  constexpr auto pixel = static_cast<py::ssize_t>(sizeof(Pixel));
  Frames<Pixel> views;

  for (const py::object& of : frames) {
    if (!py::isinstance<py::array_t<Pixel>>(of)) throw Error("frames: arrays of different types");

    const auto frame = py::reinterpret_borrow<py::array>(of);
    throw_if(
        (frame.strides(1) != pixel && frame.shape(1) > 1) || frame.strides(0) % pixel != 0,
        "frames: the pixels of a row are not contiguous; pass numpy.ascontiguousarray(frames)");

    const Size size{static_cast<int>(frame.shape(1)), static_cast<int>(frame.shape(0))};
    views.emplace_back(static_cast<const Pixel*>(frame.data()), size, frame.strides(0) / pixel);
  }

  throw_if(sizeof(Pixel) != 2 && bits != 8, "frames: expected 16-bit pixels, got {} bits", bits);
  return {views, bits};
}

std::vector<py::object> arrays_in(const py::object& frames) {
  std::vector<py::object> arrays;
  throw_if(py::isinstance<py::array>(frames) && frames.attr("ndim").cast<int>() != 3,
           "frames: expected one array of frames x rows x columns");

  for (const py::handle frame : frames) {
    const py::array array = py::array::ensure(frame);
    if (!array) throw py::error_already_set();
    if (array.ndim() != 2) throw Error("frames: expected arrays of rows x columns");
    arrays.push_back(array);
  }

  if (arrays.empty()) throw Error("frames: empty");
  return arrays;
}

}  // namespace

Image<float> image_from(const ArrayOf<float>& array) {
  if (array.ndim() != 2) throw Error("expected an array of rows x columns");

  Image<float> image({static_cast<int>(array.shape(1)), static_cast<int>(array.shape(0))});
  for_each_pixel_in_order(image.size(),
                          [&](int column, int row) { image(column, row) = array.at(row, column); });
  return image;
}

BorrowedFrames borrowed(const py::object& frames, std::optional<int> bits) {
  if (py::isinstance<FrameSet>(frames)) return {{frames}, frames.cast<const FrameSet&>().views()};

  std::vector<py::object> arrays = arrays_in(frames);
  FrameViews views;

  // All arrays must have the first one's type.
  const py::object& first = arrays.front();
  if (py::isinstance<py::array_t<std::uint8_t>>(first)) {
    views = views_of<std::uint8_t>(arrays, bits.value_or(8));
  } else if (py::isinstance<py::array_t<std::uint16_t>>(first)) {
    views = views_of<std::uint16_t>(arrays, bits.value_or(16));
  } else if (py::isinstance<py::array_t<double>>(first)) {
    views = views_of<double>(arrays, bits.value_or(8));
  } else {
    throw Error(fmt::format("frames: type {}; expected uint8, uint16 or float64",
                            py::str(first.attr("dtype")).cast<std::string>()));
  }

  return {std::move(arrays), std::move(views)};
}

Keywords::Keywords(const py::kwargs& given) : left_(given.attr("copy")()) {}

void Keywords::require_none_left() const {
  for (const auto& [name, value] : left_) {
    const auto word = name.cast<std::string>();
    throw py::type_error(
        fmt::format("there is no setting '{}'{}", word, did_you_mean(word, known_)));
  }
}

void Keywords::refuse(const char* name, const py::object& given) {
  throw py::type_error(fmt::format("{} cannot be {}", name, py::repr(given).cast<std::string>()));
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

  if (raw) {  // settings without a keyword
    settings.clean = CleanSettings::none();
    settings.nearest = settings.nearest.value_or(0);
    settings.farthest = settings.farthest.value_or(std::numeric_limits<double>::infinity());
  }

  // After `raw`, so that single cleaning settings override it.
  take_described(keywords, settings.clean);
}

}  // namespace slipstream::python
