#include "app/output.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <memory>

#include "app/process.h"
#include "base/printable.h"
#include "slipstream/error.h"

namespace slipstream {

void to_json(nlohmann::json& json, const Finding& finding) {
  json = {{"kind", name_of(finding.kind)},
          {"what", symptom_of(finding)},
          {"evidence", nlohmann::json::object()},
          {"quantities", nlohmann::json::array()},
          {"likely", causes_of(finding)},
          {"causes", nlohmann::json::array()},
          {"try", remedies_of(finding)},
          {"remedies", nlohmann::json::array()},
          {"refused", finding.severity == Severity::wrong}};
  if (!finding.subject.empty()) json["subject"] = finding.subject;
  if (!finding.frames.empty()) json["frames"] = finding.frames;

  for (const Evidence& evidence : finding.evidence) {
    json["evidence"][name_with_unit(evidence)] = evidence.value;

    nlohmann::json quantity = {{"name", evidence.name}, {"value", evidence.value}};
    if (!evidence.unit.empty()) quantity["unit"] = evidence.unit;
    if (evidence.limit) quantity["limit"] = *evidence.limit;
    json["quantities"].push_back(std::move(quantity));
  }

  for (const Cause& cause : finding.causes) {
    json["causes"].push_back({{"kind", name_of(cause.kind)}, {"text", cause.text}});
  }

  for (const Remedy& remedy : finding.remedies) {
    nlohmann::json settings = nlohmann::json::object();
    for (const auto& [name, value] : remedy.settings) settings[name] = value;
    json["remedies"].push_back({{"text", remedy.text}, {"settings", std::move(settings)}});
  }
}

void to_json(nlohmann::json& json, const EpipolarCheck& check) {
  json = {{"median_px", check.median},
          {"median_length_px", check.median_length},
          {"median_sigma_px", check.median_sigma},
          {"common_px", check.common},
          {"constant_px", check.constant},
          {"linear_px", check.linear},
          {"quadratic_px", check.quadratic},
          {"own_px", check.own},
          {"points", check.points},
          {"doubted", check.doubted}};
}

void to_json(nlohmann::json& json, const LiveFinding& finding) {
  json = finding.finding;
  json["begin"] = finding.begin;
  json["end"] = app::as_json(finding.end);
}

}  // namespace slipstream

