#include "io/model_file.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "base/numbers.h"
#include "io/file.h"
#include "io/frame_title.h"
#include "io/point_elements.h"
#include "slipstream/cloud_file.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

std::string model_ply(const FusedModel& model, const std::vector<std::string>& remarks) {
  const std::string frame = model.frame ? frame_comments(model.frame.get(), "comment")
                                        : "comment slipstream, frame of the first view, mm\n";
  std::string comments = frame;
  for (const std::string& remark : remarks) comments += fmt::format("comment {}\n", remark);

  std::string file = fmt::format(
      "ply\nformat binary_little_endian 1.0\n{}"
      "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
      "property float nx\nproperty float ny\nproperty float nz\n{}"
      "property float sigma\nproperty float disagreement\nproperty ushort views\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n",
      comments, model.points.size(), ply_intensity);

  for (const ModelPoint& point : model.points) {
    const std::uint8_t grey = grey_level(point.intensity);
    const Colour colour = model.coloured ? point.colour : Colour{grey, grey, grey};
    append_numbers(file, point.position, point.normal, double{point.intensity}, point.sigma,
                   point.disagreement, point.views, colour.red, colour.green, colour.blue);
  }
  return file;
}

}  // namespace

void require_model_ending(const fs::path& path) {
  if (path == standard_output) return;
  require_ending(path, "format of models", {".ply", ".pcd", ".xyz"});
}

void write_model(const fs::path& path, const FusedModel& model,
                 const std::vector<std::string>& remarks) {
  require_model_ending(path);
  if (path == standard_output || lower_case_extension(path) == ".ply") {
    write_file(path, model_ply(model, remarks));
    return;
  }

  // The other formats as clouds of one row.
  const auto [cloud, normals] = model_points(model);
  write_cloud(path, cloud, {.normals = &normals, .remarks = remarks});
}

Surface surface_of(const ModelMesh& mesh) {
  // A ramp of all grey levels, from which each vertex takes its own.
  constexpr int levels = 256;
  Surface surface{.triangles = mesh.triangles, .picture = Image<std::uint8_t>({levels, 1})};
  for (int level = 0; level < levels; ++level) {
    surface.picture(level, 0) = static_cast<std::uint8_t>(level);
  }

  surface.frame = mesh.frame;
  for (const ModelPoint& vertex : mesh.vertices) {
    surface.vertices.push_back(vertex.position);
    surface.intensity.push_back(vertex.intensity);
    const auto grey = static_cast<float>(grey_level(vertex.intensity));
    surface.texture.emplace_back((grey + 0.5F) / levels, 0.5F);
    if (mesh.coloured) surface.colour.push_back(vertex.colour);
  }
  return surface;
}

}  // namespace slipstream
