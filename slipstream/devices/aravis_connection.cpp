#include "slipstream/devices/aravis_connection.h"

#include <array>
#include <cstring>
#include <utility>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/devices/gige_sockets.h"

namespace slipstream {
namespace {

constexpr int aravis_buffer_count = 32;
/// Of the socket. Below a few frames' worth the kernel drops packets while the thread that fetches
/// them has to wait for a core.
constexpr int socket_buffer_bytes = 4 << 20;

/// Makes calls that may be refused, and says of which thing.
class Settings {
 public:
  Settings(ArvCamera* camera, std::string name) : camera_(camera), name_(std::move(name)) {}

  template <class Call, class... Values>
  void operator()(const std::string& what, Call call, Values... values) const {
    GErrorReceiver error;
    call(camera_, values..., error.out());
    if (error) {
      throw Error(fmt::format("camera {} does not take {}: {}", name_, what, error.message()));
    }
  }

 private:
  ArvCamera* camera_;
  std::string name_;
};

/// How Aravis asks for, bounds and sets one of the controls, and its unit in ours.
struct ControlCalls {
  double (*get)(ArvCamera*, GError**);
  void (*bounds)(ArvCamera*, double*, double*, GError**);
  void (*set)(ArvCamera*, double, GError**);
  double unit;
  const char* name;
};

const ControlCalls& calls_of(CameraControl which) {
  static constexpr std::array<ControlCalls, 3> calls{
      {{arv_camera_get_exposure_time, arv_camera_get_exposure_time_bounds,
        arv_camera_set_exposure_time, 1e-3, "an exposure of {} ms"},
       {arv_camera_get_gain, arv_camera_get_gain_bounds, arv_camera_set_gain, 1, "a gain of {}"},
       {arv_camera_get_frame_rate, arv_camera_get_frame_rate_bounds, arv_camera_set_frame_rate, 1,
        "{} frames per second"}}};
  return calls.at(static_cast<std::size_t>(which));
}

GObjectPointer<GInetAddress> inet_address(GSocketAddress* address) {
  if (address == nullptr || !G_IS_INET_SOCKET_ADDRESS(address)) return nullptr;
  GInetAddress* inet = g_inet_socket_address_get_address(G_INET_SOCKET_ADDRESS(address));
  return GObjectPointer<GInetAddress>(
      static_cast<GInetAddress*>(g_object_ref(static_cast<gpointer>(inet))));
}

/// Of a GigE camera, in the host's byte order.
std::uint32_t ipv4_address(ArvCamera* camera) {
  const GObjectPointer<GInetAddress> inet =
      inet_address(arv_gv_device_get_device_address(ARV_GV_DEVICE(arv_camera_get_device(camera))));
  std::uint32_t address = 0;
  if (inet && g_inet_address_get_native_size(inet.get()) == sizeof(address)) {
    std::memcpy(&address, g_inet_address_to_bytes(inet.get()), sizeof(address));
  }
  return g_ntohl(address);
}

}  // namespace

AravisConnection::AravisConnection(const std::string& name, const CameraSettings& settings,
                                   const CameraAddress& address)
    : name_(name.empty() ? "(the first found)" : name) {
  GErrorReceiver error;
  if (address) {
    const GObjectPointer<ArvDevice> device(
        arv_gv_device_new(address.interface.get(), address.device.get(), error.out()));
    if (device) camera_.reset(arv_camera_new_with_device(device.get(), error.out()));
  } else {
    camera_.reset(arv_camera_new(name.empty() ? nullptr : name.c_str(), error.out()));
  }
  if (!camera_) {
    throw WorldError(fmt::format("camera {} does not answer: {}", name_,
                                 error ? error.message() : "there is none"));
  }
  set_up(settings);
}

void AravisConnection::set_up(const CameraSettings& settings) {
  const Settings set(camera_.get(), name_);
  watch();
  arv_camera_gv_set_stream_options(camera_.get(), ARV_GV_STREAM_OPTION_PACKET_SOCKET_DISABLED);
  set("continuous frames", arv_camera_set_acquisition_mode, ARV_ACQUISITION_MODE_CONTINUOUS);
  if (const auto& region = settings.region) {
    set(fmt::format("the region {},{} {}x{}", region->x, region->y, region->size.width,
                    region->size.height),
        arv_camera_set_region, region->x, region->y, region->size.width, region->size.height);
  }
  const std::string pixel_format(name_of(settings.pixel_format));
  set("pixels as " + pixel_format, arv_camera_set_pixel_format_from_string, pixel_format.c_str());
  if (settings.trigger.empty()) {
    GErrorReceiver ignored;  // a camera without triggers has none to clear
    arv_camera_clear_triggers(camera_.get(), ignored.out());
    if (settings.frame_rate) {
      set(fmt::format("{} frames per second", *settings.frame_rate), arv_camera_set_frame_rate,
          *settings.frame_rate);
    }
    ask_period();
  } else {
    set("the trigger " + settings.trigger, arv_camera_set_trigger, settings.trigger.c_str());
  }
  if (settings.exposure) set_control(CameraControl::exposure, *settings.exposure * 1e3);
  if (settings.gain) set_control(CameraControl::gain, *settings.gain);
  if (arv_camera_is_gv_device(camera_.get()) != 0) {
    if (settings.packet_size > 0) {
      set(fmt::format("packets of {} bytes", settings.packet_size), arv_camera_gv_set_packet_size,
          settings.packet_size);
    } else {
      GErrorReceiver ignored;  // a camera that cannot try keeps its own size
      arv_camera_gv_auto_packet_size(camera_.get(), ignored.out());
    }
  }
  int x = 0, y = 0;
  set("the question for its region", arv_camera_get_region, &x, &y, &size_.width, &size_.height);
}

void AravisConnection::watch() {
  using Lost = std::shared_ptr<std::atomic<bool>>;
  const auto handler = [](ArvDevice*, gpointer lost) { *static_cast<Lost*>(lost)->get() = true; };
  const auto forget = [](gpointer lost, GClosure*) { delete static_cast<Lost*>(lost); };
  auto kept = std::make_unique<Lost>(lost_);
  g_signal_connect_data(arv_camera_get_device(camera_.get()), "control-lost",
                        reinterpret_cast<GCallback>(+handler), kept.release(), +forget,
                        static_cast<GConnectFlags>(0));
}

void AravisConnection::start() {
  const auto fail = [&](const GErrorReceiver& error) {
    throw WorldError(fmt::format("camera {} gives no frames: {}", name_, error.message()));
  };
  GErrorReceiver error;
  stream_.reset(arv_camera_create_stream(camera_.get(), nullptr, nullptr, error.out()));
  if (!stream_) fail(error);
  if (ARV_IS_GV_STREAM(stream_.get())) {
    g_object_set(stream_.get(), "socket-buffer", ARV_GV_STREAM_SOCKET_BUFFER_FIXED,
                 "socket-buffer-size", socket_buffer_bytes, nullptr);
  }
  const std::uint32_t payload = arv_camera_get_payload(camera_.get(), error.out());
  if (error) fail(error);
  // Before there are buffers: until then no packet is looked into.
  if (ARV_IS_GV_STREAM(stream_.get())) limit_stream(payload);
  for (int i = 0; i < aravis_buffer_count; ++i) {
    arv_stream_push_buffer(stream_.get(), arv_buffer_new_allocate(payload));
  }
  arv_camera_start_acquisition(camera_.get(), error.out());
  if (error) fail(error);
}

void AravisConnection::limit_stream(std::uint32_t payload) {
  constexpr int least_packet = 100;
  GErrorReceiver error;
  const int packet = arv_camera_gv_get_packet_size(camera_.get(), error.out());
  if (error || packet < least_packet ||
      !pass_pictures_only({.port = arv_gv_stream_get_port(ARV_GV_STREAM(stream_.get())),
                           .camera = ipv4_address(camera_.get()),
                           .packet_size = static_cast<std::uint32_t>(packet),
                           .picture_bytes = payload})) {
    throw WorldError(fmt::format("camera {}: what its stream takes cannot be limited", name_));
  }
}

void AravisConnection::stop() {
  GErrorReceiver ignored;  // of a camera that is gone
  if (stream_ && !is_lost()) arv_camera_stop_acquisition(camera_.get(), ignored.out());
  stream_.reset();
}

void AravisConnection::trigger() {
  GErrorReceiver ignored;  // a trigger that did not arrive gives no frame, which is seen
  arv_camera_software_trigger(camera_.get(), ignored.out());
}

std::optional<ControlValue> AravisConnection::control(CameraControl which) const {
  const ControlCalls& calls = calls_of(which);
  GErrorReceiver error;
  ControlValue found{.value = calls.get(camera_.get(), error.out())};
  if (error) return std::nullopt;
  calls.bounds(camera_.get(), &found.least, &found.most, error.out());
  if (error || !(found.least < found.most)) return std::nullopt;
  return ControlValue{calls.unit * found.value, calls.unit * found.least, calls.unit * found.most};
}

void AravisConnection::set_control(CameraControl which, double value) {
  const ControlCalls& calls = calls_of(which);
  const Settings set(camera_.get(), name_);
  set(fmt::format(fmt::runtime(calls.name), value), calls.set, value / calls.unit);
  if (period_seconds_ > 0) ask_period();
}

void AravisConnection::ask_period() {
  GErrorReceiver ignored;
  const double rate = arv_camera_get_frame_rate(camera_.get(), ignored.out());
  if (rate > 0) period_seconds_ = 1 / rate;
}

GObjectPointer<ArvBuffer> AravisConnection::pop(std::chrono::microseconds timeout) const {
  return GObjectPointer<ArvBuffer>(arv_stream_timeout_pop_buffer(
      stream_.get(), static_cast<std::uint64_t>(std::max<std::int64_t>(0, timeout.count()))));
}

void AravisConnection::push(GObjectPointer<ArvBuffer> buffer) const {
  arv_stream_push_buffer(stream_.get(), buffer.release());
}

std::uint64_t AravisConnection::first_number() const {
  return arv_camera_is_gv_device(camera_.get()) != 0 ? 1 : 0;
}

std::uint64_t AravisConnection::resent_packets() const {
  if (!stream_ || !ARV_IS_GV_STREAM(stream_.get())) return 0;
  return arv_stream_get_info_uint64_by_name(stream_.get(), "n_resent_packets");
}

CameraAddress AravisConnection::address() const {
  if (arv_camera_is_gv_device(camera_.get()) == 0) return {};
  ArvGvDevice* device = ARV_GV_DEVICE(arv_camera_get_device(camera_.get()));
  return {inet_address(arv_gv_device_get_interface_address(device)),
          inet_address(arv_gv_device_get_device_address(device))};
}

}  // namespace slipstream
