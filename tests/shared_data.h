#pragma once

#include <cstdlib>
#include <filesystem>

namespace slipstream {

/// Real captures by others, which are not part of the project: ../shared/data beside the checkout,
/// or where SLIPSTREAM_SHARED_DATA says. Tests that need them are skipped where there are none.
inline std::filesystem::path shared_data() {
  if (const char* folder = std::getenv("SLIPSTREAM_SHARED_DATA")) return folder;
  return std::filesystem::path(SLIPSTREAM_SOURCE_FOLDER).parent_path() / "shared" / "data";
}

/// Small inputs with what is right for each: ../shared/cases, beside the captures.
inline std::filesystem::path shared_cases() {
  return shared_data().parent_path() / "cases";
}

}  // namespace slipstream
