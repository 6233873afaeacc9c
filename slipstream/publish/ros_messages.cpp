#include "slipstream/publish/ros_messages.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <span>
#include <string_view>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "slipstream/publish/little_endian.h"

namespace slipstream {
namespace {

constexpr const char* header_definition =
    "\n{0:=>80}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
    "\n{0:=>80}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
constexpr const char* field_definition =
    "\n{0:=>80}\nMSG: sensor_msgs/PointField\nstring name\nuint32 offset\nuint8 datatype\n"
    "uint32 count\n";
constexpr std::uint8_t float32 = 7;  // PointField's number of it
constexpr std::size_t point_bytes = 16;

/// Numbers and texts one after the other, each where CDR aligns it.
class Cdr {
 public:
  explicit Cdr(RosMessage& message) : message_(message) {
    message_.assign({0, 1, 0, 0});  // CDR, little-endian
  }

  template <class Number>
  Cdr& add(Number number) {
    align(sizeof number);
    append(message_, number);
    return *this;
  }
  Cdr& add_text(std::string_view text) {
    add(static_cast<std::uint32_t>(text.size() + 1));
    message_.insert(message_.end(), text.begin(), text.end());
    message_.push_back(0);
    return *this;
  }
  Cdr& add_header(std::uint64_t time) {
    constexpr std::uint64_t second = 1'000'000'000;
    add(static_cast<std::int32_t>(time / second));
    add(static_cast<std::uint32_t>(time % second));
    return add_text("camera");
  }
  /// A list of so many bytes, to be filled before more is added.
  std::span<std::uint8_t> add_bytes(std::size_t count) {
    add(static_cast<std::uint32_t>(count));
    message_.resize(message_.size() + count);
    return std::span(message_).last(count);
  }

 private:
  void align(std::size_t size) {
    message_.resize(message_.size() + (size - (message_.size() - 4) % size) % size);
  }

  RosMessage& message_;
};

template <class Pixel, class Grey>
void add_picture(Cdr& cdr, const Image<Pixel>& picture, std::string_view encoding, Grey grey) {
  using Level = decltype(grey(Pixel{}));
  const auto width = static_cast<std::uint32_t>(picture.size().width);
  cdr.add(static_cast<std::uint32_t>(picture.size().height)).add(width).add_text(encoding);
  cdr.add(std::uint8_t{0}).add(static_cast<std::uint32_t>(width * sizeof(Level)));
  std::uint8_t* at = cdr.add_bytes(picture.pixel_count() * sizeof(Level)).data();
  for (const Pixel pixel : picture) {
    const Level level = grey(pixel);
    std::memcpy(at, &level, sizeof level);
    at += sizeof level;
  }
}

}  // namespace

RosType point_cloud_type() {
  return {"sensor_msgs/msg/PointCloud2",
          "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\n"
          "bool is_bigendian\nuint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n" +
              fmt::format(fmt::runtime(header_definition), "") +
              fmt::format(fmt::runtime(field_definition), "")};
}

RosType image_type() {
  return {"sensor_msgs/msg/Image",
          "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\n"
          "uint8 is_bigendian\nuint32 step\nuint8[] data\n" +
              fmt::format(fmt::runtime(header_definition), "")};
}

void write_point_cloud(const Cloud& cloud, std::uint64_t time, RosMessage& message) {
  constexpr std::array<std::string_view, 4> fields{"x", "y", "z", "intensity"};
  const auto width = static_cast<std::uint32_t>(cloud.size().width);
  Cdr cdr(message);
  cdr.add_header(time).add(static_cast<std::uint32_t>(cloud.size().height)).add(width);
  cdr.add(static_cast<std::uint32_t>(fields.size()));
  for (std::uint32_t i = 0; i < fields.size(); ++i) {
    cdr.add_text(fields[i]).add(4 * i).add(float32).add(std::uint32_t{1});
  }
  cdr.add(std::uint8_t{0}).add(std::uint32_t{point_bytes});
  cdr.add(static_cast<std::uint32_t>(width * point_bytes));
  std::uint8_t* at = cdr.add_bytes(cloud.z.pixel_count() * point_bytes).data();
  for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i, at += point_bytes) {
    const std::array<float, 4> point{cloud.x.begin()[i] / 1000, cloud.y.begin()[i] / 1000,
                                     cloud.z.begin()[i] / 1000, cloud.intensity.begin()[i]};
    std::memcpy(at, point.data(), point_bytes);
  }
  cdr.add(std::uint8_t{0});  // some points are NaN
}

