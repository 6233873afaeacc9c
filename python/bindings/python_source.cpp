#include "python/bindings/python_source.h"

#include <algorithm>
#include <chrono>

#include "slipstream/error/error.h"

namespace slipstream::python {

void copy_frame(const py::object& array, std::optional<int> bits, Frame& frame) {
  const BorrowedFrames given = borrowed(py::make_tuple(array), bits);
  const FrameFormat format{given.views.size(), given.views.bits()};
  if (!given.views.quantised()) throw Error("a camera's frame is of uint8 or uint16");
  if (frame.format() != format) frame = Frame(format);
  given.views.visit([&]<class Pixel>(const Frames<Pixel>& views) {
    if constexpr (!std::is_same_v<Pixel, double>) {
      auto& pixels = std::get<Image<Pixel>>(frame.pixels);
      for (int row = 0; row < pixels.height(); ++row) {
        std::copy_n(views.front().row(row), pixels.width(), pixels.row(row));
      }
    }
  });
}

PythonSource::PythonSource(const py::iterable& frames, std::optional<int> bits)
    : frames_(py::iter(frames)), bits_(bits) {
  const auto first = py::reinterpret_steal<py::object>(PyIter_Next(frames_.ptr()));
  if (PyErr_Occurred() != nullptr) throw py::error_already_set();
  if (!first) throw Error("the source gives no frame");
  copy_frame(first, bits_, first_);
}

PythonSource::~PythonSource() {
  const py::gil_scoped_acquire acquire;
  frames_ = {};
}

Arrival PythonSource::next(Frame& frame, std::chrono::milliseconds) {
  if (given_ == 0) {
    frame.pixels = first_.pixels;
  } else {
    const py::gil_scoped_acquire acquire;
    const auto array = py::reinterpret_steal<py::object>(PyIter_Next(frames_.ptr()));
    if (PyErr_Occurred() != nullptr) throw py::error_already_set();
    if (!array) return Arrival::ended;
    const FrameFormat wanted = format();
    copy_frame(array, bits_, frame);
    if (frame.format() != wanted)
      throw Error("the source's frames are of different sizes or types");
  }
  frame.stamp.sequence = given_++;
  frame.stamp.host_time = std::chrono::steady_clock::now();
  return Arrival::frame;
}

}  // namespace slipstream::python
