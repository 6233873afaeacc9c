#pragma once

#include <filesystem>

namespace slipstream {

/// The path, with -2, -3 and so on before the ending if it exists.
std::filesystem::path free_path(const std::filesystem::path& path);

}  // namespace slipstream
