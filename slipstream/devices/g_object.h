#pragma once

#include <memory>
#include <string>

#include <glib-object.h>

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

}  // namespace slipstream
