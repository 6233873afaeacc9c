#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "slipstream/gamma/response.h"

namespace slipstream {

/// The response that a scanner file holds, if it does: `response_values` and `response_light`, two
/// rows of numbers (a measured curve), or `gamma`. Throws Error, naming file and entry, for one
/// that is not of its form or out of range.
std::optional<Response> read_response(const std::filesystem::path& scanner_file);

/// The same of such a file's text; `name` is what a message calls it.
std::optional<Response> response_from(const std::string& text, const std::string& name);

/// The text of a scanner file with this power law in place of the response in it, or without one;
/// all else as it was. Throws Error, calling it `name`, where it is no such text.
std::string with_gamma(const std::string& text, std::optional<double> gamma,
                       const std::string& name);

/// Writes the scanner file `from` to `to` (which may be the same) with this response in place of
/// the one in it; every other entry stays, those that slipstream does not know too. `gamma`: the
/// power law nearest to a curve, or its own; `standard_error`: of gamma. `from` may be missing: the
/// new file then holds the response alone. Throws Error where both names do not end alike in .xml
/// or not.
void write_response(const std::optional<std::filesystem::path>& from,
                    const std::filesystem::path& to, const Response& response, double gamma,
                    double standard_error);

}  // namespace slipstream
