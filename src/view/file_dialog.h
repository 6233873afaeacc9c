#pragma once

#include <atomic>
#include <optional>
#include <string>

namespace slipstream::view {

enum class FileQuestion { open, save };

/// Asks for a file by the desktop's own dialog (D-Bus, org.freedesktop.portal.FileChooser); nullopt
/// if the user cancels it, or once `given_up` is set. Throws WorldError without such a dialog.
/// Blocks, so call it from a thread of its own.
std::optional<std::string> ask_for_file(FileQuestion question, const std::atomic<bool>& given_up);

}  // namespace slipstream::view
