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

/// All that a sink of this machine answers; empty if none does.
std::string answer_of(std::uint16_t port, const std::string& request) {
  const Descriptor socket(::socket(AF_INET, SOCK_STREAM, 0));
  const timeval patience{.tv_sec = 10, .tv_usec = 0};
  ::setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));

  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(port);
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::connect(socket, reinterpret_cast<const sockaddr*>(&to), sizeof(to)) != 0) return {};

  if (::send(socket, request.data(), request.size(), MSG_NOSIGNAL) < 0) return {};
  ::shutdown(socket, SHUT_WR);

  std::string answer;
  char bytes[4096];
  ssize_t got = 0;
  while ((got = ::recv(socket, bytes, sizeof(bytes), 0)) > 0) {
    answer.append(bytes, static_cast<std::size_t>(got));
  }
  return answer;
}

/// The body of the page's answer; nullopt unless it has status 200. `what`: "GET /settings".
std::optional<std::string> ask(std::uint16_t port, const std::string& what,
                               const std::string& body = {}) {
  const std::string answer = answer_of(
      port, fmt::format("{} HTTP/1.1\r\nHost: 127.0.0.1:{}\r\nOrigin: http://127.0.0.1:{}\r\n"
                        "Connection: close\r\nContent-Length: {}\r\n\r\n{}",
                        what, port, port, body.size(), body));
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

/// A service, and what it should show. Its camera is the virtual one, or one on the network.
class Service {
 public:
  explicit Service(bool has_camera) : has_camera_(has_camera) {
    if (has_camera) serve_camera();
    program_.emplace(std::vector<std::string>{"serve", (folder_.path() / "rig.yaml").string(),
                                              "--save-to", saved().string()});
    RC_ASSERT(soon([&] { return has_begun(1); }));
  }

  /// One step, after which the service must show what the model says. Without its camera it does
  /// not save, and after a reload it waits for the camera.
  void take(const std::string& step) {
    if (step == "camera gone" && is_there()) lose_camera();
    if (step == "camera back" && !is_there()) find_camera();
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
    if (step == "reload twice" && is_there()) reload_twice();
    if (step == "set invalid") RC_ASSERT(!ask(port(), "POST /settings", "minimum-modulation=200"));
    if (step == "save" && is_there()) save();
    if (step == "capture") capture();
    if (runs_) {
      if (step == "set") set();
      if (step == "record on" || step == "record off") record(step == "record on");
    }

    RC_ASSERT(soon([&] { return shows_model(); }));
  }

  /// Ends it; all its files are complete.
  void end() {
    program_->send(SIGTERM);
    RC_ASSERT(program_->wait() == 0);

    if (!fs::exists(saved())) return;
    for (const fs::directory_entry& entry : fs::directory_iterator(saved())) {
      const fs::path& path = entry.path();
      RC_ASSERT(path.extension() != ".part");
      if (path.extension() == ".slip") RC_ASSERT(RecordingReader(path).finished());
    }
  }

 private:
  [[nodiscard]] fs::path saved() const { return folder_.path() / "saved"; }
  [[nodiscard]] std::size_t starts() const { return count_of("http://", program_->words()); }

  /// Whether that many runs have begun, the last with frames of a camera that may be lost.
  [[nodiscard]] bool has_begun(std::size_t runs) const {
    return starts() == runs && (!has_camera_ || clouds() > 0);
  }

  [[nodiscard]] std::size_t refusals() const {
    return count_of("continuing with the old settings", program_->err());
  }

  /// Of the newest run's sink: its page, or the place of controllers.
  [[nodiscard]] std::uint16_t port(std::string_view kind = "http") const {
    const std::string words = program_->words(), address = fmt::format("{}://127.0.0.1:", kind);
    const std::size_t at = words.rfind(address);
    if (at == words.npos) return 0;
    return static_cast<std::uint16_t>(
        std::strtoul(words.c_str() + at + address.size(), nullptr, 10));
  }

  [[nodiscard]] bool is_there() const { return !has_camera_ || camera_; }

  void serve_camera() {
    camera_.emplace(std::vector<std::string>{
        "camera", "serve", "--world", "ideal", "--camera", "64x48", "--strategy", "dual-frequency",
        "--steps", "4", "--high", "16", "--cycles", "1", "--write-scanner",
        (folder_.path() / "scanner.yaml").string()});
    RC_ASSERT(camera_->wait_for_words("serving"));
  }

  void lose_camera() {
    camera_.reset();
    RC_ASSERT(!runs_ || soon([&] { return !ask(port(), "GET /health"); }));
  }

  void find_camera() {
    const std::size_t begun = starts();
    serve_camera();
    if (!runs_) {
      RC_ASSERT(soon([&] { return has_begun(begun + 1); }));
      begin_again();
    }
    RC_ASSERT(soon([&] { return ask(port(), "GET /health").has_value(); }));
  }

  void write(const std::string& text) const { write_file(folder_.path() / "rig.yaml", text); }

  RigSettings write(const RigSettings& settings) const {
    const char* const source =
        has_camera_ ? "source: aravis:127.0.0.1\nscanner: scanner.yaml\nindexing: counted\n"
                    : "source: virtual\nworld: ideal\ncamera: 64x48\n";
    write(
        fmt::format("{}rate: 60\nstrategy: dual-frequency\nsteps: {}\nhigh: {}\n"
                    "minimum-modulation: {}\npublish: [web:0, tcp:0]\n",
                    source, settings.steps, settings.high, settings.least_modulation));
    return settings;
  }

  /// Another valid file than those before. A camera on the network keeps its patterns.
  void write_other() {
    ++files_;
    RigSettings other{.least_modulation = 10 + files_ % 30};
    if (!has_camera_) {
      other.steps = 3 + files_ % 3;
      other.high = 8 + files_ % 5;
    }
    file_ = write(other);
  }

  /// A new run shows what its file said.
  void begin_again() {
    runs_ = true;
    shown_ = settings_;
    is_recording_ = false;
    last_frame_ = -1;
  }

  /// An invalid file leaves the run alone. A valid one ends it even without the camera, for which
  /// the old settings then wait.
  void reload() {
    const std::size_t begun = starts(), refused = refusals();
    program_->send(SIGHUP);
    if (file_ && is_there()) {
      RC_ASSERT(soon([&] { return has_begun(begun + 1); }));
      settings_ = *file_;
      begin_again();
    } else {
      RC_ASSERT(soon([&] { return refusals() == refused + 1; }));
      if (file_) runs_ = false;
    }
  }

  /// The second request comes while the first reload runs. They may become one.
  void reload_twice() {
    write_other();
    program_->send(SIGHUP);
    write_other();
    program_->send(SIGHUP);
    settings_ = *file_;
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

  /// A scan for a controller is of frames after those of the one before.
  void capture() {
    const double patience = is_there() ? 5 : 0.1;  // s
    const std::string request = fmt::format("{{\"do\": \"scan\", \"timeout\": {}}}\n", patience);
    const auto scan = nlohmann::json::parse(answer_of(port("tcp"), request), nullptr, false);
    RC_ASSERT(scan.is_object() == runs_);
    if (!runs_) return;

    RC_ASSERT(scan.at("ok").get<bool>() == is_there());
    if (!is_there()) return;
    RC_ASSERT(scan.at("width") == 64);
    RC_ASSERT(scan.at("frame").get<std::int64_t>() > last_frame_);
    last_frame_ = scan.at("frame").get<std::int64_t>();
  }

  [[nodiscard]] std::size_t clouds() const {
    const auto answer = ask(port(), "GET /statistics");
    return answer ? nlohmann::json::parse(*answer).at("clouds").get<std::size_t>() : 0;
  }

  [[nodiscard]] bool shows_model() const {
    const auto answer = ask(port(), "GET /settings");
    if (!answer || !runs_) return answer.has_value() == runs_;

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

  const bool has_camera_;
  TemporaryFolder folder_;
  std::optional<RunningProgram> camera_, program_;
  int files_ = 0;  ///< numbers the contents of files, and values that were set

  // The model:
  bool runs_ = true;      ///< false: it waits for the camera
  RigSettings settings_;  ///< of the file that the run began with
  RigSettings shown_ = settings_;
  bool is_recording_ = false;
  std::int64_t last_frame_ = -1;                        ///< of the run's last capture
  std::set<std::string> folders_;                       ///< of saves
  std::optional<RigSettings> file_ = write(settings_);  ///< nullopt while the rig file is invalid
};

/// A few services, each of which takes a sequence of up to `most_steps` steps.
void check_services(int services, int most_steps, bool has_camera = false) {
  std::vector<std::string> steps{"reload", "reload other", "reload invalid", "reload twice",
                                 "set",    "set invalid",  "record on",      "record off",
                                 "save",   "capture"};
  if (has_camera) steps.insert(steps.end(), {"camera gone", "camera back"});

  check_sequences(steps, services, most_steps, [&](const std::vector<std::string>& taken) {
    Service service(has_camera);
    for (const std::string& step : taken) service.take(step);
    service.end();
  });
}

/// SLIPSTREAM_SERVICES=700 takes about 10,000 steps.
int services_wanted() {
  const char* services = std::getenv("SLIPSTREAM_SERVICES");
  return services != nullptr ? std::stoi(services) : 30;
}

TEST(ServiceProgram, ShowsWhatItsFileAndItsChangesSay) {
  check_services(4, 6);
}

TEST(ServiceProgram, ShowsItAfterLongSequencesToo) {
  check_services(services_wanted(), 30);
}

/// One machine serves one camera at a time.
class ServiceProgramCamera : public testing::Test {
 protected:
  void SetUp() override {
    const ProgramRun camera =
        run_program({"camera", "serve", "--camera", "16x12", "--duration", "0.01"});
    if (camera.exit_code != 0) GTEST_SKIP() << camera.err;
  }
};

TEST_F(ServiceProgramCamera, GoesAndComesBack) {
  check_services(4, 6, true);
}

TEST_F(ServiceProgramCamera, GoesAndComesBackInLongSequencesToo) {
  check_services(services_wanted(), 30, true);
}

}  // namespace slipstream::service_program_test