namespace slipstream::app {
namespace {

std::atomic<bool> pipe_closed = false;  // of stdout or stderr

/// Whether an entry of a document holds names of files or devices, or settings as data.
bool holds_names(std::string_view name) {
  constexpr std::array<std::string_view, 14> names{
      "files", "file",   "folder",  "path",    "scan",     "source", "recording",
      "name",  "output", "scanner", "subject", "settings", "map",    "report"};
  return std::ranges::count(names, name) > 0;
}

}  // namespace

nlohmann::json document_with_flags(nlohmann::json document) {
  if (document.is_string()) return with_flags(document.get_ref<const std::string&>());
  if (document.is_array()) {
    for (nlohmann::json& element : document) element = document_with_flags(std::move(element));
  } else if (document.is_object()) {
    for (const auto& [name, value] : document.items()) {
      if (!holds_names(name)) value = document_with_flags(std::move(value));
    }
  }
  return document;
}

void Output::tell_verdict(std::string_view grade, const std::string& words) {
  say("{}", words);
  add("grade", grade, "verdict", words);
  if (grade == "bad") exit_code = 2;
}

void Output::tell_wait(std::string_view work) {
  if (holds_ || ::isatty(STDERR_FILENO) != 1) return;

  // The next line is written over it. The terminal cuts it at its width: a wrapped line would stay.
  fmt::print(stderr, "\033[?7l{} ...\033[K\033[?7h\r", printable(work));
  std::fflush(stderr);
  waits_ = true;
}

void Output::clear_wait() {
  if (std::exchange(waits_, false)) std::fputs("\033[K", stderr);
}

void Output::finish() {
  clear_wait();
  if (json_) {  // file names need not be UTF-8
    write_line(stdout, document_with_flags(document).dump(
                           2, ' ', true, nlohmann::json::error_handler_t::replace));
  }

  if (pipe_closed) end_by_closed_pipe();
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
    throw WorldError("cannot write to standard output");
}

void Output::write_line(std::FILE* stream, std::string_view line) {
  if (holds_) return static_cast<void>(held_.emplace_back(stream, line));
  clear_wait();

  // finish() reports a failed stdout; a failed stderr cannot be reported.
  const std::string shown = printable_lines(line) + '\n';
  const bool written = std::fwrite(shown.data(), 1, shown.size(), stream) == shown.size();
  if (!written && errno == EPIPE) pipe_closed = true;
  if (!written && pipe_closed && stream == stdout) end_by_closed_pipe();
}

void Progress::finish() {
  if (drawn_) std::fputs("\r\033[K", stderr);
  drawn_ = false;
}

void Progress::advance(bool already) {
  ++done_;
  if (already) ++done_before_;
  show();
}

void Progress::reach(std::int64_t done) {
  done_ = done;
  show();
}

void Progress::show() {
  const auto now = std::chrono::steady_clock::now();
  if (terminal_ && total_ > 1 && now - drawn_at_ > std::chrono::milliseconds(100)) draw();

  // Elsewhere one line, once it is known to take long.
  if (!terminal_ && !reported_ && done_ < total_ && now - start_ > std::chrono::seconds(1)) {
    reported_ = true;
    fmt::print(stderr, "{}: {} % done\n", label_, 100 * done_ / total_);
  }
}

std::function<void(double)> progress_of(std::string label) {
  constexpr int percent = 100;
  const auto progress = std::make_shared<Progress>(std::move(label), percent);

  return [progress](double share) {
    progress->reach(std::lround(percent * share));
    if (share >= 1) progress->finish();
  };
}

void Progress::draw() {
  constexpr int width = 30;
  drawn_ = true;
  drawn_at_ = std::chrono::steady_clock::now();

  const auto filled =
      static_cast<int>(width * static_cast<double>(done_) / static_cast<double>(total_));

  // Scans that were done before do not count towards the rate: they take no time.
  const std::chrono::duration<double> past = drawn_at_ - start_;
  const double rate = static_cast<double>(done_ - done_before_) / past.count();

  fmt::print(stderr, "\r\033[?7l{} [{:#<{}}{:.<{}}] {}/{}{}\033[K\033[?7h", label_, "", filled, "",
             width - filled, done_, total_,
             rate == 0 ? ""
                       : fmt::format(", {:.3g}/s, {:.0f} s left", rate,
                                     static_cast<double>(total_ - done_) / rate));
  std::fflush(stderr);
}

void refuse_or_warn(const CheckedScan& checked, const std::string& scan, bool anyway,
                    Output& output) {
  if (!anyway && any_wrong(checked.findings)) {
    output.document["findings"] = gravest_first(checked.findings);
    require_right(checked, scan);
  }

  warn_of_findings(checked.findings, 0, scan, output);
  for (const std::string& repair : checked.repairs) output.say("{}: {}", scan, repair);
}

void warn_of_findings(const std::vector<Finding>& findings, std::size_t first,
                      const std::string& scan, Output& output) {
  for (std::size_t i = first; i < findings.size(); ++i) {
    output.warn(fmt::format("{}: {}", scan, text_of(findings[i])));
  }
}

std::vector<std::string> remarks_about(const std::vector<Finding>& findings) {
  std::vector<std::string> remarks = doubts(findings);
  for (std::string& remark : remarks) remark = with_flags(remark);
  return remarks;
}

void tell_news(const std::vector<LiveFinding>& findings, std::vector<LiveFinding>& printed,
               Output& output) {
  // A diagnostic with the same begin was printed before; then only its end is news.
  for (const LiveFinding& now : findings) {
    const auto before = std::find_if(printed.begin(), printed.end(), [&](const LiveFinding& other) {
      return other.begin == now.begin && is_same(other.finding, now.finding);
    });

    if (before == printed.end()) output.warn(fmt::format("frames: {}", text_of(now.finding)));

    if (now.end && (before == printed.end() || !before->end)) {
      output.say("frames: {}: ended after {} frames", symptom_of(now.finding),
                 *now.end - now.begin);
    }
  }

  printed = findings;
}

nlohmann::json json_of(const Eigen::Isometry3d& pose) {
  nlohmann::json rows = nlohmann::json::array();
  for (const auto& row : pose.matrix().rowwise()) {
    rows.push_back(std::vector<double>(row.begin(), row.end()));
  }
  return rows;
}

nlohmann::json json_of(const FramePose& pose) {
  return described("from", pose.from, "to", pose.to, "matrix_mm", json_of(pose.transform));
}

bool tell_fallback(const std::string& reason, bool matters, Output& output) {
  if (reason.empty()) return false;

  if (matters) {
    output.warn(reason);
  } else {
    output.say("{}", reason);
  }
  return true;
}

}  // namespace slipstream::app
