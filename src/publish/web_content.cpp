#include "publish/web_content.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <limits>
#include <map>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/numbers.h"
#include "base/statistics.h"
#include "slipstream/error.h"
#include "slipstream/image.h"

namespace slipstream {
namespace {

constexpr int most_levels = 65534;

/// The size of a subsampled image.
Size thinned(Size size, int step) {
  return {(size.width + step - 1) / step, (size.height + step - 1) / step};
}

/// Appends pixels as they lie in memory.
template <class Pixel>
void append(std::string& bytes, const Image<Pixel>& image) {
  bytes.append(reinterpret_cast<const char*>(image.begin()), image.pixel_count() * sizeof(Pixel));
}

constexpr std::array counts{
    "captured",           "lost",      "overwritten",  "repeated", "clouds",  "done",
    "resynchronisations", "published", "windows_lost", "missed",   "dropped", "reconnects"};

/// Samples grouped by metric, as the format requires.
using Metrics = std::map<std::string, std::string>;

std::string escaped_label(const std::string& label) {
  std::string text;
  for (const char c : label) {
    if (c == '\\' || c == '"') text += '\\';
    text += c == '\n' ? ' ' : c;
  }
  return text;
}

void add_metrics(const nlohmann::json& value, const std::string& name, const std::string& labels,
                 Metrics& metrics) {
  // The path of keys is the metric's name, with "_total" for counters.
  if (value.is_object()) {
    for (const auto& [key, inner] : value.items()) {
      const bool count = std::find(counts.begin(), counts.end(), key) != counts.end();
      std::string word = key;
      std::replace_if(
          word.begin(), word.end(), [](char c) { return !std::isalnum(c); }, '_');

      const char* const ending = count && inner.is_number() ? "_total" : "";
      add_metrics(inner, fmt::format("{}_{}{}", name, word, ending), labels, metrics);
    }
  } else if (value.is_array()) {
    // A list of objects without names gives its length, other lists a sample for each member.
    const bool objects = std::all_of(value.begin(), value.end(), [](const nlohmann::json& one) {
      return one.is_object() && !one.contains("name");
    });
    if (objects) metrics[name] += fmt::format("{} {}\n", name, value.size());

    for (std::size_t i = 0; i < value.size() && !objects; ++i) {
      const nlohmann::json& one = value[i];
      const bool named = one.is_object();
      add_metrics(
          one, name,
          fmt::format("{{{}=\"{}\"}}", named ? "name" : "index",
                      named ? escaped_label(one["name"].get<std::string>()) : std::to_string(i)),
          metrics);
    }
  } else if (value.is_number()) {
    metrics[name] += fmt::format("{}{} {}\n", name, labels, value.dump());
  }
}

}  // namespace

std::string web_palette() {
  const ColourMap colours = depth_colours();
  return {reinterpret_cast<const char*>(colours.data()), sizeof(colours)};
}

int web_step(Size camera) {
  constexpr std::int64_t most = 1 << 20;
  for (int step = 1;; ++step) {
    const auto [width, height] = thinned(camera, step);
    if (std::int64_t{width} * height <= most) return step;
  }
}

std::string web_rays(const Lens& camera) {
  std::vector<float> rays;
  const int step = web_step(camera.size);

  for_each_pixel_in_order(thinned(camera.size, step), [&](int column, int row) {
    const Eigen::Vector3d ray = ray_through(camera, {step * column, step * row});
    rays.insert(rays.end(), {static_cast<float>(ray.x()), static_cast<float>(ray.y())});
  });

  return {reinterpret_cast<const char*>(rays.data()), rays.size() * sizeof(float)};
}

std::string web_cloud(const LiveCloud& live, const Image<std::uint8_t>& phase) {
  // 1. Thin the cloud out.
  const Cloud& cloud = live.cloud;
  const Frame& frame = *live.frames.front();
  const bool has_depth = !cloud.z.empty();
  const int every = web_step(frame.format().size);
  const Size size = thinned(frame.format().size, every);
  const Image<float> depth = subsampled(cloud.z, every);

  // 2. Spread 16 bits over its depths. Step 0 is for invalid ones.
  DepthRange range;
  if (const std::vector<float> values = finite_values(depth); !values.empty()) {
    const auto [least, largest] = std::ranges::minmax(values);
    range = {least, largest};
  }

  const auto nearest = static_cast<float>(range.nearest);
  constexpr double finest = 1e-6;  // depth step, representable as a float
  const auto step = static_cast<float>(
      std::max({(range.farthest - range.nearest) / most_levels, finest * range.farthest,
                double{std::numeric_limits<float>::min()}}));
  const DepthScale numbers{step, nearest - step};

  // 3. Depths and grey levels; without a scanner, the grey levels of the first frame.
  Image<std::uint16_t> depths(size);
  Image<std::uint8_t> greys(size);
  const bool has_colour = has_depth && !cloud.colour.empty();
  if (has_depth) {
    std::ranges::transform(depth, depths.begin(), numbers);
    std::ranges::transform(subsampled(cloud.intensity, every), greys.begin(), grey_level);
  } else {
    const auto in_8_bits = [&](auto grey) {
      return static_cast<std::uint8_t>(grey >> (frame.bits - 8));
    };
    std::visit(
        [&](const auto& picture) {
          std::ranges::transform(subsampled(picture, every), greys.begin(), in_8_bits);
        },
        frame.pixels);
  }

  // 4. The message: head, then the images.
  std::string bytes;
  const int points = static_cast<int>(has_depth ? point_count(cloud) : 0);
  append_numbers(bytes, size.width, size.height, int{has_depth} + (has_colour ? 2 : 0), points,
                 nearest, step);
  append(bytes, depths);
  append(bytes, greys);
  if (has_colour) append(bytes, subsampled(cloud.colour, every));
  append(bytes, subsampled(phase, every));
  return bytes;
}

std::string metrics_of(std::string_view statistics) {
  const auto document = nlohmann::json::parse(statistics, nullptr, false);
  if (document.is_discarded()) throw Error("statistics are not JSON");

  Metrics metrics;
  add_metrics(document, "slipstream", "", metrics);

  std::string text;
  for (const auto& [name, samples] : metrics) {
    text += fmt::format("# TYPE {} {}\n{}", name, name.ends_with("_total") ? "counter" : "gauge",
                        samples);
  }

  return text;
}

}  // namespace slipstream
