#include "devices/genicam.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <exception>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "base/system_failure.h"
#include "devices/aravis_connection-inl.h"
#include "devices/camera_source.h"
#include "frames/mosaic.h"

namespace slipstream {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;
using namespace std::chrono_literals;

/// A GenICam camera over GigE Vision or USB3 Vision. Sequence: the camera's own frame count, from 0
/// at the start; device time: the camera's clock; host time: when the frame is fetched. A lost
/// camera is searched for until it is back, without an error: `state` reports it meanwhile.
class AravisSource final : public CameraSource<AravisConnection> {
 public:
  AravisSource(const std::string& name, const CameraSettings& settings)
      : AravisSource(name, settings, std::make_shared<AravisConnection>(name, settings)) {}

  ~AravisSource() override { AravisSource::stop(); }

  void start() override {
    // It was lost when stopped, and is still gone if it cannot be opened or started.
    const bool gone = !connection_;
    auto connection = gone ? open_again() : connection_;
    connection->start();
    if (gone) regain(std::move(connection));
    begin();
  }

  void stop() override {
    if (seeking_.valid()) bury(seeking_.get());
    if (connection_) connection_->stop();
  }

  void trigger() override {
    if (settings_.trigger != "Software") return;
    if (const auto connection = shared_connection()) connection->trigger();
  }

  [[nodiscard]] std::optional<ControlValue> control(CameraControl which) const override {
    const bool triggered = !settings_.trigger.empty();
    if (triggered && which == CameraControl::frame_rate) return std::nullopt;
    return CameraSource::control(which);
  }

  [[nodiscard]] Temperatures temperatures() const override {
    const auto connection = shared_connection();
    return connection ? connection->temperatures() : Temperatures();
  }

  Arrival next(Frame& frame, milliseconds timeout) override {
    if (!connection_) return seek(timeout);

    const steady_clock::time_point end = steady_clock::now() + timeout;
    // Waits in short steps, so that a lost camera is noticed early.
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

      // Lost. The next connection counts its resent packets from 0 again.
      if (connection_->is_lost() || steady_clock::now() - last_heard_ > longest_silence()) {
        resent_before_ += resent_.exchange(0);
        bury(lose());
        return Arrival::nothing;
      }
    } while (steady_clock::now() < end);
    return Arrival::nothing;
  }

  [[nodiscard]] SourceCounters counters() const override {
    SourceCounters counters = CameraSource::counters();
    counters.resent = resent_before_ + resent_;
    return counters;
  }

 private:
  AravisSource(const std::string& name, const CameraSettings& settings,
               const std::shared_ptr<AravisConnection>& connection)
      : CameraSource(name, settings, connection,
                     {frame_size(connection->size(), settings.pixel_format),
                      bits_of(settings.pixel_format)}),
        address_(connection->address()) {}

  void begin() {
    count_.begin(connection_->first_number());
    first_frame_ = true;
    last_heard_ = steady_clock::now();
  }

  [[nodiscard]] static Size frame_size(Size picture, PixelFormat format) {
    return {values_of(format) * picture.width, picture.height};
  }

  [[nodiscard]] bool fits(Size picture) const {
    return frame_size(picture, settings_.pixel_format) == format_.size;
  }

  /// A free-running camera that is silent for longer is lost; a triggered one may stay silent.
  [[nodiscard]] steady_clock::duration longest_silence() const {
    if (!settings_.trigger.empty()) return std::chrono::hours(24 * 365);
    return std::max<steady_clock::duration>(
        500ms, std::chrono::duration_cast<steady_clock::duration>(5 * connection_->period()));
  }

  Arrival take(ArvBuffer& buffer, Frame& frame) {
    resent_ = connection_->resent_packets();
    if (arv_buffer_get_status(&buffer) != ARV_BUFFER_STATUS_SUCCESS ||
        arv_buffer_get_payload_type(&buffer) != ARV_BUFFER_PAYLOAD_TYPE_IMAGE) {
      // The socket's buffer grows only after the first packet, so the first frame is rarely
      // complete.
      return first_frame_ ? Arrival::nothing : Arrival::damaged;
    }

    const Size size{arv_buffer_get_image_width(&buffer), arv_buffer_get_image_height(&buffer)};
    std::size_t bytes = 0;
    const auto* data = static_cast<const std::uint8_t*>(arv_buffer_get_image_data(&buffer, &bytes));
    if (!fits(size) || data == nullptr) return Arrival::damaged;

    if (frame.format() != format_) frame = Frame(format_);
    if (!unpack(settings_.pixel_format, {data, bytes}, frame)) return Arrival::damaged;
    if (!settings_.mosaic.empty() && !settings_.keep_mosaic) make_grey(frame);

    frame.stamp = {.sequence = count_number(arv_buffer_get_frame_id(&buffer)),
                   .pattern_index = std::nullopt,
                   .device_time = std::chrono::nanoseconds(arv_buffer_get_timestamp(&buffer)),
                   .host_time = steady_clock::now()};
    return Arrival::frame;
  }

  std::uint64_t count_number(std::uint64_t number) {
    // A few cameras continue counting from before the start.
    if (first_frame_ && number > connection_->first_number() + FrameCount::far) {
      count_.begin(number);
    }

    first_frame_ = false;
    return count(number);
  }

  /// Closes the connection on another thread: closing a lost camera takes seconds.
  void bury(std::shared_ptr<AravisConnection> connection) {
    // Forget those that have finished.
    std::erase_if(burials_,
                  [](const auto& done) { return done.wait_for(0s) == std::future_status::ready; });

    burials_.push_back(
        std::async(std::launch::async, [gone = std::move(connection)]() mutable { gone.reset(); }));
  }

  /// Searches for the camera on another thread, which may wait longer than the caller.
  Arrival seek(milliseconds timeout) {
    if (!seeking_.valid()) {
      seeking_ = std::async(std::launch::async, [this] { return connect_again(); });
    }

    if (seeking_.wait_for(timeout) != std::future_status::ready) return Arrival::nothing;

    if (std::shared_ptr<AravisConnection> found = seeking_.get()) {
      regain(std::move(found));
      begin();
    }
    return Arrival::nothing;
  }

  [[nodiscard]] std::shared_ptr<AravisConnection> open_again() const {
    auto found = std::make_shared<AravisConnection>(name_, settings_now(), address_);
    if (fits(found->size())) return found;
    throw WorldError(fmt::format("camera {} is back with frames of another size", name_));
  }

  [[nodiscard]] std::shared_ptr<AravisConnection> connect_again() try {
    std::shared_ptr<AravisConnection> connection = open_again();
    connection->start();
    return connection;
  } catch (const std::exception& error) {
    // A camera that answers but refuses, e.g. as another client controls it.
    const bool refuses = dynamic_cast<const Error*>(&error) != nullptr;
    still_lose(refuses ? error.what() : "");
    std::this_thread::sleep_for(100ms);
    return nullptr;
  }

  const CameraAddress address_;
  bool first_frame_ = true;
  steady_clock::time_point last_heard_;
  std::future<std::shared_ptr<AravisConnection>> seeking_;
  std::vector<std::future<void>> burials_;
  std::atomic<std::uint64_t> resent_before_ = 0, resent_ = 0;
};

}  // namespace

std::unique_ptr<FrameSource> open_genicam_camera(const std::string& name,
                                                 const CameraSettings& settings) {
  return std::make_unique<AravisSource>(name, settings);
}

std::vector<CameraDescription> list_genicam_cameras() {
  const auto text = [](const char* value) { return std::string(value == nullptr ? "" : value); };

  require_descriptors(descriptors_of_aravis, "listing GenICam cameras");
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
