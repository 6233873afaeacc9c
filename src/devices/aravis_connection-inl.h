#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include <arv.h>

#include "base/numbers.h"
#include "base/system_failure.h"
#include "base/thread_priority.h"
#include "base/throw_if-inl.h"
#include "devices/gige_sockets.h"
#include "slipstream/camera.h"

namespace slipstream {

struct GObjectUnref {
  void operator()(gpointer object) const { g_object_unref(object); }
};

struct GFree {
  void operator()(const char** list) const { g_free(list); }
};

/// Owns one reference to a GObject.
template <class Object>
using GObjectPointer = std::unique_ptr<Object, GObjectUnref>;

/// GLib ends the program if it cannot open its pipes, and Aravis a socket per network interface.
constexpr std::size_t descriptors_of_aravis = 32;

/// Address of a GigE Vision camera, to find it again without searching all networks.
struct CameraAddress {
  GObjectPointer<GInetAddress> interface, device;
};

/// A configured camera, while it answers. If it is gone, the destructor may take seconds.
class AravisConnection {
 public:
  /// Opens by name, or by the address found before. Throws like open_genicam_camera.
  AravisConnection(const std::string& name, const CameraSettings& settings,
                   const CameraAddress& address = {})
      : name_(name.empty() ? "(the first found)" : name) {
    require_descriptors(descriptors_of_aravis, "camera " + name_);
    g_autoptr(GError) error = nullptr;
    if (address.interface && address.device) {
      const GObjectPointer<ArvDevice> device(
          arv_gv_device_new(address.interface.get(), address.device.get(), &error));
      if (device) camera_.reset(arv_camera_new_with_device(device.get(), &error));
    } else {
      camera_.reset(arv_camera_new(name.empty() ? nullptr : name.c_str(), &error));
    }

    if (!camera_) {
      throw WorldError(fmt::format("camera {} does not answer: {}", name_,
                                   error != nullptr ? error->message : "no camera was found"));
    }

    if (arv_camera_is_gv_device(camera_.get()) == 0) watch();
    set_up(settings);
    if (arv_camera_is_gv_device(camera_.get()) != 0) {
      guard_ = std::jthread([this](const std::stop_token& stop) { guard_control(stop); });
    }
  }

  /// Starts the stream. Throws WorldError; then it can be started again.
  void start() try {
    const auto fail = [&](const GError* error) {
      throw WorldError(fmt::format("camera {} gives no frames: {}", name_, error->message));
    };

    constexpr int buffers = 32;
    // Room for a few frames: otherwise the kernel drops packets while the receiving thread waits to
    // run.
    constexpr int socket_buffer_bytes = 4 << 20;

    // 1. Create the stream, which binds its socket.
    g_autoptr(GError) error = nullptr;
    stream_.reset(arv_camera_create_stream(camera_.get(), nullptr, nullptr, &error));
    if (!stream_) fail(error);
    if (ARV_IS_GV_STREAM(stream_.get())) {
      g_object_set(stream_.get(), "socket-buffer", ARV_GV_STREAM_SOCKET_BUFFER_FIXED,
                   "socket-buffer-size", socket_buffer_bytes, nullptr);
    }

    // 2. Hand over buffers of a whole frame.
    const std::uint32_t payload = arv_camera_get_payload(camera_.get(), &error);
    if (error != nullptr) fail(error);
    // Before any buffer exists: until then no packet is parsed.
    if (ARV_IS_GV_STREAM(stream_.get())) limit_stream(payload);

    for (int i = 0; i < buffers; ++i) {
      arv_stream_push_buffer(stream_.get(), arv_buffer_new_allocate(payload));
    }

    // 3. Start the camera.
    arv_camera_start_acquisition(camera_.get(), &error);
    if (error != nullptr) fail(error);
  } catch (const std::exception&) {
    stream_.reset();
    throw;
  }

  void stop() {
    const std::lock_guard lock(nodes_);

    // Errors mean that the camera is gone.
    if (stream_ && !is_lost()) arv_camera_stop_acquisition(camera_.get(), nullptr);
    stream_.reset();
  }

