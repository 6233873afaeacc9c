#include "slipstream/ros_messages.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <variant>

#include "base/throw_if-inl.h"
#include "io/file.h"
#include "io/point_elements.h"
#include "publish/cdr.h"
#include "publish/message_definition.h"

namespace slipstream {
namespace {

constexpr std::uint8_t uint32 = 6, float32 = 7;   // PointField datatypes
constexpr std::string_view colour_field = "rgb";  // a float32 with the bits of packed_colour

struct PointField {
  std::string_view name;
  float millimetres;  ///< scale to its unit
};
constexpr std::array<PointField, 8> point_fields{{{"x", 1000},
                                                  {"y", 1000},
                                                  {"z", 1000},
                                                  {"intensity", 1},
                                                  {"sigma_coordinate", 1},
                                                  {"sigma_x", 1000},
                                                  {"sigma_y", 1000},
                                                  {"sigma_z", 1000}}};

/// Starts a message of an image or of one value for each pixel: header, height, width.
Cdr begin_picture(RosMessage& message, const RosHeader& header, Size size) {
  Cdr cdr(message);
  cdr.add_time(header.time).add_text(header.frame_id).add(static_cast<std::uint32_t>(size.height));
  return cdr.add(static_cast<std::uint32_t>(size.width));
}

/// `level_of`: a pixel as it is in the message.
template <class Pixel, class LevelOf>
void write_picture(const Image<Pixel>& picture, std::string_view encoding, LevelOf level_of,
                   const RosHeader& header, RosMessage& message) {
  using Level = std::remove_cvref_t<decltype(level_of(Pixel{}))>;
  Cdr cdr = begin_picture(message, header, picture.size());
  cdr.add_text(encoding).add(std::uint8_t{0});
  cdr.add_count(static_cast<std::size_t>(picture.width()) * sizeof(Level));
  std::uint8_t* at = cdr.add_bytes(picture.pixel_count() * sizeof(Level)).data();

  for (const Pixel pixel : picture) {
    const Level level = level_of(pixel);
    std::memcpy(at, &level, sizeof level);
    at += sizeof level;
  }
}

void write_camera_info(const Lens& lens, Size size, const RosHeader& header, RosMessage& message) {
  const auto& D = lens.distortion.coefficients;
  const auto any_from = [&](std::size_t first) {
    return std::ranges::any_of(std::span(D).subspan(first), [](double d) { return d != 0; });
  };

  // ROS's plumb_bob model has five coefficients, rational_polynomial eight; OpenCV also reads 12
  // and 14.
  const std::size_t count = any_from(12) ? 14 : any_from(8) ? 12 : any_from(5) ? 8 : 5;

  Cdr cdr = begin_picture(message, header, size);
  cdr.add_text(count == 5 ? "plumb_bob" : "rational_polynomial").add_count(count);
  for (std::size_t i = 0; i < count; ++i) cdr.add(D[i]);

  // K, R and P: the projection equals the intrinsics, since frames are not rectified.
  const auto add_rows = [&](const auto& matrix) {
    for (const double number : matrix.template reshaped<Eigen::RowMajor>()) cdr.add(number);
  };
  Eigen::Matrix<double, 3, 4> projection = Eigen::Matrix<double, 3, 4>::Zero();
  projection.leftCols<3>() = lens.intrinsic;

  add_rows(lens.intrinsic);
  add_rows(Eigen::Matrix3d(Eigen::Matrix3d::Identity()));  // no rectifying rotation
  add_rows(projection);

  for (int i = 0; i < 2 + 4; ++i) cdr.add(std::uint32_t{0});  // no binning, full sensor
  cdr.add(std::uint8_t{0});
}

/// Returns the name of the frame.
std::string_view read_header(CdrReader& cdr) {
  cdr.count();  // seconds
  cdr.count();
  return cdr.text();
}

/// The frame of that name, whose place the message does not tell; null for the camera's, or if it
/// has no name that files can have.
std::shared_ptr<const FramePose> frame_named(std::string_view name) {
  if (name == camera_frame) return nullptr;
  try {
    require_frame_name(name);
  } catch (const Error&) {
    return nullptr;
  }
  return std::make_shared<const FramePose>(FramePose{std::string(camera_frame), std::string(name)});
}

/// Offset of each known field within a point, if it is there.
struct FieldOffsets {
  std::array<std::optional<std::uint32_t>, point_fields.size()> numbers{};
  std::optional<std::uint32_t> colour{};
};

FieldOffsets read_offsets(CdrReader& cdr, std::uint32_t fields) {
  FieldOffsets offsets;
  for (std::uint32_t i = 0; i < fields; ++i) {
    const std::string_view name = cdr.text();
    const std::uint32_t offset = cdr.count();
    const auto type = cdr.get<std::uint8_t>();
    cdr.count();  // count; only the first is used

    const auto known = std::ranges::find(point_fields, name, &PointField::name);
    if (type == float32 && known != point_fields.end()) {
      offsets.numbers.at(static_cast<std::size_t>(known - point_fields.begin())) = offset;
    }
    if (name == colour_field && (type == float32 || type == uint32)) offsets.colour = offset;
  }

  return offsets;
}

/// Where the points of a message lie.
struct PointLayout {
  std::string_view frame;
  std::uint32_t width, height;
  FieldOffsets offsets;
  bool big_endian;
  std::uint32_t step, row_step;  ///< bytes from point to point and from row to row
  std::span<const std::uint8_t> data;
};

PointLayout read_layout(std::span<const std::uint8_t> message) {
  CdrReader cdr(message);
  const std::string_view frame = read_header(cdr);
  const std::uint32_t height = cdr.count(), width = cdr.count(), fields = cdr.count();
  const FieldOffsets offsets = read_offsets(cdr, fields);
  const bool big_endian = cdr.get<std::uint8_t>() != 0;
  const std::uint32_t step = cdr.count(), row_step = cdr.count();

  return {frame, width, height, offsets, big_endian, step, row_step, cdr.list()};
}

/// Throws Error unless x, y and z are there, and fields and rows lie within the data.
void require_readable(const PointLayout& layout) {
  const auto lies_in_point = [step = layout.step](const std::optional<std::uint32_t>& offset) {
    return !offset || (step >= sizeof(float) && *offset <= step - sizeof(float));
  };

  const std::uint64_t points = std::uint64_t{layout.width} * layout.height;
  const auto& numbers = layout.offsets.numbers;
  throw_if(layout.big_endian || !numbers[0] || !numbers[1] || !numbers[2] || points == 0 ||
               !std::ranges::all_of(numbers, lies_in_point) ||
               !lies_in_point(layout.offsets.colour) || points > largest_picture ||
               layout.row_step < std::uint64_t{layout.width} * layout.step ||
               layout.data.size() < std::uint64_t{layout.row_step} * layout.height,
           "cloud without little-endian 32-bit float x, y, z fields");
}

/// Calls `take` with four bytes of each point at that offset.
template <class Take>
void for_each_value(const PointLayout& layout, std::uint32_t offset, const Take& take) {
  for (std::uint32_t row = 0; row < layout.height; ++row) {
    const std::uint8_t* at = layout.data.data() + std::uint64_t{row} * layout.row_step + offset;
    for (std::uint32_t column = 0; column < layout.width; ++column, at += layout.step) take(at);
  }
}

/// Copies a field of all points, in mm.
void copy_field(const PointLayout& layout, std::size_t field, Image<float>& image) {
  float* to = image.begin();
  for_each_value(layout, *layout.offsets.numbers[field], [&](const std::uint8_t* at) {
    std::memcpy(to, at, sizeof *to);
    *to++ *= point_fields[field].millimetres;
  });
}

/// The colours of all points, packed as blue, green, red and 0.
Image<Colour> colours_of(const PointLayout& layout, Size size) {
  Image<Colour> colours(size);
  Colour* to = colours.begin();
  for_each_value(layout, *layout.offsets.colour, [&](const std::uint8_t* at) {
    *to++ = {at[2], at[1], at[0]};
  });
  return colours;
}

/// Points that are not finite are missing.
void set_validity(Cloud& cloud) {
  for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
    if (std::isfinite(cloud.x(column, row)) && std::isfinite(cloud.y(column, row)) &&
        std::isfinite(cloud.z(column, row))) {
      cloud.validity(column, row) = Validity::valid;
    } else {
      cloud.reject(column, row, Validity::no_point);
    }
  });
}

}  // namespace

