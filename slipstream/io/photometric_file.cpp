#include "slipstream/io/photometric_file.h"

#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/base/number_text.h"
#include "slipstream/frames/colour_channels.h"
#include "slipstream/response/named_responses.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

using Entries = std::map<std::string, StoredMatrix>;

constexpr const char* ambient_entry = "ambient_light";
constexpr const char* noise_entry = "noise_variance";
constexpr const char* gain_entry = "noise_gain";
constexpr const char* gamma_entry = "gamma";
constexpr const char* error_entry = "gamma_standard_error";
constexpr const char* values_entry = "response_values";
constexpr const char* light_entry = "response_light";
constexpr const char* mixture_entry = "colour_mixture";

std::optional<double> number(const Entries& entries, const char* name) {
  const auto found = entries.find(name);
  if (found == entries.end()) return std::nullopt;
  if (found->second.numbers.size() != 1) throw Error(fmt::format("{} is not a number", name));
  return found->second.numbers[0];
}

std::optional<MeasuredResponse> response_of(const Entries& entries) {
  const std::optional<double> gamma = number(entries, gamma_entry);
  MeasuredResponse measured{.gamma = gamma.value_or(1),
                            .standard_error = number(entries, error_entry).value_or(0)};
  const bool has_values = entries.contains(values_entry), has_light = entries.contains(light_entry);
  if (has_values != has_light) {
    throw Error(fmt::format("{} and {} go together", values_entry, light_entry));
  }
  if (has_values) {
    measured.response =
        response_curve(entries.at(values_entry).numbers, entries.at(light_entry).numbers);
    return measured;
  }
  if (!gamma) return std::nullopt;
  measured.response = PowerLaw{*gamma};
  return measured;
}

std::optional<ColourMixture> mixture_of(const Entries& entries) {
  const auto found = entries.find(mixture_entry);
  if (found == entries.end()) return std::nullopt;
  const auto& [rows, columns, numbers, text] = found->second;
  if (rows != 3 || columns != 4) throw Error(fmt::format("{} is no 3x4 matrix", mixture_entry));
  ColourMixture mixture{};
  for (std::size_t i = 0; i < numbers.size(); ++i) mixture[i / 4][i % 4] = numbers[i];
  require_valid(mixture);
  return mixture;
}

StoredMatrix row_of(std::vector<double> numbers) {
  return {1, static_cast<int>(numbers.size()), std::move(numbers)};
}

}  // namespace

PhotometricCalibration photometric_calibration_of(const Entries& entries, const std::string& name) {
  try {
    PhotometricCalibration read{.ambient = number(entries, ambient_entry),
                                .noise_variance = number(entries, noise_entry),
                                .noise_gain = number(entries, gain_entry).value_or(0),
                                .response = response_of(entries),
                                .colour_mixture = mixture_of(entries)};
    require_valid(read);
    return read;
  } catch (const Error& error) {
    throw Error(fmt::format("{}: {}", name, error.what()));
  }
}

Entries entries_of(const PhotometricCalibration& calibration) {
  Entries entries;
  if (calibration.ambient) entries[ambient_entry] = row_of({*calibration.ambient});
  if (calibration.noise_variance) {
    entries[noise_entry] = row_of({*calibration.noise_variance});
    entries[gain_entry] = row_of({calibration.noise_gain});
  }
  if (const auto& mixture = calibration.colour_mixture) {
    StoredMatrix& stored = entries[mixture_entry] = {3, 4};
    for (const auto& row : *mixture) {
      stored.numbers.insert(stored.numbers.end(), row.begin(), row.end());
    }
  }
  if (!calibration.response) return entries;
  const auto& [response, gamma, standard_error] = *calibration.response;
  entries[gamma_entry] = row_of({gamma});
  entries[error_entry] = row_of({standard_error});
  // Empty ones take away what was there.
  entries[values_entry] = entries[light_entry] = {};
  if (const auto* curve = std::get_if<ResponseCurve>(&response)) {
    entries[values_entry] = row_of(curve->values);
    entries[light_entry] = row_of(curve->light);
  }
  return entries;
}

PhotometricCalibration read_photometric_calibration(const fs::path& scanner_file) {
  return photometric_calibration_of(read_opencv_storage(scanner_file), scanner_file.string());
}

void write_photometric_calibration(const std::optional<fs::path>& from, const fs::path& to,
                                   const PhotometricCalibration& calibration) {
  write_entries(from, to, entries_of(calibration));
}

Response response_named(const std::string& text, const std::string& name) {
  if (const auto gamma = number_in<double>(text)) {
    require_gamma(*gamma, name);
    return PowerLaw{*gamma};
  }
  if (auto curve = curve_named(text)) return *std::move(curve);
  const auto measured = read_photometric_calibration(text).response;
  if (!measured) {
    throw Error(fmt::format("{}: no gamma in it; slipstream calibrate gamma puts it there", text));
  }
  return measured->response;
}

}  // namespace slipstream
