#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "python/bindings/bindings.h"
#include "python/bindings/given.h"
#include "slipstream/scan_job.h"

namespace slipstream::python {
namespace {

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

/// A text about a finding, with the module's names.
template <auto Text>
std::string in_words(const Finding& finding) {
  return with_keywords(Text(finding));
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
    const auto fields = item.cast<py::tuple>();
    finding.evidence.push_back({fields[0].cast<std::string>(), fields[1].cast<double>(),
                                fields[2].cast<std::string>(),
                                fields[3].cast<std::optional<double>>()});
  }
  for (const py::handle item : state[4]) {
    const auto fields = item.cast<py::tuple>();
    finding.causes.push_back(
        {static_cast<CauseKind>(fields[0].cast<int>()), fields[1].cast<std::string>()});
  }
  for (const py::handle item : state[5]) {
    const auto fields = item.cast<py::tuple>();
    Remedy remedy{fields[0].cast<std::string>()};
    for (const auto& [name, value] :
         fields[1].cast<std::vector<std::pair<std::string, std::string>>>()) {
      remedy.settings.push_back({name, value});
    }
    finding.remedies.push_back(std::move(remedy));
  }

  return finding;
}

std::vector<Finding> findings_of(Given<Scan> scan, double minimum_modulation, bool moving,
                                 const std::string& gamma) {
  ScanJobSettings settings;
  settings.gamma = gamma;
  settings.moving = moving;
  settings.reconstruct.minimum_modulation = minimum_modulation;
  return check(scan.value, settings).checked.findings;
}

void bind_check(py::module_& module) {
  module.def("check", &findings_of, "scan"_a, py::kw_only(), "minimum_modulation"_a = 15.,
             "moving"_a = false, "gamma"_a = "scanner", Unlocked(), R"(
      Checks whether the frames of a scan fit its sequence, its scanner, each other and its guard.

      Args:
          scan (Scan | str | PathLike): frames with their sequence and scanner, or their path.
          minimum_modulation (float): least modulation of a pixel, grey levels of 255.
          moving (bool): whether the scene moves.
          gamma (str): response correction: scanner (if present), blind (from the frames), none, or
              a gamma.

      Returns:
          list[Finding]

      Raises:
          Error: if gamma is unknown, or the scanner does not fit a scan that has a guard.

      Example:
          >>> slipstream.check(scan)
          []
  )");
}

}  // namespace

void bind_findings(py::module_& module) {
  py::class_<Finding> finding(module, "Finding", R"(
      A diagnostic of a scan check.

      Example:
          >>> [finding.what for finding in slipstream.check(scan)]
          []
  )");

  finding.def_property_readonly(
      "kind", [](const Finding& self) { return name_of(self.kind); },
      "str: stable identifier, see docs/reference/findings.md.");
  finding.def_property_readonly("what", in_words<&symptom_of>, "str: observation.");
  finding.def_property_readonly("likely", in_words<&causes_of>, "str: probable causes in words.");
  finding.def_property_readonly("causes", &cause_names, "list[str]: their identifiers.");
  finding.def_property_readonly("advice", in_words<&remedies_of>, "str: remedies in words.");
  finding.def_property_readonly("remedies", &remedies_as_settings,
                                "list[dict[str, str]]: the settings of each, empty if only a "
                                "person can do it.");
  finding.def_property_readonly(
      "wrong", [](const Finding& self) { return self.severity == Severity::wrong; },
      "bool: whether the scan is refused.");
  finding.def_property_readonly("evidence", &evidence_of,
                                "dict[str, float]: measured numbers by name.");
  finding.def_readonly("frames", &Finding::frames, "list[int]: those it is about, if only some.");

  finding.def("__str__", [](const Finding& self) { return with_keywords(text_of(self)); });
  finding.def(py::pickle(&state_of, &finding_of));

  bind_check(module);
}

}  // namespace slipstream::python