RosType point_cloud_type() {
  return {"sensor_msgs/msg/PointCloud2",
          "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\n"
          "bool is_bigendian\nuint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n" +
              header_definition() +
              named_definition("sensor_msgs/PointField",
                               "string name\nuint32 offset\nuint8 datatype\nuint32 count\n")};
}

RosType image_type() {
  return {"sensor_msgs/msg/Image",
          "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\n"
          "uint8 is_bigendian\nuint32 step\nuint8[] data\n" +
              header_definition()};
}

CloudTopic image_topic() {
  return {"image", image_type(), [](const PublishedCloud& of, RosMessage& message) {
            if (!of.cloud.cloud.z.empty()) return write_image(of.cloud.cloud, of.header, message);
            write_image(*of.cloud.frames.front(), of.header, message);
          }};
}

CloudTopic points_topic() {
  return {"points", point_cloud_type(), [](const PublishedCloud& of, RosMessage& message) {
            const bool is_known = of.run.uncertainty && !of.alone;
            auto sigma = is_known ? of.run.uncertainty(of.cloud) : std::nullopt;
            Uncertainty* const known = sigma ? &*sigma : nullptr;
            if (!of.run.frame) {
              return write_point_cloud(of.cloud.points(), of.header, message, known);
            }

            // Other sinks take the cloud too, so a copy moves to the frame of the points.
            Cloud moved = of.cloud.points();
            move_to_frame(moved, *of.run.frame, known);
            write_point_cloud(moved, {of.header.time, of.run.frame->to}, message, known);
          }};
}

