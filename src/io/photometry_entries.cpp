#include "io/photometry_entries.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "base/throw_if-inl.h"
#include "frames/colour_channels.h"
#include "response/response_fit.h"

namespace slipstream {
namespace {

constexpr const char* gamma_entry = "gamma";
constexpr const char* error_entry = "gamma_standard_error";
constexpr const char* values_entry = "response_values";
constexpr const char* light_entry = "response_light";
constexpr const char* mixture_entry = "colour_mixture";
constexpr const char* balance_entry = "white_balance";

std::optional<double> number(const StoredEntries& entries, const char* name) {
  const auto found = entries.find(name);
  if (found == entries.end()) return std::nullopt;

  throw_if(found->second.numbers.size() != 1, "{} is not a number", name);
  return found->second.numbers[0];
}

std::optional<MeasuredResponse> response_of(const StoredEntries& entries) {
  const std::optional<double> gamma = number(entries, gamma_entry);
  MeasuredResponse measured{.gamma = gamma.value_or(1),
                            .standard_error = number(entries, error_entry).value_or(0)};

  // A measured curve has priority over its gamma.
  const bool has_values = entries.contains(values_entry), has_light = entries.contains(light_entry);
  throw_if(has_values != has_light, "{} and {} must both be present", values_entry, light_entry);

  if (has_values) {
    measured.response =
        response_curve(entries.at(values_entry).numbers, entries.at(light_entry).numbers);
    return measured;
  }

  if (!gamma) return std::nullopt;
  measured.response = PowerLaw{*gamma};
  return measured;
}

std::optional<ColourMixture> mixture_of(const StoredEntries& entries) {
  const auto found = entries.find(mixture_entry);
  if (found == entries.end()) return std::nullopt;

  const auto& [rows, columns, numbers, text] = found->second;
  throw_if(rows != 3 || columns != 4, "{} is not a 3x4 matrix", mixture_entry);

  ColourMixture mixture{};
  for (std::size_t i = 0; i < numbers.size(); ++i) mixture[i / 4][i % 4] = numbers[i];
  require_valid(mixture);
  return mixture;
}

std::optional<std::array<double, 3>> balance_of(const StoredEntries& entries) {
  const auto found = entries.find(balance_entry);
  if (found == entries.end()) return std::nullopt;

  const std::vector<double>& numbers = found->second.numbers;
  const auto is_factor = [](double number) { return number >= 0.01 && number <= 100; };
  throw_if(numbers.size() != 3 || !std::ranges::all_of(numbers, is_factor),
           "{} is not three factors of 0.01 to 100", balance_entry);
  return std::array{numbers[0], numbers[1], numbers[2]};
}

StoredMatrix row_of(std::vector<double> numbers) {
  return {1, static_cast<int>(numbers.size()), std::move(numbers)};
}

}  // namespace

PhotometricCalibration photometric_calibration_of(const StoredEntries& entries) {
  PhotometricCalibration read{.response = response_of(entries),
                              .colour_mixture = mixture_of(entries),
                              .white_balance = balance_of(entries)};

  PhotometricCalibration::for_each_setting(read, [&](const Setting& setting, auto& value) {
    if (const auto stored = number(entries, setting.name)) value = *stored;
  });

  require_valid(read);
  return read;
}

StoredEntries entries_of(const PhotometricCalibration& calibration) {
  StoredEntries entries;

  PhotometricCalibration::for_each_setting(
      calibration, [&](const Setting& setting, const std::optional<double>& value) {
        if (value) entries[setting.name] = row_of({*value});
      });

  // The gain describes the noise variance and means nothing without it.
  if (!calibration.noise_variance) entries.erase("noise_gain");

  if (const auto& mixture = calibration.colour_mixture) {
    StoredMatrix& stored = entries[mixture_entry] = {3, 4};
    for (const auto& row : *mixture) {
      stored.numbers.insert(stored.numbers.end(), row.begin(), row.end());
    }
  }

  if (const auto& balance = calibration.white_balance) {
    entries[balance_entry] = row_of({balance->begin(), balance->end()});
  }

  if (!calibration.response) return entries;
  const auto& [response, gamma, standard_error] = *calibration.response;
  entries[gamma_entry] = row_of({gamma});
  entries[error_entry] = row_of({standard_error});
  // Empty entries are removed.
  entries[values_entry] = entries[light_entry] = {};

  if (const auto* curve = std::get_if<ResponseCurve>(&response)) {
    entries[values_entry] = row_of(curve->values);
    entries[light_entry] = row_of(curve->light);
  }

  return entries;
}

}  // namespace slipstream
