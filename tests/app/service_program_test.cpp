// A service over time: after any sequence of reloads, changes, recordings and saves it shows what a
// model says.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <rapidcheck.h>
#include <sys/socket.h>
#include <unistd.h>

#include "io/file.h"
#include "slipstream/recording.h"
#include "slipstream/strategy.h"
#include "tests/app/program.h"
#include "tests/io/temporary_folder.h"
#include "tests/step_sequences.h"

namespace slipstream::service_program_test {
namespace fs = std::filesystem;
using namespace std::chrono_literals;

/// Waits up to 20 s: less than wait_until(), as failing sequences are tried again and again.
template <class Come>
bool soon(const Come& come) {
  const auto end = std::chrono::steady_clock::now() + 20s;
  while (!come()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(5ms);
  }
  return true;
}

std::size_t count_of(std::string_view words, std::string_view text) {
  std::size_t count = 0;
  for (std::size_t at = text.find(words); at != text.npos; at = text.find(words, at + 1)) ++count;
  return count;
}

/// The body of the page's answer; nullopt unless it has status 200. `what`: "GET /settings".
std::optional<std::string> ask(std::uint16_t port, const std::string& what,
                               const std::string& body = {}) {
  const Descriptor socket(::socket(AF_INET, SOCK_STREAM, 0));
  const timeval patience{.tv_sec = 10, .tv_usec = 0};
  ::setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));

  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(port);
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::connect(socket, reinterpret_cast<const sockaddr*>(&to), sizeof(to)) != 0) return {};

  const std::string request = fmt::format(
      "{} HTTP/1.1\r\nHost: 127.0.0.1:{}\r\nOrigin: http://127.0.0.1:{}\r\nConnection: close\r\n"
      "Content-Length: {}\r\n\r\n{}",
      what, port, port, body.size(), body);
  if (::send(socket, request.data(), request.size(), MSG_NOSIGNAL) < 0) return {};

  std::string answer;
  char bytes[4096];
  ssize_t got = 0;
  while ((got = ::recv(socket, bytes, sizeof(bytes), 0)) > 0) {
    answer.append(bytes, static_cast<std::size_t>(got));
  }

  const std::size_t head = answer.find("\r\n\r\n");
  if (head == answer.npos || !answer.starts_with("HTTP/1.1 200")) return {};
  return answer.substr(head + 4);
}

/// Settings of a rig file.
struct RigSettings {
  int steps = 4, high = 16, least_modulation = 20;

  [[nodiscard]] std::string strategy() const {
    return label_of(
        strategy_labelled(fmt::format("dual-frequency, high {}, steps {}", high, steps)));
  }
};

/// A service, and what it should show.
class Service {
 public:
  Service() {
    RC_ASSERT(soon([&] { return starts() == 1; }));
  }

  /// One step, after which the service must show what the model says.
  void take(const std::string& step) {
    if (step == "reload") reload();
    if (step == "reload other") {
      write_other();
      reload();
    }
    if (step == "reload invalid") {
      write("stratgy: pmp\n");
      file_ = std::nullopt;
      reload();
    }
    if (step == "reload twice") reload_twice();
    if (step == "set") set();
    if (step == "set invalid") RC_ASSERT(!ask(port(), "POST /settings", "minimum-modulation=200"));
    if (step == "record on" || step == "record off") record(step == "record on");
    if (step == "save") save();

    RC_ASSERT(soon([&] { return shows_model(); }));
  }

  /// Ends it; all its files are complete.
  void end() {
    program_.send(SIGTERM);
    RC_ASSERT(program_.wait() == 0);

    if (!fs::exists(saved())) return;
    for (const fs::directory_entry& entry : fs::directory_iterator(saved())) {
      const fs::path& path = entry.path();
      RC_ASSERT(path.extension() != ".part");
      if (path.extension() == ".slip") RC_ASSERT(RecordingReader(path).finished());
    }
  }

 private:
  [[nodiscard]] fs::path saved() const { return folder_.path() / "saved"; }
  [[nodiscard]] std::size_t starts() const { return count_of("http://", program_.words()); }

  [[nodiscard]] std::size_t refusals() const {
    return count_of("continuing with the old settings", program_.err());
  }

  /// Of the newest run's page.
  [[nodiscard]] std::uint16_t port() const {
    const std::string words = program_.words();
    const std::size_t page = words.rfind("http://127.0.0.1:");
    if (page == words.npos) return 0;
    return static_cast<std::uint16_t>(std::strtoul(words.c_str() + page + 17, nullptr, 10));
  }

