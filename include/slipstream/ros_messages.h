#pragma once

#include <chrono>
#include <cstring>

#include "slipstream/cloud_file.h"
#include "slipstream/cloud_sink.h"
#include "slipstream/error.h"
#include "slipstream/numbers.h"
#include "slipstream/scanner.h"

namespace slipstream {

/// A ROS 2 message in little-endian CDR.
using RosMessage = std::vector<std::uint8_t>;

struct RosHeader {
  std::uint64_t time;  ///< Unix time in ns
  std::string_view frame_id = camera_frame;
};

/// Appends numbers and texts with CDR alignment.
class Cdr {
 public:
  /// Restarts the message, reusing its memory.
  explicit Cdr(RosMessage& message) : message_(message) {
    message_.assign({0, 1, 0, 0});  // CDR, little-endian
  }

  template <class Number>
  Cdr& add(Number number) {
    const std::size_t at = message_.size() + (4 - message_.size()) % sizeof number;
    message_.resize(at + sizeof number);
    std::memcpy(&message_[at], &number, sizeof number);
    return *this;
  }

  /// A count or a length.
  Cdr& add_count(std::size_t count) { return add(static_cast<std::uint32_t>(count)); }
  Cdr& add_text(std::string_view text) {
    add_count(text.size() + 1);
    message_.insert(message_.end(), text.begin(), text.end());
    message_.push_back(0);
    return *this;
  }

  /// Seconds and nanoseconds.
  Cdr& add_time(std::uint64_t nanoseconds) {
    constexpr std::uint64_t second = 1'000'000'000;
    add(static_cast<std::int32_t>(nanoseconds / second));
    return add(static_cast<std::uint32_t>(nanoseconds % second));
  }

  /// Appends a list of this many bytes; fill it before appending more.
  std::span<std::uint8_t> add_bytes(std::size_t count) {
    add_count(count);
    message_.resize(message_.size() + count);
    return std::span(message_).last(count);
  }

 private:
  RosMessage& message_;
};

/// Reads numbers and texts from untrusted bytes. Throws Error if they end too soon.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  [[nodiscard]] std::size_t left() const { return bytes_.size() - at_; }

  std::span<const std::uint8_t> take(std::uint64_t count) {
    if (count > left()) throw Error("it ends too soon");
    at_ += count;
    return bytes_.subspan(at_ - count, count);
  }

  template <class Number>
  Number get() {
    return number_at<Number>(take(sizeof(Number)), 0);
  }

  /// A text after its 32-bit length.
  std::string_view text() {
    const auto letters = take(get<std::uint32_t>());
    return {reinterpret_cast<const char*>(letters.data()), letters.size()};
  }

  /// Skips to the next multiple of `size` from the beginning.
  void align(std::size_t size) { take((size - at_ % size) % size); }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

/// Reads an untrusted CDR message. The constructor throws Error if it is not little-endian CDR.
class CdrReader : private ByteReader {
 public:
  explicit CdrReader(std::span<const std::uint8_t> message) : ByteReader(content_of(message)) {}

  template <class Number>
  Number get() {
    align(sizeof(Number));
    return ByteReader::get<Number>();
  }

  std::uint32_t count() { return get<std::uint32_t>(); }

  std::string_view text() {
    align(4);
    const std::string_view text = ByteReader::text();
    return text.substr(0, text.find('\0'));
  }

  /// A list of numbers of this many bytes each.
  std::span<const std::uint8_t> list(std::size_t size = 1) {
    const std::uint64_t numbers = count();
    if (numbers > 0) align(size);
    return take(numbers * size);
  }

 private:
  static std::span<const std::uint8_t> content_of(std::span<const std::uint8_t> message) {
    if (message.size() < 4 || message[0] != 0 || message[1] != 1) {
      throw Error("message is not little-endian CDR");
    }
    return message.subspan(4);
  }
};

/// A message type, e.g. "sensor_msgs/msg/Image", and its definition with the types it uses.
struct RosType {
  std::string name;
  std::string definition;
};

RosType point_cloud_type();
RosType image_type();

/// Unix time in ns of a time on this machine's steady clock.
std::uint64_t world_time(std::chrono::steady_clock::time_point time);

/// Arguments of CloudSink::put, and the header of the cloud's messages.
struct PublishedCloud {
  const LiveCloud& cloud;
  const PublishedRun& run;
  bool alone = false;
  RosHeader header{world_time(cloud.newest.host_time), run.frame_id};
};

/// A topic published for each cloud.
struct CloudTopic {
  std::string name;
  RosType type;
  /// Writes the cloud's message, reusing its memory.
  void (*write)(const PublishedCloud& published, RosMessage& message);
};

/// "image": the cloud's intensity as mono8; without a scanner, the window's first frame.
CloudTopic image_topic();
/// "points": write_point_cloud, with the uncertainty, if known and if not sent `alone`.
CloudTopic points_topic();
/// "depth": sensor_msgs/msg/Image as 32FC1, metres, like write_point_cloud.
CloudTopic depth_topic();
/// "camera_info": sensor_msgs/msg/CameraInfo of the run's camera at the cloud's size.
CloudTopic camera_info_topic();

/// All write into `message`, reusing its memory.

/// sensor_msgs/msg/PointCloud2 of 32-bit floats, organised like the camera's pixels: x, y, z in
/// metres (the cloud's millimetres divided by 1000), NaN if invalid; intensity in grey levels of
/// 255; with uncertainty also sigma_coordinate, sigma_x, sigma_y and sigma_z.
void write_point_cloud(const Cloud& cloud, const RosHeader& header, RosMessage& message,
                       const Uncertainty* uncertainty = nullptr);

/// sensor_msgs/msg/Image: a camera's frame, mono8 or mono16.
void write_image(const Frame& frame, const RosHeader& header, RosMessage& message);
/// sensor_msgs/msg/Image of a cloud's intensity, mono8.
void write_image(const Cloud& cloud, const RosHeader& header, RosMessage& message);

/// Reads the fields of write_point_cloud from any PointCloud2, converted to mm. Throws Error,
/// without a file name, if it is not a PointCloud2, has no 32-bit float x, y, z, or is not little-
/// endian.
StoredCloud read_point_cloud(std::span<const std::uint8_t> message);
/// The frame of an Image with this bit depth, without its timestamp. Throws Error without a file
/// name.
Frame read_frame(std::span<const std::uint8_t> message, int bits);

struct RosService {
  std::string name;  ///< "scanner/capture"
  std::string type;  ///< "std_srvs/srv/Trigger"
  /// Reads the request and appends the answer. Throws Error for an invalid request.
  std::function<void(CdrReader& request, Cdr& answer)> answer;
};

/// Appends a Trigger or SetParametersResult: true and the result of `work`, or false and its error.
template <class Work>
void add_outcome(Cdr& answer, const Work& work) {
  std::string text;
  bool success = false;

  try {
    text = work();
    success = true;
  } catch (const std::exception& error) {
    text = error.what();
  }

  answer.add(static_cast<std::uint8_t>(success)).add_text(text);
}

/// The services by which ROS 2 reads and changes a node's parameters: the settings of the borrowed
/// run. Numbers are doubles (integers are accepted), switches booleans, everything else text.
std::vector<RosService> parameter_services(const std::string& node, const PublishedRun& run);

/// rcl_interfaces/msg/ParameterEvent: new, changed and removed settings. Returns false if there are
/// none.
bool write_parameter_event(const std::string& node, std::uint64_t time,
                           const std::vector<RunSetting>& before,
                           const std::vector<RunSetting>& now, RosMessage& message);

}  // namespace slipstream
