#pragma once

#include <cstddef>
#include <string_view>

namespace slipstream {

/// Whether a call that failed with this errno failed for want of the system and not because of its
/// arguments: no file descriptors or memory left, an interrupted call, a broken disk.
bool is_system_failure(int error_number);

/// Throws WorldError unless this process can open `count` more files now. For libraries that crash,
/// wait or find nothing if they cannot. `what` names the work that needs them.
void require_descriptors(std::size_t count, std::string_view what);

}  // namespace slipstream