  void trigger() {
    const std::lock_guard lock(nodes_);

    // A lost trigger shows as a missing frame.
    arv_camera_software_trigger(camera_.get(), nullptr);
  }

  /// See CameraControls.
  [[nodiscard]] std::optional<ControlValue> control(CameraControl which) const {
    const ControlCalls& calls = calls_of(which);
    g_autoptr(GError) error = nullptr;
    const std::lock_guard lock(nodes_);

    ControlValue found{.value = calls.get(camera_.get(), &error)};
    if (error != nullptr) return std::nullopt;
    calls.bounds(camera_.get(), &found.least, &found.most, &error);
    if (error != nullptr || !(found.least < found.most)) return std::nullopt;

    return ControlValue{calls.unit * found.value, calls.unit * found.least,
                        calls.unit * found.most};
  }

  void set_control(CameraControl which, double value) {
    const ControlCalls& calls = calls_of(which);
    const std::lock_guard lock(nodes_);
    set(fmt::format(fmt::runtime(calls.name), value), calls.set, value / calls.unit);
    // The frame rate may follow from the exposure, so read it again.
    if (period_seconds_ > 0) ask_period();
  }

  /// See CameraControls. Selects one part after another, if the camera has several.
  [[nodiscard]] Temperatures temperatures() const {
    constexpr const char* selector = "DeviceTemperatureSelector";
    const std::lock_guard lock(nodes_);

    ArvDevice* const device = arv_camera_get_device(camera_.get());
    ArvGcNode* const measured = arv_device_get_feature(device, "DeviceTemperature");
    if (measured == nullptr || !ARV_IS_GC_FEATURE_NODE(measured)) return {};

    Temperatures found;
    const auto read = [&](const char* part) {
      const auto celsius = number_in<double>(value_of(ARV_GC_FEATURE_NODE(measured)));
      if (celsius && std::isfinite(*celsius)) found[part] = *celsius;
    };

    unsigned int count = 0;
    const std::unique_ptr<const char*, GFree> parts(
        arv_device_dup_available_enumeration_feature_values_as_strings(device, selector, &count,
                                                                       nullptr));
    for (unsigned int i = 0; parts && i < count; ++i) {
      const char* const part = parts.get()[i];
      g_autoptr(GError) error = nullptr;
      arv_device_set_string_feature_value(device, selector, part, &error);
      if (error == nullptr) read(part);
    }

    if (found.empty()) read("Camera");
    return found;
  }

  /// The next buffer, null after the timeout. Must be handed back.
  [[nodiscard]] GObjectPointer<ArvBuffer> pop(std::chrono::microseconds timeout) const {
    return GObjectPointer<ArvBuffer>(arv_stream_timeout_pop_buffer(
        stream_.get(), static_cast<std::uint64_t>(std::max<std::int64_t>(0, timeout.count()))));
  }

  void push(GObjectPointer<ArvBuffer> buffer) const {
    arv_stream_push_buffer(stream_.get(), buffer.release());
  }

  /// True once control is lost: another client owns the camera, or it stopped answering.
  [[nodiscard]] bool is_lost() const { return *lost_; }

  [[nodiscard]] Size size() const { return size_; }
  /// The number of the first frame after start().
  [[nodiscard]] std::uint64_t first_number() const {
    return arv_camera_is_gv_device(camera_.get()) != 0 ? 1 : 0;
  }
  /// Frame interval reported by a free-running camera; 0 for triggered ones.
  [[nodiscard]] std::chrono::duration<double> period() const {
    return std::chrono::duration<double>(period_seconds_);
  }

  [[nodiscard]] std::uint64_t resent_packets() const {
    if (!stream_ || !ARV_IS_GV_STREAM(stream_.get())) return 0;
    return arv_stream_get_info_uint64_by_name(stream_.get(), "n_resent_packets");
  }
  /// Empty for cameras not on a network.
  [[nodiscard]] CameraAddress address() const {
    if (arv_camera_is_gv_device(camera_.get()) == 0) return {};
    ArvGvDevice* device = ARV_GV_DEVICE(arv_camera_get_device(camera_.get()));
    return {inet_address(arv_gv_device_get_interface_address(device)),
            inet_address(arv_gv_device_get_device_address(device))};
  }