std::uint64_t world_time(std::chrono::steady_clock::time_point time) {
  const auto age = std::chrono::steady_clock::now() - time;
  const auto since_1970 = (std::chrono::system_clock::now() - age).time_since_epoch();
  return static_cast<std::uint64_t>(std::chrono::nanoseconds(since_1970).count());
}

void write_image(const LiveCloud& cloud, std::uint64_t time, RosMessage& message) {
  Cdr cdr(message);
  cdr.add_header(time);
  if (!cloud.cloud.z.empty()) return add_picture(cdr, cloud.cloud.intensity, "mono8", grey_level);
  std::visit(
      [&]<class Pixel>(const Image<Pixel>& pixels) {
        add_picture(cdr, pixels, sizeof(Pixel) == 1 ? "mono8" : "mono16",
                    [](Pixel pixel) { return pixel; });
      },
      cloud.frames.front()->pixels);
}

void write_depth(const Cloud& cloud, std::uint64_t time, RosMessage& message) {
  Cdr cdr(message);
  cdr.add_header(time);
  add_picture(cdr, cloud.z, "32FC1", [](float z) { return z / 1000; });
}

void write_camera_info(const Lens& lens, Size size, std::uint64_t time, RosMessage& message) {
  const auto& D = lens.distortion.coefficients;
  const auto any_from = [&](std::size_t first) {
    return std::any_of(D.begin() + static_cast<std::ptrdiff_t>(first), D.end(),
                       [](double d) { return d != 0; });
  };
  // Of ROS's models the first has five coefficients, the second eight; OpenCV, which reads them,
  // takes 12 and 14 as well.
  const std::size_t count = any_from(12) ? 14 : any_from(8) ? 12 : any_from(5) ? 8 : 5;
  Cdr cdr(message);
  cdr.add_header(time).add(static_cast<std::uint32_t>(size.height));
  cdr.add(static_cast<std::uint32_t>(size.width));
  cdr.add_text(count == 5 ? "plumb_bob" : "rational_polynomial");
  cdr.add(static_cast<std::uint32_t>(count));
  for (std::size_t i = 0; i < count; ++i) cdr.add(D[i]);
  const auto add_rows = [&](const auto& matrix) {
    for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
      for (Eigen::Index column = 0; column < matrix.cols(); ++column) cdr.add(matrix(row, column));
    }
  };
  Eigen::Matrix<double, 3, 4> projection = Eigen::Matrix<double, 3, 4>::Zero();
  projection.leftCols<3>() = lens.intrinsic;
  add_rows(lens.intrinsic);
  add_rows(Eigen::Matrix3d(Eigen::Matrix3d::Identity()));  // rectified is not turned
  add_rows(projection);
  for (int i = 0; i < 2 + 4; ++i) cdr.add(std::uint32_t{0});  // no binning, all of the sensor
  cdr.add(std::uint8_t{0});
}

std::optional<RosRequest> request_in(const RosMessage& message) {
  RosRequest request;
  if (message.size() < 4 + sizeof request || message[0] != 0 || message[1] != 1) return {};
  std::memcpy(&request, message.data() + 4, sizeof request);
  return request;
}

void write_trigger_answer(const RosRequest& request, bool success, std::string_view text,
                          RosMessage& message) {
  Cdr cdr(message);
  cdr.add(request.client).add(request.number);
  cdr.add(static_cast<std::uint8_t>(success)).add_text(text);
}

}  // namespace slipstream
