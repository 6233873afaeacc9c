#include "app/rig_rights.h"

#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include <arpa/inet.h>
#include <netinet/in.h>

#include "app/commands.h"
#include "base/numbers.h"
#include "io/file.h"
#include "io/result_files.h"

namespace slipstream::app {
namespace {

/// The endings that the help of a flag names, e.g. ".png".
std::vector<std::string> endings_in(std::string_view help) {
  std::vector<std::string> endings;
  while (!help.empty()) {
    std::string_view word = take_until(help, ' ');
    while (!word.empty() && std::ispunct(static_cast<unsigned char>(word.back()))) {
      word.remove_suffix(1);
    }
    if (word.starts_with('.')) endings.emplace_back(word);
  }
  return endings;
}

/// Whether the file or folder, its links followed, is in the working folder or below.
bool is_in_working_folder(const fs::path& path) {
  std::error_code unknown;
  const fs::path end = fs::is_directory(path, unknown) ? path : output_target(path);
  const fs::path from_here =
      fs::weakly_canonical(fs::absolute(end)).lexically_relative(fs::current_path());
  return !from_here.empty() && *from_here.begin() != "..";
}

void require_may_write(const CLI::Option& option, const std::string& path, bool replaces) {
  const std::string flag = option.get_name();
  throw_if(!is_in_working_folder(path),
           "{}: a rig file writes only to the working folder and below; give {} on the command "
           "line",
           path, flag);

  // Save makes new folders in this one.
  if (option.check_lname("save-to")) return;

  const std::vector<std::string> endings = option.check_lname("publish")
                                               ? std::vector<std::string>{".mcap"}
                                               : endings_in(option.get_description());
  throw_if(endings.empty() || option.get_type_name() == output_folder_type,
           "{}: a rig file may not name a folder to write; give {} on the command line", path,
           flag);
  throw_if(
      !std::ranges::count(endings, lower_case_extension(path)),
      "{}: a rig file names outputs with the ending of their format; use {}, or give {} on the "
      "command line",
      path, fmt::join(endings, ", "), flag);

  for (const fs::path& file : files_replaced_by(path)) {
    throw_if(!is_in_working_folder(file) || (replaces && !has_format_of_ending(file)),
             "{}: already exists and is not of that format, so a rig file may not replace it; give "
             "{} on the command line",
             file.string(), flag);
  }
}

/// Whether only this machine reaches the address.
bool is_loopback(std::string address) {
  if (address.starts_with('[') && address.ends_with(']')) {
    address = address.substr(1, address.size() - 2);
  }

  in_addr four{};
  if (::inet_pton(AF_INET, address.c_str(), &four) == 1) return ntohl(four.s_addr) >> 24 == 127;

  in6_addr six{};
  return ::inet_pton(AF_INET6, address.c_str(), &six) == 1 && IN6_IS_ADDR_LOOPBACK(&six) != 0;
}

/// Whether only this machine reaches "8080" or "127.0.0.1:8080".
bool is_loopback_port(const std::string& where) {
  const std::size_t colon = where.rfind(':');
  return colon == where.npos || is_loopback(where.substr(0, colon));
}

/// Whether the value of the option opens a port to other machines.
bool is_reached_by_others(const CLI::Option& option, const std::string& value) {
  if (option.check_lname("web")) return !is_loopback_port(value);
  if (option.check_lname("address")) return !is_loopback(value);
  if (!option.check_lname("publish")) return false;

  std::string_view address = value;
  const std::string_view kind = take_until(address, ':');
  if (kind == "web" || kind == "tcp") return !is_loopback_port(std::string(address));
  if (kind == "genicam") return !is_loopback(std::string(address));
  return kind == "ros2";
}

}  // namespace

void require_rig_may(const CLI::Option& option, const std::string& value, const RigRights& rights) {
  throw_if(option.check_lname("turn-command"),
           "--turn-command '{}': a rig file may not run commands; give it on the command line",
           value);

  throw_if(!rights.lets_others_in && is_reached_by_others(option, value),
           "{}: other machines could reach it, which a rig file may ask only with --public on the "
           "command line",
           value);

  const std::string path = option.check_lname("save-to") ? value : written_by(option, value);
  if (!path.empty()) require_may_write(option, path, rights.replaces_files);
}

bool opens_ports(const CLI::App& subcommand) {
  const auto has = [&](const char* name) {
    return subcommand.get_option_no_throw(name) != nullptr;
  };
  return has("--publish") || has("--web") || has("--address");
}

}  // namespace slipstream::app