 private:
  /// Aravis functions that read, bound and set one control, and its unit relative to ours.
  struct ControlCalls {
    double (*get)(ArvCamera*, GError**);
    void (*bounds)(ArvCamera*, double*, double*, GError**);
    void (*set)(ArvCamera*, double, GError**);
    double unit;
    const char* name;
  };

  static const ControlCalls& calls_of(CameraControl which) {
    static constexpr std::array<ControlCalls, 3> calls{
        {{arv_camera_get_exposure_time, arv_camera_get_exposure_time_bounds,
          arv_camera_set_exposure_time, 1e-3, "an exposure of {} ms"},
         {arv_camera_get_gain, arv_camera_get_gain_bounds, arv_camera_set_gain, 1, "a gain of {}"},
         {arv_camera_get_frame_rate, arv_camera_get_frame_rate_bounds, arv_camera_set_frame_rate, 1,
          "{} frames per second"}}};

    return calls.at(static_cast<std::size_t>(which));
  }

  static GObjectPointer<GInetAddress> inet_address(GSocketAddress* address) {
    if (address == nullptr || !G_IS_INET_SOCKET_ADDRESS(address)) return nullptr;

    GInetAddress* inet = g_inet_socket_address_get_address(G_INET_SOCKET_ADDRESS(address));
    return GObjectPointer<GInetAddress>(
        static_cast<GInetAddress*>(g_object_ref(static_cast<gpointer>(inet))));
  }

  /// Makes a call that the camera may refuse. Throws Error naming the setting.
  template <class Call, class... Values>
  void set(const std::string& what, Call call, Values... values) const {
    g_autoptr(GError) error = nullptr;
    call(camera_.get(), values..., &error);
    if (error != nullptr) {
      throw Error(fmt::format("camera {} refused {}: {}", name_, what, error->message));
    }
  }

  /// A missing node throws Error.
  [[nodiscard]] ArvGcFeatureNode* node(const std::string& name) const {
    ArvGcNode* found = arv_device_get_feature(arv_camera_get_device(camera_.get()), name.c_str());
    throw_if(found == nullptr || !ARV_IS_GC_FEATURE_NODE(found), "camera {} has no node {}", name_,
             name);
    return ARV_GC_FEATURE_NODE(found);
  }

  /// Empty if it cannot be read.
  static std::string value_of(ArvGcFeatureNode* node) {
    g_autoptr(GError) error = nullptr;
    const char* const text = arv_gc_feature_node_get_value_as_string(node, &error);
    return text == nullptr || error != nullptr ? "" : text;
  }

  static bool same_value(const std::string& wanted, const std::string& read) {
    constexpr double rounding = 0.01;  // cameras round times to their clock
    const auto a = number_in<double>(wanted), b = number_in<double>(read);
    return a && b ? std::abs(*a - *b) <= rounding * std::abs(*a) : wanted == read;
  }

  /// Returns the value read back. A node that has the value already is not written, as it may be
  /// read-only, such as the mode of a fixed output.
  [[nodiscard]] std::string set_node(const CameraNode& wanted) const {
    ArvGcFeatureNode* const found = node(wanted.name);

    const std::string what = wanted.name + " = " + wanted.value;

    if (ARV_IS_GC_COMMAND(found)) {
      set(what, [&](ArvCamera*, GError** error) {
        arv_gc_command_execute(ARV_GC_COMMAND(found), error);
      });
      return "executed";
    }

    if (wanted.value == value_of(found)) return wanted.value;

    set(what, [&](ArvCamera*, GError** error) {
      arv_gc_feature_node_set_value_from_string(found, wanted.value.c_str(), error);
    });

    // Some cameras accept a value and round or ignore it.
    std::string read = value_of(found);
    throw_if(!same_value(wanted.value, read), "camera {}: {} was set to {} but reads back as {}",
             name_, wanted.name, wanted.value, read.empty() ? "nothing" : read);
    return read;
  }

