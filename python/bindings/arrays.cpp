#include "python/bindings/arrays.h"

#include <cstddef>
#include <string>

#include <fmt/format.h>

#include "slipstream/capture/frame_set.h"
#include "slipstream/error/error.h"

namespace slipstream::python {
namespace {

template <class Pixel>
ImageView<const Pixel> view_of(const py::array& frame) {
  constexpr auto pixel = static_cast<py::ssize_t>(sizeof(Pixel));
  if (!py::isinstance<py::array_t<Pixel>>(frame)) throw Error("frames: arrays of different types");
  const bool in_rows = frame.strides(1) == pixel || frame.shape(1) <= 1;
  if (!in_rows || frame.strides(0) % pixel != 0) {
    throw Error(
        "frames: the pixels of a row do not lie side by side; numpy.ascontiguousarray makes a copy "
        "whose do");
  }
  const Size size{static_cast<int>(frame.shape(1)), static_cast<int>(frame.shape(0))};
  return {static_cast<const Pixel*>(frame.data()), size, frame.strides(0) / pixel};
}

template <class Pixel>
Frames<Pixel> views_of(const std::vector<py::object>& frames) {
  Frames<Pixel> views;
  for (const py::object& frame : frames) {
    views.push_back(view_of<Pixel>(py::reinterpret_borrow<py::array>(frame)));
  }
  return views;
}

std::vector<py::object> arrays_in(const py::object& frames) {
  std::vector<py::object> arrays;
  if (py::isinstance<py::array>(frames) && frames.attr("ndim").cast<int>() != 3) {
    throw Error("frames: one array is frames x rows x columns");
  }
  for (const py::handle frame : frames) {
    const py::array array = py::array::ensure(frame);
    if (!array) throw py::error_already_set();
    if (array.ndim() != 2) throw Error("frames: each array is rows x columns");
    arrays.push_back(array);
  }
  if (arrays.empty()) throw Error("frames: there are none");
  return arrays;
}

}  // namespace

BorrowedFrames borrowed(const py::object& frames, std::optional<int> bits) {
  if (py::isinstance<FrameSet>(frames)) return {{frames}, frames.cast<const FrameSet&>().views()};
  std::vector<py::object> arrays = arrays_in(frames);
  const py::object& first = arrays.front();
  FrameViews views;
  if (py::isinstance<py::array_t<std::uint8_t>>(first)) {
    if (bits.value_or(8) != 8) throw Error(fmt::format("frames: of uint8, but of {} bits", *bits));
    views = FrameViews(views_of<std::uint8_t>(arrays));
  } else if (py::isinstance<py::array_t<std::uint16_t>>(first)) {
    views = FrameViews(views_of<std::uint16_t>(arrays), bits.value_or(16));
  } else if (py::isinstance<py::array_t<double>>(first)) {
    views = FrameViews(views_of<double>(arrays));
  } else {
    throw Error(fmt::format("frames: of {}; uint8, uint16 or float64 are wanted",
                            py::str(first.attr("dtype")).cast<std::string>()));
  }
  return {std::move(arrays), std::move(views)};
}

py::array frame_at(const FrameViews& frames, int n, const py::object& owner) {
  const int count = frames.count();
  const int place = n < 0 ? n + count : n;
  if (place < 0 || place >= count) throw py::index_error(fmt::format("frame {} of {}", n, count));
  return frames.visit([&](const auto& views) -> py::array {
    return array_of(views[static_cast<std::size_t>(place)], owner);
  });
}

}  // namespace slipstream::python
