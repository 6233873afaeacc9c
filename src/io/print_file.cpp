#include "io/print_file.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "base/numbers.h"
#include "io/compressed_pictures.h"
#include "io/file.h"
#include "io/image_file.h"

namespace slipstream {
namespace {

/// From the page's upper left corner, mm.
struct DarkRectangle {
  double left = 0, top = 0, width = 0, height = 0;
};

/// A page, mm.
struct Sheet {
  double width = 0, height = 0;
  std::vector<DarkRectangle> black{};
  double words_left = 0, words_base = 0;
  std::string words{};
};

/// Runs of dark pixels; equal runs in consecutive rows are one rectangle.
std::vector<DarkRectangle> dark_rectangles(const Image<std::uint8_t>& picture,
                                           double mm_per_pixel) {
  std::vector<DarkRectangle> rectangles;
  std::map<std::pair<int, int>, int> open;  // first row by first and end column

  // One row more than the picture has, without runs, closes the last rectangles.
  for (int row = 0; row <= picture.height(); ++row) {
    std::map<std::pair<int, int>, int> runs;
    for (int column = 0; row < picture.height() && column < picture.width(); ++column) {
      if (picture(column, row) >= 128) continue;

      const int first = column;
      while (column < picture.width() && picture(column, row) < 128) ++column;

      // A run that was also in the row before continues its rectangle.
      const auto before = open.find({first, column});
      runs[{first, column}] = before == open.end() ? row : before->second;
    }

    for (const auto& [run, top] : open) {
      const auto still = runs.find(run);
      if (still != runs.end() && still->second == top) continue;

      rectangles.push_back({run.first * mm_per_pixel, top * mm_per_pixel,
                            (run.second - run.first) * mm_per_pixel, (row - top) * mm_per_pixel});
    }

    open = std::move(runs);
  }

  return rectangles;
}

Sheet sheet_of(const Image<std::uint8_t>& picture, double mm_per_pixel) {
  // mm: the strip below the picture that holds the ruler, and the thickness of its lines.
  constexpr double strip = 12, thickness = 0.25;

  const double top = picture.height() * mm_per_pixel;
  Sheet sheet{.width = picture.width() * mm_per_pixel,
              .height = top + strip,
              .black = dark_rectangles(picture, mm_per_pixel)};

  // The ruler: as many whole centimetres as the width allows beside the words.
  const double length = std::clamp(10 * std::floor((sheet.width - 40) / 10), 10.0, 100.0);
  const double left = 5;
  sheet.black.push_back({left, top + 2, length, thickness});

  for (int mm = 0; mm <= length; mm += 10) {
    const double tick = mm % 50 == 0 ? 4 : 2.5;
    sheet.black.push_back({left + mm - thickness / 2, top + 2, thickness, tick});
  }

  sheet.words_left = left + length + 3;
  sheet.words_base = top + 4;
  sheet.words = fmt::format("{:.0f} mm", length);

  return sheet;
}

std::string svg_of(const Sheet& sheet) {
  std::string path;
  for (const auto& [left, top, width, height] : sheet.black) {
    path += fmt::format("M{:.4f} {:.4f}h{:.4f}v{:.4f}h{:.4f}z", left, top, width, height, -width);
  }

  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.4f}mm\" height=\"{1:.4f}mm\" "
      "viewBox=\"0 0 {0:.4f} {1:.4f}\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
      "<path d=\"{2}\"/>\n<text x=\"{3:.2f}\" y=\"{4:.2f}\" font-family=\"sans-serif\" "
      "font-size=\"4\">{5}</text>\n</svg>\n",
      sheet.width, sheet.height, path, sheet.words_left, sheet.words_base, sheet.words);
}

std::string pdf_of(const Sheet& sheet) {
  // 1. The drawing.
  constexpr double points_per_mm = 72 / 25.4;

  // In mm and downwards, except the text.
  std::string drawn = fmt::format("{0:.8f} 0 0 {1:.8f} 0 {2:.4f} cm\n", points_per_mm,
                                  -points_per_mm, sheet.height * points_per_mm);
  for (const auto& [left, top, width, height] : sheet.black) {
    drawn += fmt::format("{:.4f} {:.4f} {:.4f} {:.4f} re\n", left, top, width, height);
  }

  drawn += fmt::format("f\nBT /F 4 Tf 1 0 0 -1 {:.2f} {:.2f} Tm ({}) Tj ET\n", sheet.words_left,
                       sheet.words_base, sheet.words);

  // 2. The objects: catalogue, list of pages, page, drawing and font.
  const std::vector<std::string> objects{
      "<</Type/Catalog/Pages 2 0 R>>", "<</Type/Pages/Kids[3 0 R]/Count 1>>",
      fmt::format("<</Type/Page/Parent 2 0 R/MediaBox[0 0 {:.4f} {:.4f}]/Contents 4 0 R/"
                  "Resources<</Font<</F 5 0 R>>>>>>",
                  sheet.width * points_per_mm, sheet.height * points_per_mm),
      fmt::format("<</Length {}>>\nstream\n{}endstream", drawn.size(), drawn),
      "<</Type/Font/Subtype/Type1/BaseFont/Helvetica>>"};

  // 3. The file, with the place of each object in bytes.
  std::string file = "%PDF-1.4\n", places;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    places += fmt::format("{:010} 00000 n \n", file.size());
    file += fmt::format("{} 0 obj\n{}\nendobj\n", i + 1, objects[i]);
  }

  const std::size_t table = file.size();
  return file + fmt::format(
                    "xref\n0 {0}\n0000000000 65535 f \n{1}trailer\n<</Size {0}/Root 1 0 R>>\n"
                    "startxref\n{2}\n%%EOF\n",
                    objects.size() + 1, places, table);
}

/// A PNG file with a chunk for its resolution after the header.
std::vector<std::uint8_t> png_of(const Image<std::uint8_t>& picture, double mm_per_pixel) {
  std::vector<std::uint8_t> file = png_file_of(picture), chunk{0, 0, 0, 9, 'p', 'H', 'Y', 's'};

  const auto per_metre = static_cast<std::uint32_t>(std::lround(1000 / mm_per_pixel));
  append_numbers<std::endian::big>(chunk, per_metre, per_metre, std::uint8_t{1});  // of a metre

  append_numbers<std::endian::big>(chunk, checksum(std::span(chunk).subspan(4)));

  // The signature and the header chunk: 8 and 25 bytes.
  constexpr std::ptrdiff_t header = 33;
  file.insert(file.begin() + header, chunk.begin(), chunk.end());
  return file;
}

}  // namespace

void write_print(const std::filesystem::path& path, const Image<std::uint8_t>& picture,
                 double mm_per_pixel) {
  const std::string ending = lower_case_extension(path);
  if (ending == ".png") return write_file(path, png_of(picture, mm_per_pixel));
  if (ending != ".pdf" && ending != ".svg") return write_image(path, picture);

  const Sheet sheet = sheet_of(picture, mm_per_pixel);
  write_file(path, ending == ".pdf" ? pdf_of(sheet) : svg_of(sheet));
}

}  // namespace slipstream