  /// Nodes of the settings' strobe, then their own.
  [[nodiscard]] std::vector<CameraNode> nodes_of(const CameraSettings& settings) const {
    const auto us = [](double seconds) { return fmt::format("{:g}", seconds * 1e6); };

    std::vector<CameraNode> nodes;
    if (!settings.strobe.empty()) {
      // The line as an output. A line that is high while active may lack an inverter.
      nodes.insert(nodes.end(), {{"LineSelector", settings.strobe}, {"LineMode", "Output"}});
      const bool may_invert =
          arv_camera_is_feature_available(camera_.get(), "LineInverter", nullptr) != 0;
      if (settings.strobe_inverted || may_invert) {
        nodes.push_back({"LineInverter", settings.strobe_inverted ? "true" : "false"});
      }

      // Long enough for an opto-isolated output, short against a frame.
      constexpr double pulse = 500e-6;
      if (settings.strobe_delay) {
        nodes.insert(nodes.end(), {{"TimerSelector", "Timer1"},
                                   {"TimerTriggerSource", "ExposureStart"},
                                   {"TimerDelay", us(*settings.strobe_delay)},
                                   {"TimerDuration", us(pulse)}});
      }
      // The source comes last, once its timer is set up.
      nodes.push_back({"LineSource", settings.strobe_delay ? "Timer1Active" : "ExposureActive"});
    }

    nodes.insert(nodes.end(), settings.nodes.begin(), settings.nodes.end());
    return nodes;
  }

  void set_up(const CameraSettings& settings) {
    // A plain UDP socket, to which limit_stream() can attach its filter.
    arv_camera_gv_set_stream_options(camera_.get(), ARV_GV_STREAM_OPTION_PACKET_SOCKET_DISABLED);
    set("continuous frames", arv_camera_set_acquisition_mode, ARV_ACQUISITION_MODE_CONTINUOUS);

    // 1. Region and pixels.
    if (const auto& region = settings.region) {
      set(fmt::format("the region {},{} {}x{}", region->x, region->y, region->size.width,
                      region->size.height),
          arv_camera_set_region, region->x, region->y, region->size.width, region->size.height);
    }
    const std::string pixel_format = pixel_format_of(settings);
    set("pixels as " + pixel_format, arv_camera_set_pixel_format_from_string, pixel_format.c_str());

    // 2. Free-running or triggered.
    if (settings.trigger.empty()) {
      arv_camera_clear_triggers(camera_.get(), nullptr);  // fails on a camera without triggers
      if (settings.frame_rate) set_control(CameraControl::frame_rate, *settings.frame_rate);
      ask_period();
    } else {
      set("the trigger " + settings.trigger, arv_camera_set_trigger, settings.trigger.c_str());
    }

    // 3. Nodes, then exposure and gain.
    for (const CameraNode& wanted : nodes_of(settings)) {
      const std::string read = set_node(wanted);
      if (settings.node_set) settings.node_set({wanted.name, read});
    }

    if (settings.exposure) set_control(CameraControl::exposure, *settings.exposure * 1e3);
    if (settings.gain) set_control(CameraControl::gain, *settings.gain);

    // 4. Packets of the network, and the region that the camera really has.
    if (arv_camera_is_gv_device(camera_.get()) != 0) {
      if (settings.packet_size > 0) {
        set(fmt::format("packets of {} bytes", settings.packet_size), arv_camera_gv_set_packet_size,
            settings.packet_size);
      } else {
        // A camera that cannot test packet sizes keeps its own.
        g_autoptr(GError) ignored = nullptr;
        arv_camera_gv_auto_packet_size(camera_.get(), &ignored);
      }
    }

    int x = 0, y = 0;
    set("to report its region", arv_camera_get_region, &x, &y, &size_.width, &size_.height);
  }

