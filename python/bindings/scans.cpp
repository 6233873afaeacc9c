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
#include <variant>
#include <vector>

#include "base/throw_if-inl.h"
#include "python/bindings/arguments.h"
#include "simulate/virtual_files.h"
#include "slipstream/gamma.h"
#include "slipstream/named_scenes.h"
#include "slipstream/recording.h"
#include "slipstream/scan_files.h"
#include "slipstream/virtual_world.h"

namespace slipstream::python {
namespace {

FrameSet copied(const FrameViews& frames) {
  return frames.visit([&]<class Pixel>(const Frames<Pixel>& views) {
    std::vector<Image<Pixel>> images;
    for (const ImageView<const Pixel>& view : views) {
      images.emplace_back(view.size());
      for (int row = 0; row < view.height(); ++row) {
        std::copy_n(view.row(row), view.width(), images.back().row(row));
      }
    }

    return FrameSet(std::move(images), frames.bits());
  });
}

Scan scan_from(const py::object& frames, const Sequence& sequence,
               const std::optional<Scanner>& scanner, std::optional<int> bits) {
  const BorrowedFrames given = borrowed(frames, bits);

  throw_if(given.views.count() != frame_count(sequence), "a scan of {} frames is given {}",
           frame_count(sequence), given.views.count());

  Scan scan{.frames = copied(given.views), .sequence = sequence};
  if (scanner)
    scan.scanner = completed(*scanner, "scanner", scan.frames.size(), sequence.projector);

  scan.exposures = sequence.exposures;
  return merged(std::move(scan));
}

using AnyScanner = std::optional<std::variant<Scanner, fs::path>>;

/// Given values override those of the folder or the recording.
Scan loaded_scan(const fs::path& path, const std::optional<Sequence>& sequence,
                 const AnyScanner& scanner, std::optional<int> bits, const std::string& order,
                 std::optional<std::uint64_t> window) {
  // 1. Overrides; a scanner may be a file or an object.
  ScanChanges changes{.order = order, .window = window, .bits = bits};
  if (sequence) changes.sequence = changes_to(*sequence);
  if (scanner && scanner->index() == 1) changes.scanner = std::get<fs::path>(*scanner);

  // 2. Reads the scan without the interpreter's lock.
  const py::gil_scoped_release release;
  Scan scan = load_scan(path, changes);

  if (scanner && scanner->index() == 0) {
    scan.scanner = completed(std::get<Scanner>(*scanner), "scanner", scan.frames.size(),
                             scan.sequence.projector);
    scan.sequence.projector = scan.scanner->projector.size;
  }

  // 3. Warns, which needs the lock again.
  const py::gil_scoped_acquire acquire;
  warn_of("", scan.warnings);
  for (const Scan& further : scan.further_cameras) warn_of("", further.warnings);

  return scan;
}

std::vector<Finding> findings_of(Scan scan, double minimum_modulation, bool moving,
                                 const std::string& gamma) {
  CheckSettings settings{.minimum_modulation = minimum_modulation, .moving = moving};

  // With the response, and with its estimate if gamma is measured in this scan itself.
  const GammaChoice choice = choose_response(scan, gamma);
  settings.photometry.response = choice.response;
  settings.blind = choice.blind;

  return check_and_repair(scan, settings).findings;
}

py::object frame_at(const py::object& self, int n) {
  const FrameViews frames = self.cast<const FrameSet&>().views();

  // Negative indices count from the end, as in Python's lists.
  const int place = n < 0 ? n + frames.count() : n;
  if (place < 0 || place >= frames.count()) throw py::index_error("frame index out of range");

  return frames.visit(
      [&](const auto& views) { return array_of(views[static_cast<std::size_t>(place)], self); });
}

/// The measured numbers by name and unit.
py::dict evidence_of(const Finding& finding) {
  py::dict numbers;
  for (const Evidence& evidence : finding.evidence) {
    numbers[py::str(name_with_unit(evidence))] = evidence.value;
  }
  return numbers;
}

/// The settings of each remedy by name; an empty dict for one that only a person can do.
py::list remedies_as_settings(const Finding& finding) {
  py::list remedies;

  for (const Remedy& remedy : finding.remedies) {
    py::dict settings;
    for (const auto& [name, value] : remedy.settings) settings[py::str(name)] = value;
    remedies.append(settings);
  }

  return remedies;
}

std::vector<std::string_view> cause_names(const Finding& finding) {
  std::vector<std::string_view> names;
  for (const Cause& cause : finding.causes) names.push_back(name_of(cause.kind));
  return names;
}

/// All members, for pickling: a refused scan's error must survive a process pool.
py::tuple state_of(const Finding& finding) {
  py::list evidence, causes, remedies;

  for (const auto& [name, value, unit, limit] : finding.evidence) {
    evidence.append(py::make_tuple(name, value, unit, limit));
  }
  for (const auto& [kind, text] : finding.causes) {
    causes.append(py::make_tuple(static_cast<int>(kind), text));
  }
  for (const auto& [text, settings] : finding.remedies) {
    py::list changes;
    for (const auto& [name, value] : settings) changes.append(py::make_tuple(name, value));
    remedies.append(py::make_tuple(text, changes));
  }

  return py::make_tuple(static_cast<int>(finding.kind), static_cast<int>(finding.severity),
                        finding.what, evidence, causes, remedies, finding.remark, finding.subject,
                        finding.frames);
}

Finding finding_of(const py::tuple& state) {
  Finding finding{.kind = static_cast<FindingKind>(state[0].cast<int>()),
                  .severity = static_cast<Severity>(state[1].cast<int>()),
                  .what = state[2].cast<std::string>()};
  finding.remark = state[6].cast<std::string>();
  finding.subject = state[7].cast<std::string>();
  finding.frames = state[8].cast<std::vector<int>>();

  for (const py::handle item : state[3]) {
    const auto of = item.cast<py::tuple>();
    finding.evidence.push_back({of[0].cast<std::string>(), of[1].cast<double>(),
                                of[2].cast<std::string>(), of[3].cast<std::optional<double>>()});
  }
  for (const py::handle item : state[4]) {
    const auto of = item.cast<py::tuple>();
    finding.causes.push_back(
        {static_cast<CauseKind>(of[0].cast<int>()), of[1].cast<std::string>()});
  }
  for (const py::handle item : state[5]) {
    const auto of = item.cast<py::tuple>();
    Remedy remedy{of[0].cast<std::string>()};
    for (const auto& [name, value] :
         of[1].cast<std::vector<std::pair<std::string, std::string>>>()) {
      remedy.settings.push_back({name, value});
    }
    finding.remedies.push_back(std::move(remedy));
  }

  return finding;
}

void bind_findings(py::module_& module) {
  py::class_<Finding> finding(module, "Finding");
  add(
      finding, "kind", [](const Finding& of) { return name_of(of.kind); }, "what", &symptom_of,
      "likely", &causes_of, "causes", &cause_names, "advice", &remedies_of, "remedies",
      &remedies_as_settings, "wrong",
      [](const Finding& of) { return of.severity == Severity::wrong; }, "evidence", &evidence_of,
      "frames", &Finding::frames);

  finding.def("__str__", [](const Finding& of) { return text_of(of); });
  finding.def(py::pickle(&state_of, &finding_of));

  module.def("check", &findings_of, "scan"_a, py::kw_only(), "minimum_modulation"_a = 15.,
             "moving"_a = false, "gamma"_a = "scanner", Unlocked());
}

/// None if the frame is damaged.
py::object recorded_frame(const RecordingReader& of, std::uint64_t n) {
  if (n >= of.count()) throw py::index_error("frame index out of range");

  Frame frame;
  if (!unlocked([&] { return of.read(n, frame); })) return py::none();

  const FrameStamp& stamp = frame.stamp;
  py::array pixels =
      std::visit([](auto& image) { return array_from(std::move(image)); }, frame.pixels);
  pixels.attr("flags").attr("writeable") = false;

  return results("pixels"_a = pixels, "bits"_a = frame.bits, "sequence"_a = stamp.sequence,
                 "pattern_index"_a = stamp.pattern_index,
                 "device_time"_a = std::chrono::duration<double>(stamp.device_time).count());
}

py::object simulated(Sequence sequence, const std::optional<fs::path>& path,
                     const py::kwargs& given) {
  // 1. The virtual world, whose projector must be the sequence's.
  Keywords keywords(given);
  const VirtualWorld world = world_from(keywords);
  keywords.require_none_left();

  const Size projector = world.scanner.projector.size;
  if (sequence.projector == Size{}) sequence.projector = projector;
  if (sequence.projector != projector) throw Error("the sequence belongs to another projector");

  // 2. Renders the frames.
  VirtualScan taken = unlocked([&] {
    require_shown(sequence);
    VirtualScan made =
        take_scan(world.scanner, world.scene, pattern_set(sequence), world.photometry);
    if (path) save_virtual_scan(*path, sequence, world, made);
    return made;
  });

  // 3. The scan and its ground truth.
  Scan scan = merged({.frames = std::move(taken.frames),
                      .sequence = sequence,
                      .scanner = as_calibrated(world),
                      .exposures = sequence.exposures});

  return results("scan"_a = std::move(scan), "depth"_a = array_from(std::move(taken.depth)),
                 "coordinate"_a = array_from(std::move(taken.coordinate)),
                 "reflectivity"_a = array_from(std::move(taken.reflectivity)));
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

  for (const Finding& finding : checked.findings) warn_of(name, {text_of(finding)});
  warn_of(name, checked.repairs);
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
  py::class_<FrameSet> frames(module, "Frames");
  frames.def("__len__", &FrameSet::count).def("__getitem__", &frame_at);
  add(frames, "bits", &FrameSet::bits, "size", &FrameSet::size);

  py::class_<Scan, std::shared_ptr<Scan>> scan(module, "Scan");
  scan.def(py::init(&scan_from), "frames"_a, "sequence"_a, "scanner"_a = py::none(), py::kw_only(),
           "bits"_a = py::none());

  scan.def_property(  // never removed: Python may hold it
      "scanner", [](const Scan& of) { return of.scanner ? &*of.scanner : nullptr; },
      [](Scan& of, const Scanner& scanner) { of.scanner = scanner; });

  add(scan, "frames", &Scan::frames, "sequence", &Scan::sequence, "exposures", &Scan::exposures,
      "other_axis", &Scan::other_axis, "further_cameras", &Scan::further_cameras, "warnings",
      &Scan::warnings);

  scan.def(
      "save",
      [](const Scan& of, const fs::path& path) {
        save_scan(path, of.frames, of.sequence, of.scanner);
      },
      "path"_a, Unlocked());

  module.def("load_scan", &loaded_scan, "path"_a, "sequence"_a = py::none(),
             "scanner"_a = py::none(), py::kw_only(), "bits"_a = py::none(), "order"_a = "",
             "window"_a = py::none());

  bind_findings(module);

  py::class_<RecordingReader> recording(module, "Recording");
  recording.def(py::init<const fs::path&>(), "path"_a, Unlocked());
  recording.def("__len__", &RecordingReader::count).def("__getitem__", &recorded_frame);

  const auto in_header = [](auto member) {
    return [member](const RecordingReader& of) { return of.header().*member; };
  };

  add(recording, "finished", &RecordingReader::finished, "sequence",
      in_header(&RecordingHeader::sequence), "scanner", in_header(&RecordingHeader::scanner),
      "frame_rate", in_header(&RecordingHeader::frame_rate), "in_colour",
      in_header(&RecordingHeader::in_colour));
}

VirtualWorld world_from(Keywords& keywords) {
  WorldSettings of;
  std::optional<MeasuredResponse> response;
  std::array<double, 3> step{};
  double turn = 0;

  keywords.take("scene", of.scene, "mesh", of.mesh, "scanner", of.scanner, "camera", of.camera,
                "step", step, "turn", turn, "world", of.world, "response", response);
  take_described(keywords, of);

  if (response) of.response = response->response;

  // The motion between frames: a step in mm and a turn about the y axis, given in degrees.
  of.motion.step = Eigen::Vector3d(step.data());
  of.motion.turn.y() = turn * std::numbers::pi / 180;

  return virtual_world(of);
}

void bind_virtual_world(py::module_& module) {
  module.def("simulate", &simulated, "sequence"_a, "path"_a = py::none());
  module.def("scene_names", &scene_names);
  module.def("world_names", &world_names);
}

}  // namespace slipstream::python