CloudTopic depth_topic() {
  return {"depth", image_type(), [](const PublishedCloud& of, RosMessage& message) {
            const auto metres = [](float z) { return z / 1000; };
            write_picture(of.cloud.cloud.z, "32FC1", metres, of.header, message);
          }};
}

CloudTopic camera_info_topic() {
  return {"camera_info",
          {"sensor_msgs/msg/CameraInfo",
           "std_msgs/Header header\nuint32 height\nuint32 width\nstring distortion_model\n"
           "float64[] d\nfloat64[9] k\nfloat64[9] r\nfloat64[12] p\nuint32 binning_x\n"
           "uint32 binning_y\nsensor_msgs/RegionOfInterest roi\n" +
               header_definition() +
               named_definition("sensor_msgs/RegionOfInterest",
                                "uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\n"
                                "bool do_rectify\n")},
          [](const PublishedCloud& of, RosMessage& message) {
            write_camera_info(of.run.camera, of.cloud.cloud.size(), of.header, message);
          }};
}

void write_point_cloud(const Cloud& cloud, const RosHeader& header, RosMessage& message,
                       const Uncertainty* uncertainty) {
  const std::size_t fields = uncertainty == nullptr ? 4 : point_fields.size();
  const bool coloured = !cloud.colour.empty();
  const std::size_t point_bytes = (fields + (coloured ? 1 : 0)) * sizeof(float);
  const std::size_t points = cloud.z.pixel_count();
  const auto width = static_cast<std::size_t>(cloud.size().width);

  // 1. The fields of a point, all floats.
  Cdr cdr = begin_picture(message, header, cloud.size());
  cdr.add_count(fields + (coloured ? 1 : 0));
  const auto add_field = [&](std::string_view name, std::size_t i) {
    cdr.add_text(name).add(static_cast<std::uint32_t>(4 * i)).add(float32).add(std::uint32_t{1});
  };
  for (std::size_t i = 0; i < fields; ++i) add_field(point_fields[i].name, i);
  if (coloured) add_field(colour_field, fields);

  // 2. The points. ROS has metres.
  cdr.add(std::uint8_t{0}).add_count(point_bytes).add_count(width * point_bytes);
  std::uint8_t* at = cdr.add_bytes(points * point_bytes).data();
  for (std::size_t i = 0; i < points; ++i, at += point_bytes) {
    const std::array<float, 4> point{cloud.x.begin()[i] / 1000, cloud.y.begin()[i] / 1000,
                                     cloud.z.begin()[i] / 1000, cloud.intensity.begin()[i]};
    std::memcpy(at, point.data(), sizeof point);

    if (coloured) {
      const float packed = packed_colour(cloud.colour.begin()[i]);
      std::memcpy(at + fields * sizeof(float), &packed, sizeof packed);
    }

    if (uncertainty == nullptr) continue;
    const std::array<float, 4> sigma{
        uncertainty->coordinate.begin()[i], uncertainty->x.begin()[i] / 1000,
        uncertainty->y.begin()[i] / 1000, uncertainty->z.begin()[i] / 1000};
    std::memcpy(at + sizeof point, sigma.data(), sizeof sigma);
  }

  cdr.add(std::uint8_t{0});  // not dense: some points are NaN
}