  void write(const std::string& text) const { write_file(folder_.path() / "rig.yaml", text); }

  RigSettings write(const RigSettings& settings) const {
    write(
        fmt::format("source: virtual\nworld: ideal\ncamera: 64x48\nrate: 60\n"
                    "strategy: dual-frequency\nsteps: {}\nhigh: {}\nminimum-modulation: {}\n"
                    "publish: [web:0]\n",
                    settings.steps, settings.high, settings.least_modulation));
    return settings;
  }

  /// Another valid file than those before.
  void write_other() {
    ++files_;
    file_ = write(RigSettings{
        .steps = 3 + files_ % 3, .high = 8 + files_ % 5, .least_modulation = 10 + files_ % 30});
  }

  /// A new run shows what is in the file; an invalid file leaves the old one alone.
  void begin_again() {
    shown_ = *file_;
    is_recording_ = false;
  }

  void reload() {
    const std::size_t begun = starts(), refused = refusals();
    program_.send(SIGHUP);
    if (file_) {
      RC_ASSERT(soon([&] { return starts() == begun + 1; }));
      begin_again();
    } else {
      RC_ASSERT(soon([&] { return refusals() == refused + 1; }));
    }
  }

  /// The second request comes while the first reload runs. They may become one.
  void reload_twice() {
    write_other();
    program_.send(SIGHUP);
    write_other();
    program_.send(SIGHUP);
    begin_again();

    // The service looks for requests every 20 ms, so none is left after a few clouds.
    RC_ASSERT(soon([&] { return shows_model() && clouds() > 15; }));
  }

  void set() {
    shown_.least_modulation = 41 + files_++ % 9;
    RC_ASSERT(ask(port(), "POST /settings",
                  fmt::format("minimum-modulation={}", shown_.least_modulation)));
  }

  void record(bool on) {
    RC_ASSERT(ask(port(), "POST /settings", on ? "record=on" : "record=off"));
    is_recording_ = on;
  }

  /// Saves come a second apart at most, and need a cloud.
  void save() {
    std::optional<std::string> folder;
    RC_ASSERT(soon([&] { return (folder = ask(port(), "POST /save")).has_value(); }));
    RC_ASSERT(fs::exists(fs::path(*folder) / "scan.yaml"));
    RC_ASSERT(folders_.insert(*folder).second);
  }

  [[nodiscard]] std::size_t clouds() const {
    const auto answer = ask(port(), "GET /statistics");
    return answer ? nlohmann::json::parse(*answer).at("clouds").get<std::size_t>() : 0;
  }

  [[nodiscard]] bool shows_model() const {
    const auto answer = ask(port(), "GET /settings");
    if (!answer) return false;

    const nlohmann::json all = nlohmann::json::parse(*answer);
    const auto value = [&](std::string_view name) {
      const auto found = std::ranges::find_if(
          all, [&](const nlohmann::json& setting) { return setting.at("name") == name; });
      return found == all.end() ? "" : found->at("value").get<std::string>();
    };

    return value("strategy") == shown_.strategy() &&
           value("minimum-modulation") == std::to_string(shown_.least_modulation) &&
           value("record") == (is_recording_ ? "on" : "off");
  }

  TemporaryFolder folder_;
  int files_ = 0;  ///< numbers the contents of files, and values that were set

  // The model:
  RigSettings shown_;
  bool is_recording_ = false;
  std::set<std::string> folders_;  ///< of saves

  std::optional<RigSettings> file_ = write(shown_);  ///< nullopt while the rig file is invalid
  RunningProgram program_{
      {"serve", (folder_.path() / "rig.yaml").string(), "--save-to", saved().string()}};
};

/// A few services, each of which takes a sequence of up to `most_steps` steps.
void check_services(int services, int most_steps) {
  const std::vector<std::string> steps{"reload",       "reload other", "reload invalid",
                                       "reload twice", "set",          "set invalid",
                                       "record on",    "record off",   "save"};

  check_sequences(steps, services, most_steps, [](const std::vector<std::string>& taken) {
    Service service;
    for (const std::string& step : taken) service.take(step);
    service.end();
  });
}

TEST(ServiceProgram, ShowsWhatItsFileAndItsChangesSay) {
  check_services(4, 6);
}

/// SLIPSTREAM_SERVICES=700 takes about 10,000 steps.
TEST(ServiceProgram, ShowsItAfterLongSequencesToo) {
  const char* services = std::getenv("SLIPSTREAM_SERVICES");
  check_services(services != nullptr ? std::stoi(services) : 30, 30);
}

}  // namespace slipstream::service_program_test
