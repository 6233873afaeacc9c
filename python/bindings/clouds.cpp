#include "python/bindings/clouds.h"

#include <array>
#include <cmath>
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
#include "python/bindings/arguments.h"
#include "slipstream/cloud_file.h"
#include "slipstream/spatial_unwrapping.h"
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

/// From points rows x columns x 3, not finite if invalid.
std::shared_ptr<HeldCloud> cloud_from(const py::array& points,
                                      const std::optional<ArrayOf<float>>& intensity) {
  throw_if(points.ndim() != 3 || points.shape(2) != 3, "points: expected rows x columns x 3");

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
    if (!is_point) cloud.leave_out(i, row, Validity::no_point);
  });

  return held;
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

void write_mesh(const HeldCloud& of, const fs::path& path, double largest_step) {
  require_mesh_ending(path);
  write_surface(path, surface_of(of.cloud, largest_step));
}

std::shared_ptr<HeldCloud> cleaned(const HeldCloud& of, const py::kwargs& given) {
  Cleaner clean(settings_from<CleanSettings>(given));

  return unlocked([&] {
    auto copy = std::make_shared<HeldCloud>();
    copy->cloud = of.cloud;
    clean(copy->cloud);
    return copy;
  });
}

py::dict counts_of(const HeldCloud& of) {
  py::dict counts;
  const ValidityCounts all = count_by_validity(of.cloud);

  for (std::size_t i = 0; i < validity_count; ++i) {
    counts[py::str(std::string(name_of(static_cast<Validity>(i))))] = all[i];
  }
  return counts;
}

/// Images of `Held`, or of its cloud, as arrays.
template <class Held, class Member, class... More>
void add_images(py::class_<Held, std::shared_ptr<Held>>& held, const char* name, Member member,
                const More&... more) {
  add(held, name, [member](const py::object& self) {
    const auto& of = self.cast<const Held&>();
    if constexpr (std::is_same_v<Held, HeldCloud>) {
      return array_of(of.cloud.*member, self);
    } else {
      return array_of(of.*member, self);
    }
  });

  if constexpr (sizeof...(more) > 0) add_images(held, more...);
}

void bind_cloud(py::module_& module) {
  py::class_<HeldCloud, std::shared_ptr<HeldCloud>> cloud(module, "Cloud");
  cloud.def(py::init(&cloud_from), "points"_a, "intensity"_a = py::none());

  // The images view the cloud's memory.
  add_images(cloud, "x", &Cloud::x, "y", &Cloud::y, "z", &Cloud::z, "intensity", &Cloud::intensity,
             "validity", &Cloud::validity);
  add(cloud, "points", [](const py::object& self) {
    auto& of = self.cast<HeldCloud&>();
    const HeldCloud::Points* points = unlocked([&] { return &of.points(); });
    return array_of(*points, self);
  });

  add(cloud, "counts", &counts_of, "remarks", &HeldCloud::remarks, "size",
      [](const HeldCloud& of) { return of.cloud.size(); });
  cloud.def("__len__", [](const HeldCloud& of) { return point_count(of.cloud); });

  cloud.def("normals", [](const HeldCloud& of) {
    return array_from(unlocked([&] {
      const Normals normals = smoothed_normals(of.cloud);
      HeldCloud::Points joined;
      join(normals.x, normals.y, normals.z, joined);
      return joined;
    }));
  });

  cloud.def("cleaned", &cleaned);

  cloud.def("write", &write, "path"_a, "uncertainty"_a = py::none(), py::kw_only(),
            "normals"_a = false, Unlocked());

  cloud.def("write_mesh", &write_mesh, "path"_a, py::kw_only(), "largest_step"_a = 8., Unlocked());
  cloud.def(
      "write_preview",
      [](const HeldCloud& of, const fs::path& path) { write_depth_preview(path, of.cloud); },
      "path"_a, Unlocked());

  cloud.def("preview", [](const HeldCloud& of) {
    const auto png = unlocked([&] { return depth_preview(of.cloud); });
    return py::bytes(reinterpret_cast<const char*>(png.data()), png.size());
  });

  module.def(
      "load_cloud",
      [](const fs::path& path) {
        auto held = std::make_shared<HeldCloud>();
        held->cloud = read_cloud(path).cloud;
        return held;
      },
      "path"_a, Unlocked());
}

}  // namespace

const HeldCloud::Points& HeldCloud::points() {
  const std::lock_guard lock(mutex_);

  // Joined once, however many threads ask for them.
  if (!std::exchange(has_points_, true)) join(cloud.x, cloud.y, cloud.z, points_);
  return points_;
}

void bind_clouds(py::module_& module) {
  bind_cloud(module);

  py::class_<Maps, std::shared_ptr<Maps>> maps(module, "Maps");
  add_images(maps, "mean", &Maps::mean, "modulation", &Maps::modulation, "wrapped_phase",
             &Maps::wrapped_phase, "fringe_order_doubt", &Maps::fringe_order_doubt, "coordinate",
             &Maps::coordinate, "motion", &Maps::motion);

  py::class_<Uncertainty, std::shared_ptr<Uncertainty>> uncertainty(module, "Uncertainty");
  add_images(uncertainty, "coordinate", &Uncertainty::coordinate, "x", &Uncertainty::x, "y",
             &Uncertainty::y, "z", &Uncertainty::z);

  module.def(
      "write_map",
      [](const fs::path& path, const ArrayOf<float>& map) { write_map(path, image_from(map)); },
      "path"_a, "map"_a);

  module.def(
      "load_map", [](const fs::path& path) { return array_from(read_map(path)); }, "path"_a);

  // Unwraps a single wrapped phase from pixel to pixel, without a code.
  module.def(
      "unwrap_in_space",
      [](const ArrayOf<float>& phase, const std::optional<ArrayOf<float>>& quality,
         const std::string& method) {
        const Image<float> wrapped = image_from(phase);
        const Image<float> sure = quality ? image_from(*quality) : Image<float>();

        auto unwrapped = unlocked([&] { return unwrap_in_space(wrapped, sure, method); });
        return results("phase"_a = array_from(std::move(unwrapped.phase)),
                       "region"_a = array_from(std::move(unwrapped.region)));
      },
      "phase"_a, "quality"_a = py::none(), "method"_a = "flow");
}

}  // namespace slipstream::python
