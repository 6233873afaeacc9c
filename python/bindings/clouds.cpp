#include "python/bindings/clouds.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>

#include "base/parallel_rows.h"
#include "base/throw_if-inl.h"
#include "io/image_file.h"
#include "io/plot.h"
#include "io/pose_file.h"
#include "python/bindings/arguments.h"
#include "python/bindings/scans.h"
#include "python/bindings/settings_help.h"
#include "slipstream/cloud_file.h"
#include "slipstream/surface.h"

namespace slipstream::python {
namespace {

/// Reuses memory of the right size.
void join(const Image<float>& x, const Image<float>& y, const Image<float>& z,
          HeldCloud::Points& points) {
  if (points.size() != x.size()) points = HeldCloud::Points(x.size());

  for_each_row(points.height(), [&](int row) {
    const float *from_x = x.row(row), *from_y = y.row(row), *from_z = z.row(row);
    std::array<float, 3>* const to = points.row(row);

    for (int i = 0; i < points.width(); ++i) to[i] = {from_x[i], from_y[i], from_z[i]};
  });
}

/// The array with an axis of length 1 before its others.
ArrayOf<float> as_one_row(const ArrayOf<float>& array) {
  return ArrayOf<float>(array[py::make_tuple(py::none(), py::ellipsis())]);
}

/// From points rows x columns x 3 or N x 3, not finite if invalid.
std::shared_ptr<HeldCloud> cloud_from(const ArrayOf<float>& points,
                                      const std::optional<ArrayOf<float>>& intensity,
                                      const std::optional<std::string>& frame) {
  throw_if((points.ndim() != 2 && points.ndim() != 3) || points.shape(points.ndim() - 1) != 3,
           "points: {}; expected rows x columns x 3, or N x 3", shown(points));

  if (points.ndim() == 2) {
    const bool is_list = intensity && intensity->ndim() == 1;
    return cloud_from(as_one_row(points), is_list ? as_one_row(*intensity) : intensity, frame);
  }

  const auto axis = [&](int i) {
    return image_from(ArrayOf<float>(points[py::make_tuple(py::ellipsis(), i)]));
  };

  auto held = std::make_shared<HeldCloud>();
  Cloud& cloud = held->cloud;
  std::tie(cloud.x, cloud.y, cloud.z) = std::tuple(axis(0), axis(1), axis(2));

  // Starts with every pixel as a point, and removes those that are not finite.
  cloud.validity = Image<Validity>(cloud.size(), Validity::valid);
  cloud.intensity = intensity ? image_from(*intensity) : Image<float>(cloud.size());
  throw_if(cloud.intensity.size() != cloud.size(), "intensity: size differs from the points'");

  for_each_pixel_in_order(cloud.size(), [&](int i, int row) {
    const bool is_point = std::isfinite(cloud.x(i, row) + cloud.y(i, row) + cloud.z(i, row));
    if (!is_point) cloud.reject(i, row, Validity::no_point);
  });

  if (frame && *frame != camera_frame) {
    require_frame_name(*frame);
    cloud.frame = std::make_shared<const FramePose>(std::string(camera_frame), *frame);
  }

  return held;
}

void write(const HeldCloud& self, const fs::path& path, const Uncertainty* uncertainty,
           bool normals, const std::optional<fs::path>& to_frame) {
  require_cloud_ending(path);
  throw_if(self.cloud.frame && uncertainty != nullptr,
           "uncertainty: it is in the camera's frame, and this cloud is moved; give `to_frame` "
           "when writing the cloud that it belongs to");

  std::shared_ptr<const FramePose> frame;
  if (to_frame) frame = std::make_shared<const FramePose>(read_pose(*to_frame));

  std::optional<Normals> smoothed;
  if (normals) smoothed = smoothed_normals(self.cloud);

  write_cloud(path, self.cloud,
              {.normals = smoothed ? &*smoothed : nullptr,
               .uncertainty = uncertainty,
               .remarks = self.remarks,
               .frame = frame});
}

std::shared_ptr<HeldCloud> moved(const HeldCloud& self, const fs::path& pose) {
  const FramePose read = read_pose(pose);

  auto copy = std::make_shared<HeldCloud>();
  copy->cloud = self.cloud;
  copy->remarks = self.remarks;
  move_to_frame(copy->cloud, read);
  return copy;
}

void write_mesh(const HeldCloud& self, const fs::path& path, double largest_step) {
  require_mesh_ending(path);
  write_surface(path, surface_of(self.cloud, largest_step));
}

std::shared_ptr<HeldCloud> cleaned(const HeldCloud& self, const py::kwargs& kwargs) {
  Cleaner clean(settings_from<CleanSettings>(kwargs));

  return unlocked([&] {
    auto copy = std::make_shared<HeldCloud>();
    copy->cloud = self.cloud;
    clean(copy->cloud);
    return copy;
  });
}

py::dict counts_of(const HeldCloud& self) {
  py::dict counts;
  const ValidityCounts all = count_by_validity(self.cloud);

  for (std::size_t i = 0; i < validity_count; ++i) {
    counts[py::str(std::string(name_of(static_cast<Validity>(i))))] = all[i];
  }
  return counts;
}

/// A getter of an image as an array.
template <class Held>
auto image(Image<float> Held::*member) {
  return
      [member](const py::object& self) { return array_of(self.cast<const Held&>().*member, self); };
}

/// The same of a cloud's image.
template <class Pixel>
auto cloud_image(Image<Pixel> Cloud::*member) {
  return [member](const py::object& self) {
    return array_of(self.cast<const HeldCloud&>().cloud.*member, self);
  };
}

py::object points_of(const py::object& self) {
  auto& cloud = self.cast<HeldCloud&>();
  const HeldCloud::Points* points = unlocked([&] { return &cloud.points(); });
  return array_of(*points, self);
}

py::array normals_of(const HeldCloud& self) {
  return array_from(unlocked([&] {
    const Normals normals = smoothed_normals(self.cloud);
    HeldCloud::Points joined;
    join(normals.x, normals.y, normals.z, joined);
    return joined;
  }));
}

py::bytes preview_of(const HeldCloud& self) {
  const auto png = unlocked([&] { return depth_preview(self.cloud); });
  return {reinterpret_cast<const char*>(png.data()), png.size()};
}

std::shared_ptr<HeldCloud> loaded_cloud(const fs::path& path) {
  StoredCloud stored = unlocked([&] { return read_cloud(path); });

  constexpr double harmless = 0.001;  // mm
  if (stored.rounding > harmless) {
    warn_of("", {fmt::format("{}: its coordinates are rounded to 32 bits, by up to {:.2g} mm; "
                             "subtract a common offset from them first",
                             path.string(), stored.rounding)});
  }

  auto held = std::make_shared<HeldCloud>();
  held->cloud = std::move(stored.cloud);
  return held;
}

using CloudClass = py::class_<HeldCloud, std::shared_ptr<HeldCloud>>;

py::object colours_of(const HeldCloud& held) {
  const Image<Colour>& colours = held.cloud.colour;
  if (colours.empty()) return py::none();

  static_assert(sizeof(Colour) == 3);
  return py::array_t<std::uint8_t>({colours.height(), colours.width(), 3},
                                   reinterpret_cast<const std::uint8_t*>(colours.begin()));
}

void bind_cloud_properties(CloudClass& cloud) {
  // The images view the cloud's memory.
  cloud.def_property_readonly("x", cloud_image(&Cloud::x),
                              "NDArray[float32]: to the right, mm; NaN if invalid.");
  cloud.def_property_readonly("y", cloud_image(&Cloud::y),
                              "NDArray[float32]: down, mm; NaN if invalid.");
  cloud.def_property_readonly("z", cloud_image(&Cloud::z),
                              "NDArray[float32]: depth, mm; NaN if invalid.");
  cloud.def_property_readonly("intensity", cloud_image(&Cloud::intensity),
                              "NDArray[float32]: texture, grey levels of 255.");
  cloud.def_property_readonly("colour", &colours_of,
                              "NDArray[uint8] | None: red, green and blue, sRGB, rows x columns x "
                              "3; None without a colour camera; copied.");
  cloud.def_property_readonly("validity", cloud_image(&Cloud::validity),
                              "NDArray[uint8]: Validity numbers.");
  cloud.def_property_readonly("points", &points_of,
                              "NDArray[float32]: x, y, z side by side, mm, rows x columns x 3; NaN "
                              "if invalid; copied on first use.");

  cloud.def_property_readonly("counts", &counts_of, "dict[str, int]: pixels by validity.");
  cloud.def_property_readonly(
      "frame", [](const HeldCloud& self) { return std::string(frame_name(self.cloud)); },
      "str: name of the frame of x, y, z; \"camera\" unless it was moved.");
  cloud.def_readonly("remarks", &HeldCloud::remarks, "list[str]: diagnostics, for its file.");
  cloud.def_property_readonly(
      "size", [](const HeldCloud& self) { return self.cloud.size(); },
      "tuple[int, int]: width and height, pixels.");
}

void bind_cloud_changes(CloudClass& cloud) {
  cloud.def("normals", &normals_of, R"(
      Smoothed unit normals towards the camera.

      Returns:
          NDArray[float32]: rows x columns x 3; NaN if invalid.

      Example:
          >>> cloud.normals().shape
          (120, 160, 3)
  )");

  cloud.def("moved", &moved, "pose"_a, Unlocked(), R"(
      A copy in another frame, as for a robot. Normals, meshes and cleaning need the camera's.

      Args:
          pose (str | PathLike): pose file between the cloud's frame and the other, in either
              direction.

      Returns:
          Cloud

      Raises:
          Error: if the file is missing or malformed, or its frames are others.
          WorldError: if it cannot be read.

      Example:
          >>> with open("table.yaml", "w") as file:
          ...     _ = file.write("{from: camera, to: table, unit: mm, "
          ...                    "rotation_vector: [0, 0, 0], translation: [0, 0, 9]}")
          >>> cloud.moved("table.yaml").frame
          'table'
  )");

  cloud.def("cleaned", &cleaned,
            with_settings(described_help(CleanSettings()), R"(
      A copy without points that contradict their neighbours.

      Args:
          {settings}

      Returns:
          Cloud

      Raises:
          Error: if a value is out of range.
          TypeError: for an unknown keyword or a value of the wrong type.

      Example:
          >>> len(cloud.cleaned(smallest_component=10**6))
          0
  )")
                .c_str());
}

void bind_cloud_files(CloudClass& cloud) {
  cloud.def("write", &write, "path"_a, "uncertainty"_a = py::none(), py::kw_only(),
            "normals"_a = false, "to_frame"_a = py::none(), Unlocked(), R"(
      Writes the points.

      Args:
          path (str | PathLike): .ply, .pcd or .xyz.
          uncertainty (Uncertainty | None): adds standard deviations of the points.
          normals (bool): adds normals.
          to_frame (str | PathLike | None): pose file; writes everything in its frame.

      Raises:
          Error: if the ending is not supported, or the pose file malformed.
          WorldError: if the file cannot be written.

      Example:
          >>> cloud.write("cloud.ply", normals=True)
  )");

  cloud.def("write_mesh", &write_mesh, "path"_a, py::kw_only(), "largest_step"_a = 8., Unlocked(),
            R"(
      Joins neighbouring points by triangles and writes them.

      Args:
          path (str | PathLike): .ply, .stl, .obj or .glb.
          largest_step (float): in depth along a triangle, in distances between its rays.

      Raises:
          Error: if the ending is not supported.
          WorldError: if the file cannot be written.

      Example:
          >>> cloud.write_mesh("mesh.stl")
  )");
}

void bind_cloud_previews(CloudClass& cloud) {
  const auto write_preview = [](const HeldCloud& self, const fs::path& path) {
    write_depth_preview(path, self.cloud);
  };

  cloud.def("write_preview", write_preview, "path"_a, Unlocked(), R"(
      Writes a coloured depth picture.

      Args:
          path (str | PathLike): .png.

      Raises:
          Error: if the ending is not supported.
          WorldError: if the file cannot be written.

      Example:
          >>> cloud.write_preview("preview.png")
  )");

  cloud.def("preview", &preview_of, R"(
      The coloured depth picture.

      Returns:
          bytes: a PNG file.

      Example:
          >>> cloud.preview()[1:4]
          b'PNG'
  )");
}

void bind_cloud(py::module_& module) {
  CloudClass cloud(module, "Cloud", R"(
      A point, or the reason why it is invalid, for each camera pixel.

      In the camera's frame unless moved: read-only arrays, rows x columns.

      Args:
          points (ArrayLike): x, y, z side by side, mm, rows x columns x 3 or N x 3; NaN if
              invalid.
          intensity (ArrayLike | None): texture, grey levels of 255.
          frame (str | None): name of the points' frame, with the camera at its origin; default:
              the camera's.

      Example:
          >>> slipstream.Cloud(cloud.points * [1, 1, 0.5]).size
          (160, 120)
          >>> slipstream.Cloud([[1, 2, 3], [4, 5, 6]], frame="table")
          <slipstream.Cloud 2x1: 2 points of 2 pixels, 3.0 to 6.0 mm>
  )");

  cloud.def(py::init(&cloud_from), "points"_a, "intensity"_a = py::none(), "frame"_a = py::none());
  cloud.def("__len__", [](const HeldCloud& self) { return point_count(self.cloud); });

  bind_cloud_properties(cloud);
  bind_cloud_changes(cloud);
  bind_cloud_files(cloud);
  bind_cloud_previews(cloud);

  module.def("load_cloud", &loaded_cloud, "path"_a, R"(
      Reads the points of a cloud or mesh file; warns if 32 bits are too few for its coordinates.

      Args:
          path (str | PathLike): file, by its ending.

      Returns:
          Cloud: one row if unorganised.

      Raises:
          Error: if the file is missing or malformed, or its ending not supported.
          WorldError: if it cannot be read.

      Example:
          >>> cloud.write("cloud.pcd")
          >>> len(slipstream.load_cloud("cloud.pcd")) == len(cloud)
          True
  )");
}

void bind_uncertainty(py::module_& module) {
  py::class_<Uncertainty, std::shared_ptr<Uncertainty>> uncertainty(module, "Uncertainty", R"(
      Standard deviation of each point from noise, rows x columns.

      Example:
          >>> engine.uncertainty(cloud, maps, scan.frames).z.shape
          (120, 160)
  )");

  uncertainty.def_property_readonly("coordinate", image(&Uncertainty::coordinate),
                                    "NDArray[float32]: of the projector coordinate, fields.");
  uncertainty.def_property_readonly("x", image(&Uncertainty::x), "NDArray[float32]: mm.");
  uncertainty.def_property_readonly("y", image(&Uncertainty::y), "NDArray[float32]: mm.");
  uncertainty.def_property_readonly("z", image(&Uncertainty::z), "NDArray[float32]: mm.");
}

void bind_maps(py::module_& module) {
  py::class_<Maps, std::shared_ptr<Maps>> maps(module, "Maps", R"(
      Maps of each camera pixel, rows x columns; None if not available.

      Example:
          >>> maps.coordinate.shape
          (120, 160)
  )");

  maps.def_property_readonly("mean", image(&Maps::mean),
                             "NDArray[float32]: grey levels of the frames.");
  maps.def_property_readonly("modulation", image(&Maps::modulation),
                             "NDArray[float32]: grey levels of the frames.");
  maps.def_property_readonly("wrapped_phase", image(&Maps::wrapped_phase),
                             "NDArray[float32]: of the highest frequency, rad, 0 to 2 pi.");
  maps.def_property_readonly("fringe_order_doubt", image(&Maps::fringe_order_doubt),
                             "NDArray[float32] | None: disagreement of the frequencies, periods.");
  maps.def_property_readonly("coordinate", image(&Maps::coordinate),
                             "NDArray[float32] | None: 0 to 1 across the field.");
  maps.def_property_readonly("motion", image(&Maps::motion),
                             "NDArray[float32] | None: rad from frame to frame.");
  maps.def_property_readonly(
      "contrast", image(&Maps::contrast),
      "NDArray[float32] | None: what correct_contrast took from coordinate.");
}

}  // namespace

const HeldCloud::Points& HeldCloud::points() {
  const std::lock_guard lock(mutex_);

  // Joined once, however many threads ask for them.
  if (!std::exchange(has_points_, true)) join(cloud.x, cloud.y, cloud.z, points_);
  return points_;
}

void bind_clouds(py::module_& module) {
  bind_uncertainty(module);
  bind_cloud(module);

  bind_maps(module);
}

}  // namespace slipstream::python