  /// Notices that a camera that is not on a network is gone. A GigE camera must not have such a
  /// handler: Aravis calls it in the device's own thread, which then may hold the device's last
  /// reference, and would wait for its own end.
  void watch() {
    using Lost = std::shared_ptr<std::atomic<bool>>;
    const auto handler = [](ArvDevice*, gpointer lost) { *static_cast<Lost*>(lost)->get() = true; };
    const auto forget = [](gpointer lost, GClosure*) { delete static_cast<Lost*>(lost); };

    // The handler keeps its own share of the flag and deletes it when it is disconnected.
    auto kept = std::make_unique<Lost>(lost_);
    g_signal_connect_data(arv_camera_get_device(camera_.get()), "control-lost",
                          reinterpret_cast<GCallback>(+handler), kept.release(), +forget,
                          static_cast<GConnectFlags>(0));
  }

  /// Notices that a GigE camera is lost: it does not answer, or another client has taken control,
  /// e.g. after a stall of this program. Of the latter Aravis only reads whether any client has it,
  /// but a write succeeds only for the one that does. The write is also a heartbeat, independent of
  /// frames and settings.
  void guard_control(const std::stop_token& stop) {
    using std::chrono_literals::operator""ms;
    constexpr std::uint64_t heartbeat_timeout = 0x938;  // defined by the standard
    ArvDevice* const device = arv_camera_get_device(camera_.get());
    go_when_woken();  // while others compute: a late write lets another client take the camera

    // The register is written with the value that it has; 0 if it cannot be read.
    std::uint32_t timeout = 0;
    arv_device_read_register(device, heartbeat_timeout, &timeout, nullptr);

    std::mutex mutex;
    std::unique_lock lock(mutex);
    std::condition_variable_any stopped;
    while (!is_lost() &&
           !stopped.wait_for(lock, stop, 500ms, [&] { return stop.stop_requested(); })) {
      if (arv_gv_device_is_controller(ARV_GV_DEVICE(device)) == 0) *lost_ = true;
      if (timeout == 0) continue;

      g_autoptr(GError) error = nullptr;
      arv_device_write_register(device, heartbeat_timeout, timeout, &error);
      if (g_error_matches(error, ARV_DEVICE_ERROR, ARV_DEVICE_ERROR_PROTOCOL_ERROR_ACCESS_DENIED) !=
          0) {
        *lost_ = true;
      }
    }
  }

  /// Limits the stream to packets that Aravis can handle, see pass_pictures_only.
  void limit_stream(std::uint32_t payload) {
    constexpr int least_packet = 100;

    // The camera's address, in host byte order.
    const GObjectPointer<GInetAddress> inet = address().device;
    std::uint32_t camera = 0;
    if (inet && g_inet_address_get_native_size(inet.get()) == sizeof(camera)) {
      std::memcpy(&camera, g_inet_address_to_bytes(inet.get()), sizeof(camera));
    }

    g_autoptr(GError) error = nullptr;
    const int packet = arv_camera_gv_get_packet_size(camera_.get(), &error);
    if (error != nullptr || packet < least_packet ||
        !pass_pictures_only({.port = arv_gv_stream_get_port(ARV_GV_STREAM(stream_.get())),
                             .camera = g_ntohl(camera),
                             .packet_size = static_cast<std::uint32_t>(packet),
                             .picture_bytes = payload})) {
      throw WorldError(
          fmt::format("camera {}: cannot install a packet filter on its stream", name_));
    }
  }

  void ask_period() {
    const double rate = arv_camera_get_frame_rate(camera_.get(), nullptr);
    if (rate > 0) period_seconds_ = 1 / rate;
  }

  std::string name_;
  mutable std::mutex nodes_;  ///< the camera's nodes may be used by one thread at a time
  GObjectPointer<ArvCamera> camera_;
  GObjectPointer<ArvStream> stream_;
  Size size_;
  std::atomic<double> period_seconds_ = 0;
  /// Shared with a GObject signal handler, which may outlive this object.
  std::shared_ptr<std::atomic<bool>> lost_ = std::make_shared<std::atomic<bool>>(false);
  std::jthread guard_;  ///< uses the members above
};

}  // namespace slipstream
