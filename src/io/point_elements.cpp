#include "io/point_elements.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace slipstream {
namespace {

/// The numbers of one property: one, or a list.
std::vector<double> read_property(const PointProperty& property, NumberReader& reader) {
  const double count = property.count_type ? reader.number(*property.count_type)
                                           : static_cast<double>(property.count);

  throw_if(!(count >= 0 && count <= static_cast<double>(reader.left().size())),
           "a list of {} numbers is longer than the file", count);

  std::vector<double> numbers;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    numbers.push_back(reader.number(property.type));
  }
  return numbers;
}

/// The weights of red, green and blue in the luminance of ITU-R BT.601.
constexpr std::array<double, 3> weights{0.299, 0.587, 0.114};

/// The member of StoredPoint to which a column adds, and its weight.
struct Target {
  double StoredPoint::*field = nullptr;
  double share = 1;
  bool packed = false;          ///< a colour in three bytes, blue lowest; its luminance is added
  std::optional<int> colour{};  ///< of red, green and blue
};

/// In text, a packed colour is an integer or a float with the same bytes; those are below 1e-37 or
/// above 1e38.
std::array<float, 3> unpacked(double number) {
  const double size = std::abs(number);
  const auto rgb = size >= 1 && size < 0x1p32
                       ? static_cast<std::uint32_t>(static_cast<std::int64_t>(number))
                       : std::bit_cast<std::uint32_t>(static_cast<float>(number));

  const auto byte = [rgb](unsigned shift) { return static_cast<float>(rgb >> shift & 255U); };
  return {byte(16), byte(8), byte(0)};
}

Target target_of(const PointProperty& property) {
  static const std::map<std::string, Target> targets{
      {"x", {&StoredPoint::x}},
      {"y", {&StoredPoint::y}},
      {"z", {&StoredPoint::z}},
      {"intensity", {&StoredPoint::intensity}},
      {"scalar_intensity", {&StoredPoint::intensity}},
      {"red", {&StoredPoint::intensity, weights[0], false, 0}},
      {"green", {&StoredPoint::intensity, weights[1], false, 1}},
      {"blue", {&StoredPoint::intensity, weights[2], false, 2}},
      {"rgb", {&StoredPoint::intensity, 0, true}},
      {"rgba", {&StoredPoint::intensity, 0, true}},
      {"sigma_coordinate", {&StoredPoint::sigma_coordinate}},
      {"sigma_x", {&StoredPoint::sigma_x}},
      {"sigma_y", {&StoredPoint::sigma_y}},
      {"sigma_z", {&StoredPoint::sigma_z}},
      {"systematic_z", {&StoredPoint::systematic_z}}};

  // A list or several numbers have no target.
  const auto found = targets.find(usual_name(property.name));
  const bool one = !property.count_type && property.count == 1;
  return found == targets.end() || !one ? Target{} : found->second;
}

/// Colours have a share below 1.
bool is_intensity(const Target& target) {
  return target.field == &StoredPoint::intensity && target.share == 1;
}

/// The targets of an element's properties; an intensity overrides colours.
std::vector<Target> targets_of(const PointElement& element) {
  std::vector<Target> targets;
  bool has_intensity = false;

  for (const PointProperty& property : element.properties) {
    targets.push_back(target_of(property));
    has_intensity |= is_intensity(targets.back());
  }

  for (Target& target : targets) {
    if (has_intensity && target.share != 1) target.field = nullptr;
  }

  return targets;
}

/// Whether the colours are real numbers, which some programs write from 0 to 1.
bool has_real_colours(const PointElement& element, const std::vector<Target>& targets) {
  bool any = false;
  for (std::size_t k = 0; k < targets.size(); ++k) {
    if (!targets[k].colour && !targets[k].packed) continue;

    const NumberType type = element.properties[k].type;
    const bool is_real = type == NumberType::float32 || type == NumberType::float64;
    if (!is_real || targets[k].packed) return false;
    any = true;
  }
  return any;
}

