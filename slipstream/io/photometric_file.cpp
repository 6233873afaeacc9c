#include "slipstream/io/photometric_file.h"

#include <cmath>
#include <map>
#include <string>

#include <fmt/format.h>

#include "slipstream/error/error.h"
#include "slipstream/io/opencv_storage.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

constexpr const char* ambient_entry = "ambient_light";
constexpr const char* noise_entry = "noise_variance";

PhotometricCalibration photometric_calibration_of(
    const std::map<std::string, StoredMatrix>& entries, const std::string& file) {
  const auto number = [&](const char* name) -> std::optional<double> {
    const auto found = entries.find(name);
    if (found == entries.end()) return std::nullopt;
    if (found->second.numbers.size() != 1) {
      throw Error(fmt::format("{}: {} is not a number", file, name));
    }
    return found->second.numbers[0];
  };
  const PhotometricCalibration read{.ambient = number(ambient_entry),
                                    .noise_variance = number(noise_entry)};
  if (read.ambient && !(std::abs(*read.ambient) <= 255)) {
    throw Error(fmt::format("{}: {} {} is out of range; -255 to 255 grey levels", file,
                            ambient_entry, *read.ambient));
  }
  if (read.noise_variance && !(*read.noise_variance > 0 && std::isfinite(*read.noise_variance))) {
    throw Error(
        fmt::format("{}: {} {} is out of range; above 0", file, noise_entry, *read.noise_variance));
  }
  return read;
}

std::map<std::string, StoredMatrix> entries_of(const PhotometricCalibration& calibration) {
  std::map<std::string, StoredMatrix> entries;
  if (calibration.ambient) entries[ambient_entry] = {1, 1, {*calibration.ambient}};
  if (calibration.noise_variance) entries[noise_entry] = {1, 1, {*calibration.noise_variance}};
  return entries;
}

}  // namespace

PhotometricCalibration read_photometric_calibration(const fs::path& scanner_file) {
  return photometric_calibration_of(read_opencv_storage(scanner_file), scanner_file.string());
}

PhotometricCalibration photometric_calibration_from(const std::string& text,
                                                    const std::string& name) {
  return photometric_calibration_of(opencv_entries(text, name), name);
}

std::string with_photometric_calibration(const std::string& text,
                                         const PhotometricCalibration& calibration,
                                         const std::string& name) {
  return with_entries(text, entries_of(calibration), name);
}

void write_photometric_calibration(const std::optional<fs::path>& from, const fs::path& to,
                                   const PhotometricCalibration& calibration) {
  write_entries(from, to, entries_of(calibration));
}

}  // namespace slipstream
