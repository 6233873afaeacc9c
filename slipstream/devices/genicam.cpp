#include "slipstream/devices/genicam.h"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <future>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include <arv.h>
#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/devices/aravis_connection.h"
#include "slipstream/devices/frame_count.h"

namespace slipstream {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;
using namespace std::chrono_literals;

/// A GenICam camera over GigE Vision or USB3 Vision. Sequence: the camera's own count of frames,
/// from 0 at the start; device time: of the camera's clock; host time: when the frame is fetched.
/// A camera that is gone is sought until it is back, without an error: `state` says so meanwhile.
class AravisSource final : public FrameSource, public CameraControls {
 public:
  AravisSource(std::string name, CameraSettings settings)
      : name_(std::move(name)),
        settings_(std::move(settings)),
        connection_(std::make_shared<AravisConnection>(name_, settings_)),
        address_(connection_->address()),
        format_{frame_size(connection_->size()), bits_of(settings_.pixel_format)},
        count_(settings_.cycle) {
    if (settings_.cycle < 1) {
      throw Error(fmt::format("{} patterns in a scan; at least 1", settings_.cycle));
    }
  }
  AravisSource(const AravisSource&) = delete;
  AravisSource& operator=(const AravisSource&) = delete;
  ~AravisSource() override { AravisSource::stop(); }

  [[nodiscard]] bool has_own_pace() const override { return true; }
  CameraControls* controls() override { return this; }

  void start() override {
    if (!connection_) reopen();  // it was gone at the stop
    connection_->start();
    begin();
  }

  void stop() override {
    if (seeking_.valid()) bury(seeking_.get());
    if (connection_) connection_->stop();
  }

  void trigger() override {
    if (settings_.trigger != "Software") return;
    const std::shared_ptr<AravisConnection> connection = shared_connection();
    if (connection) connection->trigger();
  }

  [[nodiscard]] std::optional<ControlValue> control(CameraControl which) const override {
    const bool triggered = !settings_.trigger.empty();
    if (triggered && which == CameraControl::frame_rate) return std::nullopt;
    const std::shared_ptr<AravisConnection> connection = shared_connection();
    return connection ? connection->control(which) : std::nullopt;
  }

  void set_control(CameraControl which, double value) override {
    if (const auto connection = shared_connection()) connection->set_control(which, value);
    const std::lock_guard lock(mutex_);
    asked_for(settings_, which) = which == CameraControl::exposure ? value / 1e3 : value;
  }

  Arrival next(Frame& frame, milliseconds timeout) override {
    if (!connection_) return seek(timeout);
    const steady_clock::time_point end = steady_clock::now() + timeout;
    // A lost camera is noticed within a short wait, however long the caller's.
    do {
      const auto left = std::chrono::ceil<milliseconds>(end - steady_clock::now());
      GObjectPointer<ArvBuffer> buffer =
          connection_->pop(std::clamp<milliseconds>(left, 0ms, 50ms));
      if (buffer) {
        last_heard_ = steady_clock::now();
        const Arrival arrival = take(*buffer, frame);
        connection_->push(std::move(buffer));
        return arrival;
      }
      if (connection_->is_lost() || steady_clock::now() - last_heard_ > longest_silence()) {
        lose();
        return Arrival::nothing;
      }
    } while (steady_clock::now() < end);
    return Arrival::nothing;
  }

  [[nodiscard]] FrameFormat format() const override { return format_; }

  [[nodiscard]] SourceCounters counters() const override {
    return {.delivered = delivered_,
            .lost = lost_,
            .resent = resent_before_ + resent_,
            .reconnects = reconnects_};
  }

  [[nodiscard]] std::string state() const override {
    const std::lock_guard lock(mutex_);
    return state_;
  }

 private:
  [[nodiscard]] std::shared_ptr<AravisConnection> shared_connection() const {
    const std::lock_guard lock(mutex_);
    return connection_;
  }

  void begin() {
    count_.begin(connection_->first_number());
    first_frame_ = true;
    last_heard_ = steady_clock::now();
  }

  /// Of frames with pictures of that size.
  [[nodiscard]] Size frame_size(Size picture) const {
    return {values_of(settings_.pixel_format) * picture.width, picture.height};
  }

  /// A camera that runs freely and has not been heard of for so long is gone, before its protocol
  /// notices that. One that is triggered may be silent for ever.
  [[nodiscard]] steady_clock::duration longest_silence() const {
    if (!settings_.trigger.empty()) return std::chrono::hours(24 * 365);
    return std::max<steady_clock::duration>(
        500ms, std::chrono::duration_cast<steady_clock::duration>(5 * connection_->period()));
  }