StoredCloud read_point_cloud(std::span<const std::uint8_t> message) {
  // Check the layout before memory is allocated.
  const PointLayout layout = read_layout(message);
  require_readable(layout);

  const Size size{static_cast<int>(layout.width), static_cast<int>(layout.height)};
  StoredCloud stored{.cloud = Cloud(size), .organised = layout.height > 1};
  stored.cloud.frame = frame_named(layout.frame);

  // Without uncertainty its images are empty and left out.
  if (layout.offsets.numbers.back()) stored.uncertainty.emplace(size);
  Uncertainty none;
  Uncertainty& sigma = stored.uncertainty ? *stored.uncertainty : none;

  const std::array<Image<float>*, point_fields.size()> images{
      &stored.cloud.x,   &stored.cloud.y, &stored.cloud.z, &stored.cloud.intensity,
      &sigma.coordinate, &sigma.x,        &sigma.y,        &sigma.z};

  for (std::size_t field = 0; field < images.size(); ++field) {
    if (!layout.offsets.numbers[field] || images[field]->empty()) continue;
    copy_field(layout, field, *images[field]);
  }
  if (layout.offsets.colour) stored.cloud.colour = colours_of(layout, size);

  set_validity(stored.cloud);
  return stored;
}

std::uint64_t world_time(std::chrono::steady_clock::time_point time) {
  // The steady clock has no date: count back from now.
  const auto age = std::chrono::steady_clock::now() - time;
  const auto since_1970 = (std::chrono::system_clock::now() - age).time_since_epoch();
  return static_cast<std::uint64_t>(std::chrono::nanoseconds(since_1970).count());
}

void write_image(const Frame& frame, const RosHeader& header, RosMessage& message) {
  std::visit(
      [&]<class Pixel>(const Image<Pixel>& pixels) {
        write_picture(
            pixels, sizeof(Pixel) == 1 ? "mono8" : "mono16", [](Pixel pixel) { return pixel; },
            header, message);
      },
      frame.pixels);
}

void write_image(const Cloud& cloud, const RosHeader& header, RosMessage& message) {
  if (cloud.colour.empty()) {
    return write_picture(cloud.intensity, "mono8", grey_level, header, message);
  }
  write_picture(cloud.colour, "rgb8", std::identity(), header, message);
}

Frame read_frame(std::span<const std::uint8_t> message, int bits) {
  CdrReader cdr(message);
  read_header(cdr);
  const std::uint32_t height = cdr.count(), width = cdr.count();
  const std::string_view encoding = cdr.text();
  const bool big_endian = cdr.get<std::uint8_t>() != 0;

  const std::uint64_t row = std::uint64_t{width} * (bits > 8 ? 2 : 1), step = cdr.count();
  const auto data = cdr.list();

  throw_if(big_endian || encoding != (bits > 8 ? "mono16" : "mono8") || width == 0 || height == 0 ||
               std::uint64_t{width} * height > largest_picture || step != row ||
               data.size() != row * height,
           "frame is not a {}-bit grey picture", bits);

  Frame frame({{static_cast<int>(width), static_cast<int>(height)}, bits});
  std::visit([&](auto& pixels) { std::memcpy(pixels.begin(), data.data(), data.size()); },
             frame.pixels);
  return frame;
}

}  // namespace slipstream
