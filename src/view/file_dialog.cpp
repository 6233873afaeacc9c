#include "view/file_dialog.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <thread>

#include <fmt/format.h>

#include "slipstream/error.h"

#ifdef SLIPSTREAM_CAMERAS  // brings GLib along
#include <gio/gio.h>
#endif

namespace slipstream::view {

#ifdef SLIPSTREAM_CAMERAS
namespace {

template <auto free>
struct Freed {
  template <class Object>
  void operator()(Object* object) const {
    free(object);
  }
};

using Bus = std::unique_ptr<GDBusConnection, Freed<g_object_unref>>;
using Variant = std::unique_ptr<GVariant, Freed<g_variant_unref>>;
using Context = std::unique_ptr<GMainContext, Freed<g_main_context_unref>>;
using Text = std::unique_ptr<char, Freed<g_free>>;

/// Throws WorldError with GLib's reason if there is one.
void require_no(GError* error) {
  if (error == nullptr) return;

  const std::unique_ptr<GError, Freed<g_error_free>> held(error);
  throw WorldError(
      fmt::format("no file dialog on this desktop ({}); type a path below Files", held->message));
}

struct Answer {
  bool came = false;
  std::optional<std::string> path{};
};

/// The portal's Response signal: 0 if a file was chosen, and the dictionary with its address.
void take_answer(GDBusConnection*, const char*, const char*, const char*, const char*,
                 GVariant* values, void* to) {
  Answer& answer = *static_cast<Answer*>(to);
  answer.came = true;

  const Variant results(g_variant_get_child_value(values, 1));
  const char** addresses = nullptr;
  if (g_variant_lookup(results.get(), "uris", "^a&s", &addresses) == FALSE) return;

  const std::unique_ptr<const char*, Freed<g_free>> list(addresses);
  if (addresses[0] == nullptr) return;
  const Text path(g_filename_from_uri(addresses[0], nullptr, nullptr));
  if (path) answer.path = path.get();
}

}  // namespace

std::optional<std::string> ask_for_file(FileQuestion question, const std::atomic<bool>& given_up) {
  // Signals come to the context of the thread that subscribes.
  const Context context(g_main_context_new());
  g_main_context_push_thread_default(context.get());
  const std::unique_ptr<GMainContext, Freed<g_main_context_pop_thread_default>> pushed(
      context.get());

  // A connection of our own: an unanswered dialog closes with it, and the program outlives it.
  GError* error = nullptr;
  const Text address(g_dbus_address_get_for_bus_sync(G_BUS_TYPE_SESSION, nullptr, &error));
  require_no(error);
  constexpr auto flags =
      static_cast<GDBusConnectionFlags>(G_DBUS_CONNECTION_FLAGS_AUTHENTICATION_CLIENT |
                                        G_DBUS_CONNECTION_FLAGS_MESSAGE_BUS_CONNECTION);
  const Bus bus(
      g_dbus_connection_new_for_address_sync(address.get(), flags, nullptr, nullptr, &error));
  require_no(error);

  // 1. Listen for the answer at the path that the portal makes of our name and this word.
  const auto now = std::chrono::steady_clock::now().time_since_epoch().count();
  const std::string word = fmt::format("slipstream{}", now);
  std::string sender = g_dbus_connection_get_unique_name(bus.get()) + 1;
  std::ranges::replace(sender, '.', '_');
  const std::string path =
      fmt::format("/org/freedesktop/portal/desktop/request/{}/{}", sender, word);

  Answer answer;
  const unsigned subscription = g_dbus_connection_signal_subscribe(
      bus.get(), nullptr, "org.freedesktop.portal.Request", "Response", path.c_str(), nullptr,
      G_DBUS_SIGNAL_FLAGS_NONE, take_answer, &answer, nullptr);

  // 2. Open the dialog.
  const bool opens = question == FileQuestion::open;
  GVariantBuilder options;
  g_variant_builder_init(&options, G_VARIANT_TYPE_VARDICT);
  g_variant_builder_add(&options, "{sv}", "handle_token", g_variant_new_string(word.c_str()));
  if (!opens) {
    g_variant_builder_add(&options, "{sv}", "current_name", g_variant_new_string("cloud.ply"));
  }

  const Variant handle(g_dbus_connection_call_sync(
      bus.get(), "org.freedesktop.portal.Desktop", "/org/freedesktop/portal/desktop",
      "org.freedesktop.portal.FileChooser", opens ? "OpenFile" : "SaveFile",
      g_variant_new("(ssa{sv})", "", opens ? "Open" : "Save as", &options), nullptr,
      G_DBUS_CALL_FLAGS_NONE, -1, nullptr, &error));

  // 3. Wait for the answer.
  while (error == nullptr && !answer.came && !given_up) {
    if (g_main_context_iteration(context.get(), FALSE) == FALSE) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }

  g_dbus_connection_signal_unsubscribe(bus.get(), subscription);
  require_no(error);
  return answer.path;
}

#else

std::optional<std::string> ask_for_file(FileQuestion, const std::atomic<bool>&) {
  throw WorldError("this build has no file dialog; type a path below Files");
}

#endif

}  // namespace slipstream::view
