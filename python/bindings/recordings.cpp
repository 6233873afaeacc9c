#include <chrono>

#include "python/bindings/arrays.h"
#include "python/bindings/bindings.h"
#include "python/bindings/python_source.h"
#include "slipstream/error/error.h"
#include "slipstream/io/recording.h"

namespace slipstream::python {
namespace {
namespace fs = std::filesystem;

std::shared_ptr<Frame> frame_of(const RecordingReader& of, std::int64_t n) {
  const auto count = static_cast<std::int64_t>(of.count());
  const std::int64_t place = n < 0 ? n + count : n;
  if (place < 0 || place >= count) throw py::index_error("no such frame in the recording");
  const py::gil_scoped_release release;
  auto frame = std::make_shared<Frame>();
  if (of.read(static_cast<std::uint64_t>(place), *frame)) return frame;
  throw Error("frame " + std::to_string(place) + " of the recording is damaged");
}

/// Gives the frames that are whole.
struct WholeFrames {
  std::shared_ptr<const RecordingReader> recording;
  std::uint64_t next = 0;

  std::shared_ptr<Frame> take() {
    {
      const py::gil_scoped_release release;
      auto frame = std::make_shared<Frame>();
      while (next < recording->count()) {
        if (recording->read(next++, *frame)) return frame;
      }
    }
    throw py::stop_iteration();
  }
};

/// A recording that is being written.
class Writer {
 public:
  Writer(const fs::path& path, const Sequence& sequence, std::optional<Scanner> scanner,
         double frame_rate)
      : path_(path), header_{{}, frame_rate, sequence, std::move(scanner)} {}

  void append(const py::object& frame, std::optional<int> bits) {
    Frame made;
    copy_frame(frame, bits, made);
    const py::gil_scoped_release release;
    if (!writer_) {
      header_.format = made.format();
      writer_ = std::make_unique<RecordingWriter>(path_, header_);
    }
    made.stamp.sequence = writer_->count();
    made.stamp.host_time = std::chrono::steady_clock::now();
    writer_->append(made);
  }
  void finish() {
    if (writer_) writer_->finish();
    writer_.reset();
  }

 private:
  fs::path path_;
  RecordingHeader header_;
  std::unique_ptr<RecordingWriter> writer_;
};

void bind_frame(py::module_& module) {
  py::class_<Frame, std::shared_ptr<Frame>>(module, "Frame", "One camera picture.")
      .def_property_readonly(
          "pixels",
          [](const py::object& self) {
            return std::visit([&](const auto& image) { return array_of(image, self); },
                              self.cast<const Frame&>().pixels);
          },
          "Rows x columns, to read; uint8, or uint16 of `bits`.")
      .def_readonly("bits", &Frame::bits)
      .def_property_readonly(
          "sequence", [](const Frame& of) { return of.stamp.sequence; },
          "The device's count; a gap is a lost frame.")
      .def_property_readonly("pattern_index",
                             [](const Frame& of) { return of.stamp.pattern_index; })
      .def_property_readonly(
          "device_time",
          [](const Frame& of) {
            return std::chrono::duration<double>(of.stamp.device_time).count();
          },
          "Seconds, of the device's own clock.")
      .def("__repr__", [](const Frame& of) {
        return py::str("<slipstream.Frame {} of {}>")
            .format(of.stamp.sequence, text_of(of.format().size));
      });
}

}  // namespace

void bind_recordings(py::module_& module) {
  bind_frame(module);
  py::class_<WholeFrames>(module, "_WholeFrames")
      .def("__iter__", [](const py::object& self) { return self; })
      .def("__next__", &WholeFrames::take);
  py::class_<RecordingReader, std::shared_ptr<RecordingReader>>(
      module, "Recording", "Raw frames in one file; going over it leaves damaged ones out.")
      .def(py::init<const fs::path&>(), py::arg("path"), py::call_guard<py::gil_scoped_release>())
      .def("__len__", &RecordingReader::count)
      .def("__getitem__", &frame_of)
      .def("__iter__", [](const std::shared_ptr<RecordingReader>& of) { return WholeFrames{of}; })
      .def_property_readonly("sequence",
                             [](const RecordingReader& of) { return of.header().sequence; })
      .def_property_readonly("scanner",
                             [](const RecordingReader& of) { return of.header().scanner; })
      .def_property_readonly("frame_rate",
                             [](const RecordingReader& of) { return of.header().frame_rate; })
      .def_property_readonly("finished", &RecordingReader::finished, "Else it was interrupted.")
      .def("__repr__", [](const RecordingReader& of) {
        return py::str("<slipstream.Recording of {} frames of {}>")
            .format(of.count(), text_of(of.header().format.size));
      });
  py::class_<Writer>(module, "Recorder", "with Recorder(path, sequence) as r: r.append(frame)")
      .def(py::init<const fs::path&, const Sequence&, std::optional<Scanner>, double>(),
           py::arg("path"), py::arg("sequence"), py::arg("scanner") = py::none(), py::kw_only(),
           py::arg("frame_rate") = 0.)
      .def("append", &Writer::append, py::arg("frame"), py::kw_only(), py::arg("bits") = py::none())
      .def("finish", &Writer::finish, py::call_guard<py::gil_scoped_release>())
      .def("__enter__", [](const py::object& self) { return self; })
      .def("__exit__", [](Writer& writer, const py::args&) { writer.finish(); });
}

}  // namespace slipstream::python
