#include "slipstream/accuracy/accuracy_report.h"

#include <cmath>
#include <cstdint>
#include <string_view>

#include <fmt/format.h>

#include "slipstream/error/error.h"
#include "slipstream/io/file.h"
#include "slipstream/io/plot_file.h"
#include "slipstream/io/preview.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view head = R"(<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>Accuracy</title><style>
body { font: 15px/1.4 sans-serif; color: #222; max-width: 62em; margin: 2em auto; padding: 0 1em }
table { border-collapse: collapse; margin: 1em 2em 1em 0; display: inline-table; vertical-align: top }
td, th { padding: .15em .7em; border-bottom: 1px solid #ddd; text-align: left; font-weight: normal }
th { color: #666 } td.n { text-align: right; font-variant-numeric: tabular-nums }
figure { display: inline-block; width: 47%; margin: 0 1% 1em 0; vertical-align: top }
img { width: 100% } figcaption { color: #666 } h1, h2 { font-weight: normal }
@media print { body { font-size: 11px; margin: 0 } }
</style></head><body>
)";

std::string escaped(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (c == '<' || c == '>' || c == '&') {
      safe += fmt::format("&#{};", static_cast<int>(c));
    } else {
      safe += c;
    }
  }
  return safe;
}

std::string in_base_64(const std::vector<std::uint8_t>& bytes) {
  constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = i; k < i + 3; ++k) three = three << 8 | (k < bytes.size() ? bytes[k] : 0U);
    for (std::size_t k = 0; k < 4; ++k) {
      text += i + k > bytes.size() ? '=' : digits[three >> (18 - 6 * k) & 63];
    }
  }
  return text;
}

std::string row(std::string_view first, std::initializer_list<std::string> numbers) {
  std::string text = fmt::format("<tr><td>{}</td>", first);
  for (const std::string& number : numbers) text += fmt::format("<td class=\"n\">{}</td>", number);
  return text + "</tr>\n";
}

std::string table(std::string_view headings, const std::string& rows) {
  std::string text = "<table><tr>";
  for (std::size_t from = 0; from <= headings.size();) {
    const std::size_t to = std::min(headings.find('|', from), headings.size());
    text += fmt::format("<th>{}</th>", headings.substr(from, to - from));
    from = to + 1;
  }
  return rows.empty() ? "" : text + "</tr>\n" + rows + "</table>\n";
}

std::string text_of(double number, int digits) {
  return std::isnan(number) ? "" : fmt::format("{:.{}f}", number, digits);
}

std::string table_of_figures(const Accuracy& accuracy, const Artefacts& artefacts) {
  std::string rows;
  for (const AccuracyFigure& figure : accuracy_figures(accuracy, artefacts)) {
    rows += row(figure.what, {text_of(figure.millimetres, 4), text_of(1000 * figure.share, 3)});
  }
  if (const auto scale = scale_error(accuracy, artefacts)) {
    rows += row("dimension trueness: mean of spacing errors over distance",
                {fmt::format("{:+.4f} %", 100 * *scale), ""});
  }
  return table("worst position|mm|‰ of the diagonal", rows);
}

std::string table_of_spheres(const Accuracy& accuracy) {
  std::string rows;
  for (const SpheresAccuracy& position : accuracy.spheres) {
    std::string form, size;
    for (const SphereAccuracy& sphere : position.spheres) {
      form += fmt::format("{}{:.3f}", form.empty() ? "" : " / ", sphere.form.range);
      size += fmt::format("{}{:+.4f}", size.empty() ? "" : " / ", sphere.size);
    }
    const std::string spacing = position.spacing ? fmt::format("{:+.4f}", *position.spacing) : "";
    rows += row(escaped(position.scan), {form, size, spacing});
  }
  return table("spheres, mm|form|size|spacing", rows);
}

std::string table_of_planes(const Accuracy& accuracy) {
  std::string rows;
  for (const PlaneAccuracy& plane : accuracy.planes) {
    rows +=
        row(escaped(plane.scan), {text_of(plane.form.range, 3), text_of(plane.form.dispersion, 3),
                                  text_of(plane.form.rms, 4), text_of(plane.bending, 4)});
  }
  return table("planes, mm|99.7 %|95 %|RMS|bending", rows);
}

std::string figure(const std::vector<std::uint8_t>& png, const std::string& caption) {
  return fmt::format(
      "<figure><img alt=\"\" "
      "src=\"data:image/png;base64,{}\"><figcaption>{}</figcaption></figure>\n",
      in_base_64(png), escaped(caption));
}

LinePlot plot_by_position(const Accuracy& accuracy) {
  LinePlot plot;
  plot.title = "Errors of size and spacing";
  plot.x_label = "position";
  plot.y_label = "mm";
  for (const char* label : {"size of the first sphere", "size of the second", "sphere spacing"}) {
    plot.lines.push_back({label, {}, {}});
  }
  for (std::size_t i = 0; i < accuracy.spheres.size(); ++i) {
    const SpheresAccuracy& position = accuracy.spheres[i];
    const auto add = [&](PlotLine& line, double value) {
      line.x.push_back(static_cast<double>(i + 1));
      line.y.push_back(value);
    };
    for (std::size_t k = 0; k < position.spheres.size(); ++k) {
      add(plot.lines[k], position.spheres[k].size);
    }
    if (position.spacing) add(plot.lines[2], *position.spacing);
  }
  std::erase_if(plot.lines, [](const PlotLine& line) { return line.x.empty(); });
  return plot;
}

std::string pictures(const Accuracy& accuracy) {
  std::string text;
  if (!accuracy.spheres.empty()) {
    text += figure(plot_png(plot_by_position(accuracy)), "spheres, position by position") +
            figure(map_png(accuracy.worst_spheres.deviation, "mm"),
                   "deviations from the fitted spheres: " + accuracy.worst_spheres.scan);
  }
  if (!accuracy.planes.empty()) {
    text += figure(map_png(accuracy.worst_plane.deviation, "mm"),
                   "deviations from the fitted plane: " + accuracy.worst_plane.scan);
  }
  if (accuracy.repeated) {
    text += figure(map_png(accuracy.repeat_sigma, "mm"),
                   fmt::format("standard deviation of Z over {} scans", accuracy.repeated->scans));
  }
  return text;
}

}  // namespace

void write_accuracy_report(const fs::path& path, const std::string& subject,
                           const Accuracy& accuracy, const Artefacts& artefacts) {
  if (lower_case_extension(path) != ".html") {
    throw Error(fmt::format("{}: the report is HTML; use the ending .html", path.string()));
  }
  const std::string diagonal =
      artefacts.diagonal
          ? fmt::format(" Diagonal of the measured volume: {:.0f} mm.", *artefacts.diagonal)
          : "";
  write_file(
      path, fmt::format("{}<h1>Accuracy</h1>\n<p>{}.{}</p>\n{}<h2>Positions</h2>\n{}{}{}"
                        "</body></html>\n",
                        head, escaped(subject), diagonal, table_of_figures(accuracy, artefacts),
                        table_of_spheres(accuracy), table_of_planes(accuracy), pictures(accuracy)));
}

}  // namespace slipstream
