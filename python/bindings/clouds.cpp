#include <algorithm>
#include <cmath>

#include "python/bindings/arrays.h"
#include "python/bindings/bindings.h"
#include "python/bindings/held.h"
#include "python/bindings/keywords.h"
#include "slipstream/clean/cleaner.h"
#include "slipstream/cloud/maps.h"
#include "slipstream/cloud/normals.h"
#include "slipstream/cloud/surface.h"
#include "slipstream/cloud/uncertainty.h"
#include "slipstream/error/error.h"
#include "slipstream/image/parallel_rows.h"
#include "slipstream/image/quantile.h"
#include "slipstream/io/cloud_file.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/preview.h"
#include "slipstream/io/stored_cloud.h"
#include "slipstream/io/surface_file.h"

namespace slipstream::python {

const HeldCloud::Points& HeldCloud::points() {
  const std::lock_guard lock(mutex_);
  if (has_points_) return points_;
  if (points_.size() != cloud.size()) points_ = Points(cloud.size());
  for_each_row(points_.height(), [&](int row) {
    const float *x = cloud.x.row(row), *y = cloud.y.row(row), *z = cloud.z.row(row);
    std::array<float, 3>* point = points_.row(row);
    for (int i = 0; i < points_.width(); ++i) point[i] = {x[i], y[i], z[i]};
  });
  has_points_ = true;
  return points_;
}

namespace {
namespace fs = std::filesystem;

/// Of points rows x columns x 3, not finite where there is none.
Cloud cloud_from(const py::array_t<float, py::array::forcecast>& points,
                 const std::optional<py::array_t<float, py::array::forcecast>>& intensity) {
  if (points.ndim() != 3 || points.shape(2) != 3) {
    throw Error("points: an array rows x columns x 3 is wanted");
  }
  const auto xyz = points.unchecked<3>();
  Cloud cloud(Size{static_cast<int>(xyz.shape(1)), static_cast<int>(xyz.shape(0))});
  if (intensity) cloud.intensity = image_from<float>(*intensity);
  if (cloud.intensity.size() != cloud.size()) throw Error("intensity: not of the points' size");
  for (int row = 0; row < cloud.size().height; ++row) {
    for (int column = 0; column < cloud.size().width; ++column) {
      const std::array point{xyz(row, column, 0), xyz(row, column, 1), xyz(row, column, 2)};
      if (!std::all_of(point.begin(), point.end(), [](float of) { return std::isfinite(of); })) {
        continue;
      }
      cloud.x(column, row) = point[0];
      cloud.y(column, row) = point[1];
      cloud.z(column, row) = point[2];
      cloud.validity(column, row) = Validity::valid;
    }
  }
  return cloud;
}

void write(const HeldCloud& of, const fs::path& path, const Uncertainty* uncertainty,
           bool normals) {
  require_cloud_ending(path);
  std::optional<Normals> smoothed;
  if (normals) smoothed = smoothed_normals(of.cloud);
  write_cloud(path, of.cloud,
              {.normals = smoothed ? &*smoothed : nullptr,
               .uncertainty = uncertainty,
               .remarks = of.remarks});
}

py::dict counts_of(const HeldCloud& of) {
  py::dict counts;
  const ValidityCounts all = count_by_validity(of.cloud);
  for (std::size_t i = 0; i < validity_count; ++i) {
    counts[py::str(std::string(name_of(static_cast<Validity>(i))))] = all[i];
  }
  return counts;
}

std::string text_of(const HeldCloud& of) {
  const std::vector<float> depths = finite_values(of.cloud.z);
  if (depths.empty()) return "no points";
  const auto [nearest, farthest] = std::minmax_element(depths.begin(), depths.end());
  return py::str("{} points, z {:.1f} to {:.1f} mm")
      .format(point_count(of.cloud), *nearest, *farthest)
      .cast<std::string>();
}

const Cloud& content(const HeldCloud& held) {
  return held.cloud;
}
template <class Held>
const Held& content(const Held& held) {
  return held;
}

/// Adds `name`, an image of what Python holds, as an array; none where it is empty.
template <class Held, class Member>
void add_image(py::class_<Held, std::shared_ptr<Held>>& held, const char* name, Member member,
               const char* help) {
  held.def_property_readonly(
      name,
      [member](const py::object& self) {
        return array_of(content(self.cast<const Held&>()).*member, self);
      },
      help);
}

using CloudClass = py::class_<HeldCloud, std::shared_ptr<HeldCloud>>;

void bind_arrays_of_clouds(CloudClass& cloud) {
  add_image(cloud, "x", &Cloud::x, "mm, rows x columns; NaN without a point.");
  add_image(cloud, "y", &Cloud::y, "As x.");
  add_image(cloud, "z", &Cloud::z, "As x.");
  add_image(cloud, "intensity", &Cloud::intensity, "Grey levels of 255.");
  add_image(cloud, "validity", &Cloud::validity, "Of each pixel, the number of a Validity.");
  cloud.def_property_readonly(
      "points",
      [](const py::object& self) {
        auto& held = self.cast<HeldCloud&>();
        const HeldCloud::Points* points = nullptr;
        {
          const py::gil_scoped_release release;
          points = &held.points();
        }
        return array_of(*points, self);
      },
      "x, y, z as one array rows x columns x 3: copied when first asked for, and kept.");
}

template <class Maker>
std::shared_ptr<HeldCloud> held(Maker&& make) {
  const py::gil_scoped_release release;
  return std::make_shared<HeldCloud>(make());
}

void bind_cloud(py::module_& module) {
  CloudClass cloud(module, "Cloud",
                   "A point, or the reason why there is none, for each camera pixel; mm, in the "
                   "camera's frame. Its arrays are views, to read, that keep it alive.");
  cloud.def(py::init([](const py::array_t<float, py::array::forcecast>& points,
                        const std::optional<py::array_t<float, py::array::forcecast>>& intensity) {
              return std::make_shared<HeldCloud>(cloud_from(points, intensity));
            }),
            py::arg("points"), py::arg("intensity") = py::none(),
            "Of a copy of points of your own, rows x columns x 3, NaN where there is none.");
  bind_arrays_of_clouds(cloud);
  cloud
      .def_property_readonly(
          "size", [](const HeldCloud& of) { return of.cloud.size(); }, "(width, height)")
      .def("__len__", [](const HeldCloud& of) { return point_count(of.cloud); })
      .def_readonly("remarks", &HeldCloud::remarks, "What is wrong with it, made all the same.")
      .def_property_readonly("counts", &counts_of, "Pixels of each kind of validity, by name.")
      .def("write", &write, py::arg("path"), py::arg("uncertainty") = py::none(), py::kw_only(),
           py::arg("normals") = false, py::call_guard<py::gil_scoped_release>(),
           "Writes .ply, .pcd or .xyz.")
      .def(
          "write_mesh",
          [](const HeldCloud& of, const fs::path& path, double largest_step) {
            require_mesh_ending(path);
            write_surface(path, surface_of(of.cloud, largest_step));
          },
          py::arg("path"), py::kw_only(), py::arg("largest_step") = 8.,
          py::call_guard<py::gil_scoped_release>(),
          "Joins neighbouring points by triangles and writes .ply, .stl, .obj or .glb.")
      .def(
          "write_preview",
          [](const HeldCloud& of, const fs::path& path) { write_depth_preview(path, of.cloud); },
          py::arg("path"), py::call_guard<py::gil_scoped_release>(), "Depth in colours: .png.")
      .def(
          "normals",
          [](const HeldCloud& of) {
            Normals normals;
            HeldCloud joined;
            {
              const py::gil_scoped_release release;
              normals = smoothed_normals(of.cloud);
              joined.cloud.x = std::move(normals.x);
              joined.cloud.y = std::move(normals.y);
              joined.cloud.z = std::move(normals.z);
              joined.points();
            }
            return array_from(joined.points());
          },
          "Unit normals towards the camera, rows x columns x 3, smoothed; NaN without a point.")
      .def(
          "cleaned",
          [](const HeldCloud& of, const py::kwargs& given) {
            Cleaner clean(clean_settings(given));
            return held([&] {
              Cloud copy = of.cloud;
              clean(copy);
              return copy;
            });
          },
          "A copy without the points that its neighbours speak against; settings as an Engine's.")
      .def("__repr__", [](const HeldCloud& of) {
        return "<slipstream.Cloud " + slipstream::text_of(of.cloud.size()) + ", " + text_of(of) +
               ">";
      });
  module.def(
      "load_cloud",
      [](const fs::path& path) { return held([&] { return read_cloud(path).cloud; }); },
      py::arg("path"), "The points of a cloud's or a mesh's file; one row where it has no order.");
}

void bind_maps(py::module_& module) {
  py::class_<Maps, std::shared_ptr<Maps>> maps(
      module, "Maps",
      "What frames say of each camera pixel before geometry; None where they do not.");
  add_image(maps, "mean", &Maps::mean, "A^c, grey levels of the frames.");
  add_image(maps, "modulation", &Maps::modulation, "B^c, likewise.");
  add_image(maps, "wrapped_phase", &Maps::wrapped_phase,
            "Of the highest frequency, rad, 0 to 2 pi.");
  add_image(maps, "fringe_order_doubt", &Maps::fringe_order_doubt,
            "How far the frequencies are apart on the order, periods.");
  add_image(maps, "coordinate", &Maps::coordinate,
            "Projector coordinate, 0 to 1 across the field.");
  add_image(maps, "motion", &Maps::motion, "Phase from frame to frame, rad, of more than a cycle.");
  maps.def("__repr__",
           [](const Maps& of) { return "<slipstream.Maps " + text_of(of.mean.size()) + ">"; });
  py::class_<Uncertainty, std::shared_ptr<Uncertainty>> uncertainty(
      module, "Uncertainty", "What the frames' noise does to each point: standard deviations.");
  add_image(uncertainty, "coordinate", &Uncertainty::coordinate, "Fields.");
  add_image(uncertainty, "x", &Uncertainty::x, "mm");
  add_image(uncertainty, "y", &Uncertainty::y, "mm");
  add_image(uncertainty, "z", &Uncertainty::z, "mm");
  uncertainty.def("__repr__", [](const Uncertainty& of) {
    return py::str("<slipstream.Uncertainty {}, median of z {:.3g} mm>")
        .format(text_of(of.z.size()), median_depth(of));
  });
  module.def(
      "write_map",
      [](const fs::path& path, const py::array_t<float, py::array::forcecast>& map) {
        write_map(path, image_from<float>(map));
      },
      py::arg("path"), py::arg("map"), "Rows x columns as TIFF of 32-bit float, NaN kept.");
  module.def(
      "load_map", [](const fs::path& path) { return array_from(read_map(path)); }, py::arg("path"),
      "Such a file as an array of float64.");
}

}  // namespace

void bind_clouds(py::module_& module) {
  bind_cloud(module);
  bind_maps(module);
}

}  // namespace slipstream::python
