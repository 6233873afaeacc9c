#pragma once

#include <filesystem>
#include <string_view>

namespace slipstream {

/// The path, with -2, -3 and so on before the ending if it exists.
std::filesystem::path free_path(const std::filesystem::path& path);

/// A free path in `parent`, named by the time: "WHAT-20260131-142530ENDING".
std::filesystem::path path_named_by_time(const std::filesystem::path& parent, std::string_view what,
                                         std::string_view ending);

}  // namespace slipstream
