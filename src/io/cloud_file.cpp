#include "slipstream/cloud_file.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/ranges.h>

#include "base/numbers.h"
#include "io/file.h"
#include "io/point_elements.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

/// A column after x y z intensity, with its names in PLY and PCD.
struct Extra {
  const char* ply_name;
  const char* pcd_name;
  const Image<float>& values;
};

std::vector<Extra> extras_of(const CloudExtras& extras) {
  std::vector<Extra> all;
  if (const Normals* normals = extras.normals) {
    all.push_back({"nx", "normal_x", normals->x});
    all.push_back({"ny", "normal_y", normals->y});
    all.push_back({"nz", "normal_z", normals->z});
  }

  if (const Uncertainty* sigma = extras.uncertainty) {
    all.push_back({"sigma_coordinate", "sigma_coordinate", sigma->coordinate});
    all.push_back({"sigma_x", "sigma_x", sigma->x});
    all.push_back({"sigma_y", "sigma_y", sigma->y});
    all.push_back({"sigma_z", "sigma_z", sigma->z});
  }

  return all;
}

/// The remarks as comment lines of a header.
std::string comments_of(const std::vector<std::string>& remarks, std::string_view mark) {
  std::string lines;
  for (std::string remark : remarks) {
    // A line break would end the comment.
    std::replace_if(
        remark.begin(), remark.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
    lines += fmt::format("{} {}\n", mark, remark);
  }
  return lines;
}

template <class Visit>
void for_each_point(const Cloud& cloud, const Visit& visit) {
  static_assert(sizeof(Validity) == 1);

  for (int row = 0; row < cloud.size().height; ++row) {
    const Validity* const first = cloud.validity.row(row);
    const Validity* const end = first + cloud.size().width;

    for (const Validity* pixel = first; pixel != end; ++pixel) {
      if (*pixel != Validity::valid) {
        // Most pixels of a picture lie beside the object.
        const void* const next = std::memchr(pixel, static_cast<int>(Validity::valid),
                                             static_cast<std::size_t>(end - pixel));
        if (next == nullptr) break;
        pixel = static_cast<const Validity*>(next);
      }

      visit(static_cast<int>(pixel - first), row);
    }
  }
}

std::string ply_file(const Cloud& cloud, const std::vector<Extra>& extras,
                     const std::vector<std::string>& remarks) {
  const std::size_t points = point_count(cloud);

  std::string file = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment slipstream, camera frame, mm\n{}"
      "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
      "{}",
      comments_of(remarks, "comment"), points, ply_intensity);

  for (const Extra& extra : extras) file += fmt::format("property float {}\n", extra.ply_name);
  file += "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n";

  // Bytes of a point: position in float, intensity in double and three colours.
  constexpr std::size_t place_intensity_colour = 12 + 8 + 3;
  const std::size_t header = file.size();
  file.resize(header + points * (place_intensity_colour + 4 * extras.size()));

  char* to = file.data() + header;
  const auto put = [&to](const auto& number) {
    std::memcpy(to, &number, sizeof number);
    to += sizeof number;
  };

  for_each_point(cloud, [&](int column, int row) {
    const float intensity = cloud.intensity(column, row);
    // In the order of the header.
    for (const Image<float>* image : {&cloud.x, &cloud.y, &cloud.z}) put((*image)(column, row));
    put(double{intensity});
    for (const Extra& extra : extras) put(extra.values(column, row));

    const std::uint8_t grey = grey_level(intensity);
    put(std::array{grey, grey, grey});
  });

  return file;
}

std::string pcd_file(const Cloud& cloud, const std::vector<Extra>& extras,
                     const std::vector<std::string>& remarks) {
  // All columns are 32-bit float.
  std::vector<const Image<float>*> columns{&cloud.x, &cloud.y, &cloud.z, &cloud.intensity};
  std::string fields = "x y z intensity";

  for (const Extra& extra : extras) {
    columns.push_back(&extra.values);
    fields += fmt::format(" {}", extra.pcd_name);
  }

  const auto of_each = [&](const char* word) {
    return fmt::format("{}", fmt::join(std::vector(columns.size(), word), " "));
  };

  std::string file = fmt::format(
      "# .PCD v0.7 - slipstream, camera frame, mm\n{}VERSION 0.7\nFIELDS {}\nSIZE {}\nTYPE {}\n"
      "COUNT {}\nWIDTH {}\nHEIGHT {}\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {}\nDATA binary\n",
      comments_of(remarks, "#"), fields, of_each("4"), of_each("F"), of_each("1"),
      cloud.size().width, cloud.size().height, cloud.z.pixel_count());

  for (std::size_t pixel = 0; pixel < cloud.z.pixel_count(); ++pixel) {
    for (const Image<float>* column : columns) append_numbers(file, column->begin()[pixel]);
  }

  return file;
}

std::string xyz_file(const Cloud& cloud, const std::vector<Extra>& extras) {
  std::string file;
  for_each_point(cloud, [&](int column, int row) {
    fmt::format_to(std::back_inserter(file), "{:.6f} {:.6f} {:.6f} {:.3f}", cloud.x(column, row),
                   cloud.y(column, row), cloud.z(column, row), cloud.intensity(column, row));

    for (const Extra& extra : extras) {
      fmt::format_to(std::back_inserter(file), " {:.6g}", extra.values(column, row));
    }

    file += '\n';
  });
  return file;
}

}  // namespace

void require_cloud_ending(const fs::path& path) {
  if (path != standard_output) require_ending(path, "cloud format", {".ply", ".pcd", ".xyz"});
}

void write_cloud(const fs::path& path, const Cloud& cloud, const CloudExtras& extras) {
  require_cloud_ending(path);

  const std::string extension = path == standard_output ? ".ply" : lower_case_extension(path);
  const std::vector<Extra> columns = extras_of(extras);

  write_file(path, extension == ".ply"   ? ply_file(cloud, columns, extras.remarks)
                   : extension == ".pcd" ? pcd_file(cloud, columns, extras.remarks)
                                         : xyz_file(cloud, columns));
}

}  // namespace slipstream
