#include "slipstream/accuracy/accuracy_report.h"

#include <algorithm>
#include <cstdint>
#include <string_view>

#include <fmt/format.h>

#include "slipstream/io/file.h"
#include "slipstream/io/preview.h"

namespace slipstream {
namespace {

constexpr std::string_view head = R"(<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>Accuracy</title><style>
body { font: 15px/1.4 sans-serif; color: #222; max-width: 62em; margin: 2em auto; padding: 0 1em }
h1, h2, th { font-weight: normal } th, figcaption { color: #666 } table { border-collapse: collapse }
td, th { padding: .1em .8em; border-bottom: 1px solid #ddd; text-align: right }
td:first-child, th:first-child { text-align: left } td { font-variant-numeric: tabular-nums }
figure { display: inline-block; width: 31%; margin: 1em 1% 0 0; vertical-align: top }
img { width: 100%; image-rendering: pixelated } @media print { body { font-size: 11px; margin: 0 } }
</style></head><body>
)";

std::string escaped(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    const bool is_markup = c == '<' || c == '>' || c == '&';
    safe += is_markup ? fmt::format("&#{};", static_cast<int>(c)) : std::string(1, c);
  }
  return safe;
}

std::string in_base_64(std::vector<std::uint8_t> bytes) {
  constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const std::size_t padding = (3 - bytes.size() % 3) % 3;
  bytes.resize(bytes.size() + padding);
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const int three = bytes[i] << 16 | bytes[i + 1] << 8 | bytes[i + 2];
    for (const int shift : {18, 12, 6, 0})
      text += digits[static_cast<std::size_t>(three >> shift & 63)];
  }
  std::fill(text.end() - static_cast<std::ptrdiff_t>(padding), text.end(), '=');
  return text;
}

/// Cells of a row; no value is an empty cell.
std::string row(const std::string& first, std::initializer_list<std::optional<double>> values) {
  std::string text = "<tr><td>" + escaped(first) + "</td>";
  for (const std::optional<double>& value : values) {
    text += value ? fmt::format("<td>{:.4f}</td>", *value) : "<td></td>";
  }
  return text + "</tr>\n";
}

std::string table_of_figures(const Accuracy& accuracy, std::optional<double> diagonal) {
  std::string text =
      "<table><tr><th>worst position</th><th>mm</th><th>‰ of the diagonal</th></tr>\n";
  for (const AccuracyFigure& figure : accuracy_figures(accuracy)) {
    std::optional<double> share;
    if (diagonal) share = 1000 * figure.value / *diagonal;
    text += row(std::string(figure.what), {figure.value, share});
  }
  return text + "</table>\n";
}

std::string table_of_shapes(const Accuracy& accuracy) {
  std::string text =
      "<h2>Spheres and planes, mm</h2>\n<table><tr><th></th><th>99.7 %</th><th>95 %</th>"
      "<th>RMS</th><th>size</th><th>spacing</th><th>planarity</th></tr>\n";
  for (const ShapeAccuracy& shape : accuracy.shapes) {
    text += row(shape.scan,
                {shape.range, shape.range_95, shape.rms, shape.size, shape.spacing, shape.bending});
  }
  return text + "</table>\n";
}

std::string picture(const Image<double>& map, const std::string& caption) {
  return fmt::format(
      "<figure><img alt=\"\" "
      "src=\"data:image/png;base64,{}\"><figcaption>{}</figcaption></figure>\n",
      in_base_64(map_png(map, "mm")), escaped(caption));
}

/// Of the sphere and the plane of largest form error, and of the repeated scans.
std::string pictures(const Accuracy& accuracy) {
  const ShapeAccuracy *sphere = nullptr, *plane = nullptr;
  for (const ShapeAccuracy& shape : accuracy.shapes) {
    const ShapeAccuracy*& worst = shape.size ? sphere : plane;
    if (worst == nullptr || shape.range > worst->range) worst = &shape;
  }
  std::string text;
  for (const ShapeAccuracy* const shape : {sphere, plane}) {
    if (shape != nullptr) text += picture(shape->deviation, "deviations: " + shape->scan);
  }
  if (accuracy.repeated) {
    text += picture(accuracy.repeated->sigma,
                    fmt::format("sigma of Z over {} scans", accuracy.repeated->scans));
  }
  return text;
}

}  // namespace

void write_accuracy_report(const std::filesystem::path& path, const std::string& subject,
                           const Accuracy& accuracy, std::optional<double> diagonal) {
  const std::string volume =
      diagonal ? fmt::format("; diagonal of the measured volume {:.0f} mm", *diagonal) : "";
  write_file(path, fmt::format("{}<h1>Accuracy</h1>\n<p>{}{}</p>\n{}{}{}</body></html>\n", head,
                               escaped(subject), volume, table_of_figures(accuracy, diagonal),
                               table_of_shapes(accuracy), pictures(accuracy)));
}

}  // namespace slipstream
