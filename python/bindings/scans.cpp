#include "python/bindings/scans.h"

#include <algorithm>

#include "python/bindings/arrays.h"
#include "python/bindings/bindings.h"
#include "slipstream/check/scan_check.h"
#include "slipstream/error/error.h"
#include "slipstream/io/saved_scan.h"
#include "slipstream/photometry/gamma_choice.h"
#include "slipstream/strategy/registry.h"

namespace slipstream::python {
namespace {
namespace fs = std::filesystem;

template <class Pixel>
std::vector<Image<Pixel>> copies_of(const Frames<Pixel>& views) {
  std::vector<Image<Pixel>> images;
  for (const ImageView<const Pixel>& view : views) {
    Image<Pixel>& image = images.emplace_back(view.size());
    for (int row = 0; row < view.height(); ++row) {
      std::copy_n(view.row(row), view.width(), image.row(row));
    }
  }
  return images;
}

FrameSet copy_of(const FrameViews& frames) {
  return frames.visit([&]<class Pixel>(const Frames<Pixel>& views) {
    if constexpr (std::is_same_v<Pixel, std::uint16_t>) {
      return FrameSet(copies_of(views), frames.bits());
    } else {
      return FrameSet(copies_of(views));
    }
  });
}

Scan scan_from(const py::object& frames, const Sequence& sequence,
               const std::optional<Scanner>& scanner, std::optional<int> bits) {
  const BorrowedFrames given = borrowed(frames, bits);
  if (given.views.count() != frame_count(sequence)) {
    throw Error("a scan of " + std::to_string(frame_count(sequence)) + " frames is given " +
                std::to_string(given.views.count()));
  }
  Scan scan{.frames = copy_of(given.views), .sequence = sequence, .scanner = scanner};
  if (scanner) {
    scan.scanner = completed(*scanner, "scanner", scan.frames.size(), sequence.projector);
  }
  scan.exposures = sequence.exposures;
  return merged(std::move(scan));
}

/// What is given takes the place of what the folder or the recording says.
Scan loaded_scan(const fs::path& path, const std::optional<Sequence>& sequence,
                 const std::optional<std::variant<Scanner, fs::path>>& scanner,
                 std::optional<int> bits, const std::string& order,
                 std::optional<std::uint64_t> window) {
  ScanChanges changes{.order = order, .window = window, .bits = bits};
  if (sequence) changes.sequence = changes_to(*sequence);
  if (scanner && std::holds_alternative<fs::path>(*scanner)) {
    changes.scanner = std::get<fs::path>(*scanner);
  }
  Scan scan = load_scan(path, changes);
  if (scanner && std::holds_alternative<Scanner>(*scanner)) {
    scan.scanner = completed(std::get<Scanner>(*scanner), "scanner", scan.frames.size(),
                             scan.sequence.projector);
    scan.sequence.projector = scan.scanner->projector.size;
  }
  return scan;
}

std::vector<Finding> findings_of(Scan scan, double minimum_modulation, bool moving,
                                 const std::string& gamma) {
  CheckSettings settings{.minimum_modulation = minimum_modulation, .moving = moving};
  settings.photometry.response = choose_response(scan, gamma).response;
  return check_and_repair(scan, settings).findings;
}

void bind_frames(py::module_& module) {
  py::class_<FrameSet, std::shared_ptr<FrameSet>>(
      module, "Frames", "The frames of a scan: arrays rows x columns, to read, of its memory.")
      .def("__len__", &FrameSet::count)
      .def("__getitem__",
           [](const py::object& self, int n) {
             return frame_at(self.cast<const FrameSet&>().views(), n, self);
           })
      .def_property_readonly("bits", &FrameSet::bits)
      .def_property_readonly("size", &FrameSet::size, "(width, height)")
      .def("__repr__", [](const FrameSet& of) {
        return py::str("<slipstream.Frames {} of {}, {} bits>")
            .format(of.count(), text_of(of.size()), of.bits());
      });
}

void bind_findings(py::module_& module) {
  py::class_<Finding>(module, "Finding", "Something that does not fit, as data.")
      .def_property_readonly("wrong",
                             [](const Finding& of) { return of.gravity == Gravity::wrong; })
      .def_readonly("what", &Finding::what)
      .def_readonly("likely", &Finding::likely, "The cause that fits best.")
      .def_readonly("advice", &Finding::advice)
      .def_property_readonly("evidence",
                             [](const Finding& of) {
                               py::dict evidence;
                               for (const auto& [name, value] : of.evidence) {
                                 evidence[py::str(name)] = value;
                               }
                               return evidence;
                             })
      .def("__str__", [](const Finding& of) { return text_of(of); })
      .def("__repr__", [](const Finding& of) {
        return std::string("<slipstream.Finding ") +
               (of.gravity == Gravity::wrong ? "wrong: " : "doubtful: ") + text_of(of) + ">";
      });
  module.def("check", &findings_of, py::arg("scan"), py::kw_only(),
             py::arg("minimum_modulation") = 15., py::arg("moving") = false,
             py::arg("gamma") = "scanner", py::call_guard<py::gil_scoped_release>(),
             "Whether the frames of a scan fit its sequence, its scanner and each other.");
}

}  // namespace

void warn_of(const std::string& name, const std::vector<std::string>& lines) {
  for (const std::string& line : lines) {
    const std::string text = name.empty() ? line : name + ": " + line;
    if (PyErr_WarnEx(PyExc_UserWarning, text.c_str(), 1) != 0) throw py::error_already_set();
  }
}

void refuse_or_warn(const CheckedScan& checked, const std::string& name, bool anyway) {
  if (!anyway) require_right(checked, name);
  std::vector<std::string> lines;
  for (const Finding& finding : checked.findings) lines.push_back(text_of(finding));
  warn_of(name, lines);
  warn_of(name, checked.repairs);
}

Scan checked_scan(const py::handle& given, bool of_gamma) {
  const bool loaded = !py::isinstance<Scan>(given);
  const std::string name = loaded ? py::str(given).cast<std::string>() : "scan";
  Scan scan;
  if (!loaded) scan = given.cast<const Scan&>();
  const auto path = loaded ? given.cast<fs::path>() : fs::path();
  CheckedScan checked;
  {
    const py::gil_scoped_release release;
    if (loaded) scan = load_frames(scan_files_in(path));
    checked = check_and_repair(scan);
  }
  if (loaded) warn_of(name, scan.warnings);
  if (of_gamma) checked.findings = without_cause(std::move(checked.findings), gamma_is_to_blame);
  refuse_or_warn(checked, name, false);
  return scan;
}

void bind_scans(py::module_& module) {
  bind_frames(module);
  py::class_<Scan, std::shared_ptr<Scan>>(module, "Scan",
                                          "Frames, what they show, and what took them.")
      .def(py::init(&scan_from), py::arg("frames"), py::arg("sequence"),
           py::arg("scanner") = py::none(), py::kw_only(), py::arg("bits") = py::none(),
           "Of a copy of frames; several exposures are merged.")
      .def_readonly("frames", &Scan::frames)
      .def_readonly("sequence", &Scan::sequence)
      .def_readwrite("scanner", &Scan::scanner, "None where it is not known.")
      .def_readonly("exposures", &Scan::exposures, "That were merged to these frames.")
      .def_readonly("other_axis", &Scan::other_axis, "The scan along y of one along both axes.")
      .def_readonly("further_cameras", &Scan::further_cameras)
      .def_readonly("warnings", &Scan::warnings, "Of reading the frames, a line each.")
      .def(
          "save",
          [](const Scan& of, const fs::path& path) {
            save_scan(path, of.frames, of.sequence, of.scanner);
          },
          py::arg("path"), py::call_guard<py::gil_scoped_release>(),
          "Into a folder with scan.yaml, or a recording where the path ends in .slip.")
      .def("__repr__", [](const Scan& of) {
        return py::str("<slipstream.Scan {} of {}, {}, {}>")
            .format(of.frames.count(), text_of(of.frames.size()), label_of(of.sequence.strategy),
                    of.scanner ? "with scanner" : "without scanner");
      });
  module.def(
      "load_scan",
      [](const fs::path& path, const std::optional<Sequence>& sequence,
         const std::optional<std::variant<Scanner, fs::path>>& scanner, std::optional<int> bits,
         const std::string& order, std::optional<std::uint64_t> window) {
        Scan scan;
        {
          const py::gil_scoped_release release;
          scan = loaded_scan(path, sequence, scanner, bits, order, window);
        }
        warn_of("", scan.warnings);
        for (const Scan& further : scan.further_cameras) warn_of("", further.warnings);
        return scan;
      },
      py::arg("path"), py::arg("sequence") = py::none(), py::arg("scanner") = py::none(),
      py::kw_only(), py::arg("bits") = py::none(), py::arg("order") = "",
      py::arg("window") = py::none(),
      "The scan in a folder or a recording; what is given goes before what is said there.");
  bind_findings(module);
}

}  // namespace slipstream::python
