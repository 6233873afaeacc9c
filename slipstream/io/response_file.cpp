#include "slipstream/io/response_file.h"

#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "slipstream/error/error.h"
#include "slipstream/io/opencv_storage.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

constexpr const char* gamma_entry = "gamma";
constexpr const char* error_entry = "gamma_standard_error";
constexpr const char* values_entry = "response_values";
constexpr const char* light_entry = "response_light";

StoredMatrix row_of(std::vector<double> numbers) {
  return {1, static_cast<int>(numbers.size()), std::move(numbers)};
}

std::optional<Response> response_of(const std::map<std::string, StoredMatrix>& entries,
                                    const std::string& name) {
  try {
    if (entries.contains(values_entry) || entries.contains(light_entry)) {
      if (!entries.contains(values_entry) || !entries.contains(light_entry)) {
        throw Error(fmt::format("{} and {} go together", values_entry, light_entry));
      }
      return response_curve(entries.at(values_entry).numbers, entries.at(light_entry).numbers);
    }
    if (!entries.contains(gamma_entry)) return std::nullopt;
    const std::vector<double>& numbers = entries.at(gamma_entry).numbers;
    if (numbers.size() != 1) throw Error("gamma is not a number");
    require_gamma(numbers[0], gamma_entry);
    return PowerLaw{numbers[0]};
  } catch (const Error& error) {
    throw Error(fmt::format("{}: {}", name, error.what()));
  }
}

}  // namespace

std::optional<Response> read_response(const fs::path& scanner_file) {
  return response_of(read_opencv_storage(scanner_file), scanner_file.string());
}

std::optional<Response> response_from(const std::string& text, const std::string& name) {
  return response_of(opencv_entries(text, name), name);
}

std::string with_gamma(const std::string& text, std::optional<double> gamma,
                       const std::string& name) {
  return with_entries(text,
                      {{gamma_entry, gamma ? row_of({*gamma}) : StoredMatrix{}},
                       {error_entry, {}},
                       {values_entry, {}},
                       {light_entry, {}}},
                      name);
}

void write_response(const std::optional<fs::path>& from, const fs::path& to,
                    const Response& response, double gamma, double standard_error) {
  std::map<std::string, StoredMatrix> entries{{gamma_entry, row_of({gamma})},
                                              {error_entry, row_of({standard_error})},
                                              {values_entry, {}},
                                              {light_entry, {}}};
  if (const auto* curve = std::get_if<ResponseCurve>(&response)) {
    entries[values_entry] = row_of(curve->values);
    entries[light_entry] = row_of(curve->light);
  }
  write_entries(from, to, entries);
}

}  // namespace slipstream