  Arrival take(ArvBuffer& buffer, Frame& frame) {
    resent_ = connection_->resent_packets();
    if (arv_buffer_get_status(&buffer) != ARV_BUFFER_STATUS_SUCCESS ||
        arv_buffer_get_payload_type(&buffer) != ARV_BUFFER_PAYLOAD_TYPE_IMAGE) {
      // The socket's buffer grows only when the first packet has come: that frame is seldom whole.
      return first_frame_ ? Arrival::nothing : Arrival::damaged;
    }
    const Size size{arv_buffer_get_image_width(&buffer), arv_buffer_get_image_height(&buffer)};
    std::size_t bytes = 0;
    const auto* data = static_cast<const std::uint8_t*>(arv_buffer_get_image_data(&buffer, &bytes));
    if (frame_size(size) != format_.size || data == nullptr) return Arrival::damaged;
    if (frame.format() != format_) frame = Frame(format_);
    if (!unpack(settings_.pixel_format, {data, bytes}, frame)) return Arrival::damaged;
    frame.stamp = {.sequence = count(arv_buffer_get_frame_id(&buffer)),
                   .pattern_index = std::nullopt,
                   .device_time = std::chrono::nanoseconds(arv_buffer_get_timestamp(&buffer)),
                   .host_time = steady_clock::now()};
    ++delivered_;
    return Arrival::frame;
  }

  std::uint64_t count(std::uint64_t number) {
    // Few cameras count on from the frames before the start.
    if (first_frame_ && number > connection_->first_number() + FrameCount::far) {
      count_.begin(number);
    }
    first_frame_ = false;
    const std::uint64_t sequence = count_(number);
    lost_ = count_.missing();
    return sequence;
  }

  void lose() {
    resent_before_ += resent_.exchange(0);
    std::shared_ptr<AravisConnection> lost;
    {
      const std::lock_guard lock(mutex_);
      lost.swap(connection_);
      state_ = fmt::format("camera {} is gone; looking for it",
                           name_.empty() ? "(the first found)" : name_);
    }
    bury(std::move(lost));
  }

  /// Lets go of a camera elsewhere: saying goodbye to one that is gone takes seconds.
  void bury(std::shared_ptr<AravisConnection> connection) {
    std::erase_if(burials_,
                  [](const auto& done) { return done.wait_for(0s) == std::future_status::ready; });
    burials_.push_back(
        std::async(std::launch::async, [gone = std::move(connection)]() mutable { gone.reset(); }));
  }

  /// Looks for the camera on another thread, which may wait for answers longer than the caller.
  Arrival seek(milliseconds timeout) {
    if (!seeking_.valid()) {
      seeking_ = std::async(std::launch::async, [this] { return connect_again(); });
    }
    if (seeking_.wait_for(timeout) != std::future_status::ready) return Arrival::nothing;
    std::shared_ptr<AravisConnection> found = seeking_.get();
    if (!found) return Arrival::nothing;
    {
      const std::lock_guard lock(mutex_);
      connection_ = std::move(found);
      state_.clear();
    }
    ++reconnects_;
    begin();
    return Arrival::nothing;
  }

  [[nodiscard]] std::shared_ptr<AravisConnection> open_again() const {
    const CameraSettings settings = [this] {
      const std::lock_guard lock(mutex_);
      return settings_;
    }();
    return address_ ? std::make_shared<AravisConnection>(address_, name_, settings)
                    : std::make_shared<AravisConnection>(name_, settings);
  }

  void reopen() {
    std::shared_ptr<AravisConnection> found = open_again();
    if (frame_size(found->size()) != format_.size) {
      throw WorldError(fmt::format("camera {} is back with frames of another size", name_));
    }
    {
      const std::lock_guard lock(mutex_);
      connection_ = std::move(found);
      state_.clear();
    }
    ++reconnects_;
  }

  [[nodiscard]] std::shared_ptr<AravisConnection> connect_again() const {
    try {
      std::shared_ptr<AravisConnection> connection = open_again();
      if (frame_size(connection->size()) != format_.size) return nullptr;
      connection->start();
      return connection;
    } catch (const std::exception&) {
      std::this_thread::sleep_for(100ms);
      return nullptr;
    }
  }

  const std::string name_;
  /// Lights and rate change while frames come, the rest does not.
  CameraSettings settings_;
  mutable std::mutex mutex_;  ///< of connection_ against other threads, of those, and of state_
  std::shared_ptr<AravisConnection> connection_;
  const CameraAddress address_;
  const FrameFormat format_;
  std::string state_;

  FrameCount count_;
  bool first_frame_ = true;
  steady_clock::time_point last_heard_;
  std::future<std::shared_ptr<AravisConnection>> seeking_;
  std::vector<std::future<void>> burials_;

  std::atomic<std::uint64_t> delivered_ = 0;
  std::atomic<std::uint64_t> lost_ = 0;
  std::atomic<std::uint64_t> resent_before_ = 0;
  std::atomic<std::uint64_t> resent_ = 0;
  std::atomic<std::uint64_t> reconnects_ = 0;
};

}  // namespace

std::unique_ptr<FrameSource> open_genicam_camera(const std::string& name,
                                                 const CameraSettings& settings) {
  return std::make_unique<AravisSource>(name, settings);
}

std::vector<CameraDescription> list_genicam_cameras() {
  const auto text = [](const char* value) { return std::string(value == nullptr ? "" : value); };
  arv_update_device_list();
  std::vector<CameraDescription> cameras;
  for (unsigned int i = 0; i < arv_get_n_devices(); ++i) {
    cameras.push_back({.name = text(arv_get_device_id(i)),
                       .vendor = text(arv_get_device_vendor(i)),
                       .model = text(arv_get_device_model(i)),
                       .serial = text(arv_get_device_serial_nbr(i)),
                       .address = text(arv_get_device_address(i)),
                       .protocol = text(arv_get_device_protocol(i))});
  }
  return cameras;
}

}  // namespace slipstream
