#pragma once

#include <string>

namespace slipstream::app {

/// Tells systemd, where it started the program and wants to know: "READY=1", "STATUS=...".
void tell_service_manager(const std::string& state);

}  // namespace slipstream::app
