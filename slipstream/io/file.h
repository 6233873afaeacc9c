#pragma once

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace slipstream {

/// The bytes of a file. Throws Error when it is missing, a folder or unreadable.
std::vector<std::uint8_t> read_file(const std::filesystem::path& path);

/// Writes a file whole or not at all: to a temporary name beside it, then renamed. Throws
/// WorldError when the folder is missing or not writable, or the disk is full; nothing is left
/// behind then, and a file that was there before is untouched.
void write_file(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);
void write_file(const std::filesystem::path& path, std::string_view text);

/// Makes a folder and those above it. Throws WorldError when that fails.
void make_folder(const std::filesystem::path& folder);

/// A path's ending in lower case: ".png". Empty where it has none.
std::string lower_case_extension(const std::filesystem::path& path);

/// Throws Error, "no KIND has the ending ...", unless the path's ending is one of these.
void require_ending(const std::filesystem::path& path, const char* kind,
                    std::initializer_list<std::string_view> endings);

}  // namespace slipstream
