#include "python/bindings/scans.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "frames/copied_frames.h"
#include "io/file.h"
#include "io/scan_folder.h"
#include "io/scan_scanner.h"
#include "python/bindings/arguments.h"
#include "python/bindings/bindings.h"
#include "python/bindings/given.h"
#include "simulate/virtual_files.h"
#include "slipstream/gamma.h"
#include "slipstream/named_scenes.h"
#include "slipstream/recording.h"
#include "slipstream/scan_files.h"
#include "slipstream/virtual_world.h"

namespace slipstream::python {
namespace {

/// The scanner must fit the frames and the sequence; its projector is the sequence's.
void set_scanner(Scan& scan, const Given<Scanner>& scanner) {
  require_upright(scan.frames.size(), scanner.value.camera.size);
  scan.scanner =
      completed(scanner.value, scanner.name, scan.frames.size(), scan.sequence.projector);
  scan.sequence.projector = scan.scanner->projector.size;
}

Scan scan_from(const py::object& frames, const Given<Sequence>& patterns,
               const std::optional<Given<Scanner>>& scanner, std::optional<int> bits) {
  const Sequence& sequence = patterns.value;
  const BorrowedFrames given = borrowed(frames, bits, frame_count(sequence));

  throw_if(given.views.count() != frame_count(sequence), "a scan of {} frames is given {}",
           frame_count(sequence), given.views.count());

  Scan scan{.frames = copied(given.views), .sequence = sequence};
  if (scanner) set_scanner(scan, *scanner);

  scan.exposures = sequence.exposures;
  return merged(std::move(scan));
}

/// Left, top, width and height, or a text as messages have it: "640x480+16+8".
using CameraRegion = std::variant<std::array<int, 4>, std::string>;
using AnyScanner = std::optional<std::variant<Scanner, fs::path>>;

Rectangle rectangle_of(const CameraRegion& region) {
  if (region.index() == 0) {
    const auto [left, top, width, height] = std::get<0>(region);
    return {left, top, {width, height}};
  }

  const auto& text = std::get<std::string>(region);
  const std::optional<Rectangle> found = rectangle_of_text(text);
  throw_if(!found, "camera_region '{}': expected width x height + left + top, e.g. 640x480+16+8",
           text);
  return *found;
}

/// Given values override those of the folder or the recording.
Scan loaded_scan(const fs::path& path, const std::optional<Given<Sequence>>& sequence,
                 const AnyScanner& scanner, std::optional<int> bits, const std::string& order,
                 std::optional<std::uint64_t> window, const std::string& channel,
                 const std::string& mosaic, const std::optional<CameraRegion>& camera_region,
                 const std::optional<fs::path>& second_camera,
                 const std::optional<fs::path>& second_scanner) {
  // 1. Overrides; a scanner may be a file or an object.
  ScanChanges changes{.order = order,
                      .window = window,
                      .bits = bits,
                      .channel = grey_channel_named(channel),
                      .mosaic = mosaic};
  if (second_camera) changes.further_cameras = {*second_camera};
  if (second_scanner) changes.further_scanners = {*second_scanner};
  if (camera_region) changes.camera_region = rectangle_of(*camera_region);
  if (sequence) changes.sequence = changes_to(sequence->value);
  if (scanner && scanner->index() == 1) changes.scanner = std::get<fs::path>(*scanner);

  // 2. Reads the scan without the interpreter's lock.
  const py::gil_scoped_release release;
  Scan scan = load_scan(path, changes);

  if (scanner && scanner->index() == 0) {
    const Scanner& given = std::get<Scanner>(*scanner);
    if (!changes.camera_region) require_upright(scan.frames.size(), given.camera.size);

    // As of a scanner file: the pictures may be a part, or join pixels.
    ScanFiles files;
    files.sequence = scan.sequence;
    files.scanner = "scanner";
    files.camera_region = changes.camera_region;
    add_scanner(scan, given, files);
  }

  // 3. Warns, which needs the lock again.
  const py::gil_scoped_acquire acquire;
  warn_of_files(scan);
  return scan;
}

/// The frames as they were shown, those along y after those along x, and their sequence.
std::pair<FrameViews, Sequence> as_shown(const Scan& scan) {
  if (scan.other_axis.empty()) return {scan.frames.views(), scan.sequence};

  const FrameViews other = scan.other_axis.front().frames.views();
  Sequence both = scan.sequence;
  both.both_axes = true;

  const FrameViews frames =
      scan.frames.visit([&]<class Pixel>(const Frames<Pixel>& along_x) -> FrameViews {
        Frames<Pixel> all = along_x;
        other.visit([&]<class Other>(const Frames<Other>& along_y) {
          // Both axes have pixels of the same type.
          if constexpr (std::is_same_v<Pixel, Other>) {
            all.insert(all.end(), along_y.begin(), along_y.end());
          }
        });
        return {all, scan.frames.bits()};
      });

  return {frames, both};
}

/// Also the other axis, the guard and further cameras.
void save(const Scan& scan, const fs::path& path) {
  throw_if(
      scan.exposures.size() > 1,
      "{}: frames merged of {} exposures cannot be written as captured; copy the original scan",
      path.string(), scan.exposures.size());
  throw_if(scan.camera_pair.has_value(),
           "{}: a calibration of two cameras is not written; copy the original scan",
           path.string());
  throw_if(!scan.further_cameras.empty() && lower_case_extension(path) == ".slip",
           "{}: a recording holds one camera; save a scan of several to a folder", path.string());
  throw_if(!scan.guard.empty() && lower_case_extension(path) == ".slip",
           "{}: a recording holds no guard; save the scan to a folder", path.string());

  const auto [frames, sequence] = as_shown(scan);
  ScanFiles files = save_scan(path, frames, sequence, {.scanner = scan.scanner});
  if (!scan.guard.empty()) {
    save_guard(files, scan.guard.front().frames, scan.guard.front().sequence);
  }
  if (scan.further_cameras.empty()) return;

  for (std::size_t i = 0; i < scan.further_cameras.size(); ++i) {
    files.further_cameras.push_back(path / folder_of_camera(i + 2));
    save(scan.further_cameras[i], files.further_cameras.back());
  }
  write_scan_files(path / "scan.yaml", files);
}

py::object frame_at(const py::object& self, int n) {
  const FrameViews frames = self.cast<const FrameSet&>().views();

  // Negative indices count from the end, as in Python's lists.
  const int place = n < 0 ? n + frames.count() : n;
  if (place < 0 || place >= frames.count()) throw py::index_error("frame index out of range");

  return frames.visit(
      [&](const auto& views) { return array_of(views[static_cast<std::size_t>(place)], self); });
}

/// None if the frame is damaged.
py::object recorded_frame(const RecordingReader& self, std::uint64_t n) {
  if (n >= self.count()) throw py::index_error("frame index out of range");

  Frame frame;
  if (!unlocked([&] { return self.read(n, frame); })) return py::none();

  const FrameStamp& stamp = frame.stamp;
  py::array pixels =
      std::visit([](auto& image) { return array_from(std::move(image)); }, frame.pixels);
  pixels.attr("flags").attr("writeable") = false;

  return results("pixels"_a = pixels, "bits"_a = frame.bits, "sequence"_a = stamp.sequence,
                 "pattern_index"_a = stamp.pattern_index,
                 "device_time"_a = std::chrono::duration<double>(stamp.device_time).count());
}

void bind_frames(py::module_& module) {
  py::class_<FrameSet> frames(module, "Frames", R"(
      The frames of a scan: read-only views, rows x columns.

      Functions that take frames also take one array, frames x rows x columns, or a list of arrays,
      rows x columns: uint8, uint16, or float64 and float32 in grey levels of 255. Pixels of a row
      are adjacent. Only float32 is copied.

      Example:
          >>> len(scan.frames), scan.frames[0].shape
          (6, (120, 160))
  )");

  frames.def("__len__", &FrameSet::count);
  frames.def("__getitem__", &frame_at, "n"_a);

  frames.def_property_readonly("bits", &FrameSet::bits, "int: bits per pixel.");
  frames.def_property_readonly("size", &FrameSet::size,
                               "tuple[int, int]: width and height, pixels.");
}

std::vector<std::string> warnings_of(const Scan& scan) {
  std::vector<std::string> warnings;
  for (const std::string& line : scan.warnings) warnings.push_back(with_keywords(line));
  return warnings;
}

void bind_scan(py::module_& module) {
  py::class_<Scan, std::shared_ptr<Scan>> scan(module, "Scan", R"(
      A copy of frames, their sequence, and their scanner if known; several exposures are merged.

      Args:
          frames (Frames | NDArray | typing.Sequence[NDArray]): see `Frames`; copied.
          sequence (Sequence | Strategy | str): pattern sequence, or its strategy along x.
          scanner (Scanner | str | PathLike | None): calibration, or its file; None if unknown.
          bits (int | None): bits per pixel; of uint16 frames by default 16.

      Raises:
          Error: if the number, size or type of the frames is wrong.

      Example:
          >>> slipstream.Scan(list(scan.frames), sequence, scan.scanner).frames.size
          (160, 120)
  )");

  scan.def(py::init(&scan_from), "frames"_a, "sequence"_a, "scanner"_a = py::none(), py::kw_only(),
           "bits"_a = py::none());

  scan.def_property(  // never removed: Python may hold it
      "scanner", [](const Scan& self) { return self.scanner ? &*self.scanner : nullptr; },
      &set_scanner, "Scanner | None: calibration; None if unknown.");
  scan.def_readonly("frames", &Scan::frames, "Frames: of the scan.");
  scan.def_readonly("sequence", &Scan::sequence, "Sequence: pattern sequence.");
  scan.def_readonly("exposures", &Scan::exposures, "list[float]: relative, any unit.");
  scan.def_readonly("other_axis", &Scan::other_axis,
                    "list[Scan]: the scan along y of one along both axes.");
  scan.def_readonly("guard", &Scan::guard,
                    "list[Scan]: frames along the other axis that show whether the rig has moved.");
  scan.def_readonly("further_cameras", &Scan::further_cameras,
                    "list[Scan]: scans by other cameras.");
  scan.def_property_readonly("warnings", &warnings_of, "list[str]: of the files.");

  scan.def("save", &save, "path"_a, Unlocked(), R"(
      Writes a folder with scan.yaml, or a recording; also the other axis, the guard and a second
      camera.

      Args:
          path (str | PathLike): folder, or recording of one camera if it ends in .slip.

      Raises:
          Error: if exposures were merged, or if it is a recording and the scan of two cameras or
              with a guard.
          WorldError: if it cannot be written.

      Example:
          >>> scan.save("scan")
  )");
}

void bind_scan_files(py::module_& module) {
  module.def("load_scan", &loaded_scan, "path"_a, "sequence"_a = py::none(),
             "scanner"_a = py::none(), py::kw_only(), "bits"_a = py::none(), "order"_a = "",
             "window"_a = py::none(), "channel"_a = "auto", "mosaic"_a = "",
             "camera_region"_a = py::none(), "second_camera"_a = py::none(),
             "second_scanner"_a = py::none(), R"(
      Loads a scan from a folder or a recording; arguments override its contents.

      Args:
          path (str | PathLike): folder or recording.
          sequence (Sequence | Strategy | str | None): pattern sequence, or its strategy along x.
          scanner (Scanner | str | PathLike | None): calibration, or its file.
          bits (int | None): bits per pixel; of uint16 frames by default 16.
          order (str): of the frames in the files.
          window (int | None): index of a recording's scan.
          channel (Literal["auto", "grey", "red", "green", "blue"]): grey levels of colour pictures;
              auto: the best.
          mosaic (str): of raw pictures of a colour camera, the colours of the first two pixels, as
              "RG", or its pixel format.
          camera_region (tuple[int, int, int, int] | str | None): the part of the calibrated picture
              that the frames show: left, top, width and height, pixels, or "640x480+16+8".
          second_camera (str | PathLike | None): folder or recording of a second camera.
          second_scanner (str | PathLike | None): its scanner file.

      Returns:
          Scan

      Raises:
          Error: if a file is missing or malformed, or its ending not supported.
          WorldError: if it cannot be read.

      Example:
          >>> scan.save("scan")
          >>> len(slipstream.load_scan("scan").frames)
          6
  )");
}

void bind_recording(py::module_& module) {
  py::class_<RecordingReader> recording(module, "Recording", R"(
      Raw frames in one file; recording[n] is None if damaged, and iteration skips it.

      A frame has `pixels` (rows x columns, read-only), `bits` per pixel, `sequence` (the device's
      count), `device_time` (s) and `pattern_index` (in the cycle; None if unknown).

      Args:
          path (str | PathLike): .slip.

      Raises:
          Error: if the file is missing or malformed.
          WorldError: if it cannot be read.

      Example:
          >>> scan.save("scan.slip")
          >>> slipstream.Recording("scan.slip")[2].pixels.shape
          (120, 160)
  )");

  recording.def(py::init<const fs::path&>(), "path"_a, Unlocked());
  recording.def("__len__", &RecordingReader::count);
  recording.def("__getitem__", &recorded_frame, "n"_a);

  const auto in_header = [](auto member) {
    return [member](const RecordingReader& self) { return self.header().*member; };
  };

  recording.def_property_readonly("finished", &RecordingReader::finished,
                                  "bool: whether its end was written.");
  recording.def_property_readonly("sequence", in_header(&RecordingHeader::sequence),
                                  "Sequence | None: pattern sequence.");
  recording.def_property_readonly("scanner", in_header(&RecordingHeader::scanner),
                                  "Scanner | None: calibration; None if unknown.");
  recording.def_property_readonly("frame_rate", in_header(&RecordingHeader::frame_rate),
                                  "float: frames per second.");
  recording.def_property_readonly("in_colour", in_header(&RecordingHeader::in_colour),
                                  "bool: three frames are the raw channels of one picture.");
}

}  // namespace

void warn_of(const std::string& name, const std::vector<std::string>& lines) {
  // The caller of the function of this module, which _arguments.py wraps.
  constexpr int stack_level = 2;

  for (const std::string& line : lines) {
    const std::string words = with_keywords(line);
    const std::string text = name.empty() ? words : name + ": " + words;
    if (PyErr_WarnEx(PyExc_UserWarning, text.c_str(), stack_level) != 0)
      throw py::error_already_set();
  }
}

void warn_of_files(const Scan& scan) {
  warn_of("", scan.warnings);
  for (const Scan& further : scan.further_cameras) warn_of("", further.warnings);
}

void refuse_or_warn(const CheckedScan& checked, const std::string& name, bool anyway) {
  if (!anyway) require_right(checked, name);

  for (const Finding& finding : checked.findings) warn_of(name, {text_of(finding)});
  warn_of(name, checked.repairs);
}

std::vector<py::object> each_scan(const py::object& scans) {
  if (py::isinstance<Scan>(scans) || is_path(scans)) return {scans};

  if (!py::isinstance<py::iterable>(scans)) {
    throw py::type_error(
        fmt::format("scans cannot be {}; expected Scans or their paths", shown(scans)));
  }

  std::vector<py::object> each;
  for (const py::handle scan : scans) {
    if (!py::isinstance<Scan>(scan) && !is_path(scan)) {
      throw py::type_error(
          fmt::format("scans cannot have {}; expected Scans or their paths", shown(scan)));
    }
    each.push_back(py::reinterpret_borrow<py::object>(scan));
  }
  return each;
}

std::pair<Scan, std::string> checked_scan(const py::handle& given, bool of_gamma) {
  const bool loaded = !py::isinstance<Scan>(given);
  std::pair<Scan, std::string> checked(loaded ? Scan{} : given.cast<Scan>(), "scan");
  auto& [scan, name] = checked;

  if (loaded) name = given.cast<fs::path>().string();

  CheckedScan found = unlocked([&] {
    if (loaded) scan = load_frames(scan_files_in(name));
    return check_and_repair(scan);
  });

  if (loaded) warn_of(name, scan.warnings);
  if (of_gamma) found.findings = without_cause(std::move(found.findings), CauseKind::gamma);

  refuse_or_warn(found, name, false);
  return checked;
}

void bind_scans(py::module_& module) {
  bind_frames(module);
  bind_scan(module);
  bind_scan_files(module);
  bind_recording(module);
}

}  // namespace slipstream::python
