#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include <arv.h>

#include "slipstream/devices/camera.h"
#include "slipstream/frames/frame_source.h"

namespace slipstream {

struct GObjectUnref {
  void operator()(gpointer object) const { g_object_unref(object); }
};

/// Owns one reference to a GObject.
template <class Object>
using GObjectPointer = std::unique_ptr<Object, GObjectUnref>;

/// Receives the GError of a call, `arv_call(..., error.out())`, and frees it.
class GErrorReceiver {
 public:
  GErrorReceiver() = default;
  GErrorReceiver(const GErrorReceiver&) = delete;
  GErrorReceiver& operator=(const GErrorReceiver&) = delete;
  ~GErrorReceiver() { g_clear_error(&error_); }

  /// To be handed to one call.
  GError** out() {
    g_clear_error(&error_);
    return &error_;
  }
  explicit operator bool() const { return error_ != nullptr; }
  [[nodiscard]] std::string message() const { return error_ ? error_->message : ""; }

 private:
  GError* error_ = nullptr;
};

/// Where a GigE Vision camera was found, to find it again without asking all networks.
struct CameraAddress {
  GObjectPointer<GInetAddress> interface;
  GObjectPointer<GInetAddress> device;

  explicit operator bool() const { return interface && device; }
};

/// A camera that has answered and is set up, as long as it answers. What it was asked before it was
/// gone may take seconds to give up: the destructor waits for that.
class AravisConnection {
 public:
  /// The camera of that name, or at that address where it was found before. Throws Error where it
  /// does not take a setting, WorldError where it does not answer.
  AravisConnection(const std::string& name, const CameraSettings& settings,
                   const CameraAddress& address = {});
  AravisConnection(const AravisConnection&) = delete;
  AravisConnection& operator=(const AravisConnection&) = delete;
  ~AravisConnection() = default;

  void start();  ///< frames come. Throws WorldError
  void stop();
  void trigger();

  /// See CameraControls.
  [[nodiscard]] std::optional<ControlValue> control(CameraControl which) const;
  void set_control(CameraControl which, double value);

  /// The next buffer, none in time. To be handed back.
  [[nodiscard]] GObjectPointer<ArvBuffer> pop(std::chrono::microseconds timeout) const;
  void push(GObjectPointer<ArvBuffer> buffer) const;

  /// The camera has said, or its silence, that somebody else has it or nobody.
  [[nodiscard]] bool is_lost() const { return *lost_; }
  [[nodiscard]] Size size() const { return size_; }
  /// The number of the first frame after start().
  [[nodiscard]] std::uint64_t first_number() const;
  /// Time between frames of a camera that runs freely, as it says; 0 for others.
  [[nodiscard]] std::chrono::duration<double> period() const {
    return std::chrono::duration<double>(period_seconds_);
  }
  [[nodiscard]] std::uint64_t resent_packets() const;
  /// Empty for cameras that are not on a network.
  [[nodiscard]] CameraAddress address() const;

 private:
  void set_up(const CameraSettings& settings);
  void watch();
  /// To packets that Aravis can take, see pass_pictures_only.
  void limit_stream(std::uint32_t payload);
  void ask_period();

  std::string name_;
  GObjectPointer<ArvCamera> camera_;
  GObjectPointer<ArvStream> stream_;
  Size size_;
  std::atomic<double> period_seconds_ = 0;
  /// Shared with the handler of a signal, which may outlive this.
  std::shared_ptr<std::atomic<bool>> lost_ = std::make_shared<std::atomic<bool>>(false);
};

}  // namespace slipstream