/// Brings colours from 0 to 1 to grey levels of 255, and the intensity if it is their luminance.
/// Points without a colour, NaN, stay.
void scale_colours(std::vector<StoredPoint>& points, bool has_intensity) {
  constexpr float full_scale = 255, rounding = 1e-6F;
  const auto is_no_share = [](float level) { return level < 0 || level > 1 + rounding; };
  for (const StoredPoint& point : points) {
    if (std::ranges::any_of(point.colour, is_no_share)) return;
  }

  for (StoredPoint& point : points) {
    for (float& level : point.colour) level *= full_scale;
    if (!has_intensity) point.intensity *= full_scale;
  }
}

/// -1 if not an index.
int index_from(double number) {
  const bool index = number >= 0 && number <= std::numeric_limits<int>::max();
  return index && number == std::floor(number) ? static_cast<int>(number) : -1;
}

}  // namespace

std::string usual_name(std::string name) {
  static const std::map<std::string, std::string> initials{
      {"r", "red"}, {"g", "green"}, {"b", "blue"}, {"i", "intensity"}};

  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  const auto initial = initials.find(name);
  return initial == initials.end() ? name : initial->second;
}

bool any_colour(const std::vector<StoredPoint>& points) {
  return std::ranges::any_of(points, [](const StoredPoint& point) {
    const auto& [red, green, blue] = point.colour;
    return red != green || green != blue;
  });
}

double luminance(double red, double green, double blue) {
  return weights[0] * red + weights[1] * green + weights[2] * blue;
}

std::vector<std::string_view> words_of(std::string_view line, const char* separators) {
  std::vector<std::string_view> words;
  while (true) {
    const std::size_t start = line.find_first_not_of(separators);
    if (start == std::string_view::npos) return words;

    line.remove_prefix(start);
    words.push_back(line.substr(0, line.find_first_of(separators)));
    line.remove_prefix(words.back().size());
  }
}

std::size_t count_from(std::string_view text) {
  if (const auto count = number_in<std::size_t>(text)) return *count;
  throw Error(fmt::format("'{}' is not a number of elements", text.substr(0, 20)));
}

void read_element(const PointElement& element, NumberReader& reader, StoredPoints& stored) {
  if (element.properties.empty()) return;

  const std::vector<Target> targets = targets_of(element);
  const bool vertices = element.name == "vertex";

  const auto lacks = [&](double StoredPoint::*field) {
    return std::ranges::count(targets, field, &Target::field) == 0;
  };

  throw_if(vertices && (lacks(&StoredPoint::x) || lacks(&StoredPoint::y) || lacks(&StoredPoint::z)),
           "its points have no x, y and z");

  for (std::size_t i = 0; i < element.count; ++i) {
    StoredPoint point;
    for (std::size_t k = 0; k < targets.size(); ++k) {
      const std::vector<double> numbers = read_property(element.properties[k], reader);
      const auto& [field, share, packed, colour] = targets[k];
      if (colour) point.colour[static_cast<std::size_t>(*colour)] = static_cast<float>(numbers[0]);
      if (packed) point.colour = unpacked(numbers[0]);

      if (field != nullptr) {
        const auto& [red, green, blue] = point.colour;
        point.*field += packed ? luminance(red, green, blue) : share * numbers[0];
      }

      const std::string& name = element.properties[k].name;
      const bool is_face = name == "vertex_indices" || name == "vertex_index";
      for (std::size_t n = 2; is_face && n < numbers.size(); ++n) {  // triangle fan
        stored.triangles.push_back(
            {index_from(numbers[0]), index_from(numbers[n - 1]), index_from(numbers[n])});
      }
    }

    if (vertices) stored.points.push_back(point);
  }

  if (!vertices) return;
  if (has_real_colours(element, targets)) {
    scale_colours(stored.points, std::ranges::any_of(targets, is_intensity));
  }
  stored.has_colour = any_colour(stored.points);
  stored.has_sigma |= !lacks(&StoredPoint::sigma_z);
  stored.has_systematic |= !lacks(&StoredPoint::systematic_z);
}

}  // namespace slipstream
