#include "tests/app/program.h"

#include <chrono>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <stdexcept>
#include <thread>
#include <utility>

#include <fcntl.h>
#include <linux/capability.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "io/file.h"

namespace slipstream {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

void redirect(int descriptor, const fs::path& path, int flags) {
  const int file = ::open(path.c_str(), flags, 0600);
  if (file < 0 || ::dup2(file, descriptor) < 0) ::_exit(126);
}

}  // namespace

RunningProgram::RunningProgram(const std::vector<std::string>& arguments, long largest_file,
                               int descriptors) {
  const fs::path out = folder_->path() / "out", err = folder_->path() / "err";
  std::vector<const char*> argv{SLIPSTREAM_PROGRAM};
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  argv.push_back(nullptr);

  process_ = ::fork();
  if (process_ != 0) return;

  // Root, too, writes only where permissions allow it.
  ::prctl(PR_CAPBSET_DROP, CAP_DAC_OVERRIDE);
  redirect(STDIN_FILENO, "/dev/null", O_RDONLY);
  redirect(STDOUT_FILENO, out, O_WRONLY | O_CREAT);
  redirect(STDERR_FILENO, err, O_WRONLY | O_CREAT);
  // Counts of ./dev coverage that are cut off would spoil those of all other programs.
  if (largest_file >= 0 || descriptors >= 0) ::setenv("GCOV_PREFIX", "/dev/null", 1);

  if (largest_file >= 0) {
    const rlimit limit{static_cast<rlim_t>(largest_file), static_cast<rlim_t>(largest_file)};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    ::signal(SIGXFSZ, SIG_IGN);
  }
  if (descriptors >= 0) {
    // None but the standard streams stay open, of the test's and of those redirected.
    for (int descriptor = 3; descriptor < 1024; ++descriptor) ::close(descriptor);
    const rlimit limit{static_cast<rlim_t>(descriptors), static_cast<rlim_t>(descriptors)};
    ::setrlimit(RLIMIT_NOFILE, &limit);
  }
  ::execv(argv[0], const_cast<char* const*>(argv.data()));
  ::_exit(127);
}

RunningProgram::RunningProgram(RunningProgram&& other) noexcept
    : folder_(std::move(other.folder_)), process_(std::exchange(other.process_, -1)) {}

RunningProgram::~RunningProgram() {
  if (process_ <= 0) return;
  send(SIGKILL);
  (void)wait();
}

void RunningProgram::send(int signal) const {
  ::kill(process_, signal);
}

int RunningProgram::wait() {
  int status = 0;
  rusage used{};
  ::wait4(std::exchange(process_, -1), &status, 0, &used);
  memory_ = 1024 * used.ru_maxrss;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

std::string RunningProgram::out() const {
  return contents(folder_->path() / "out");
}

std::string RunningProgram::err() const {
  return contents(folder_->path() / "err");
}

std::string RunningProgram::words() const {
  return out() + err();
}

bool RunningProgram::wait_for_words(const std::string& wanted) const {
  return wait_until([&] { return words().find(wanted) != std::string::npos; });
}

ProgramRun run_program(const std::vector<std::string>& arguments, long largest_file,
                       int descriptors) {
  RunningProgram program(arguments, largest_file, descriptors);
  const int exit_code = program.wait();
  return {exit_code, program.out(), program.err()};
}

void copy_simulated_scan(const std::vector<std::string>& flags, const fs::path& folder) {
  static std::map<std::vector<std::string>, std::unique_ptr<TemporaryFolder>> made;
  std::unique_ptr<TemporaryFolder>& kept = made[flags];
  if (!kept) {
    kept = std::make_unique<TemporaryFolder>();
    std::vector<std::string> arguments{"simulate", kept->path() / "scan"};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    const ProgramRun run = run_program(arguments);
    if (run.exit_code != 0) throw std::runtime_error(run.err);
  }
  fs::copy(kept->path() / "scan", folder, fs::copy_options::recursive);
}

bool wait_until(const std::function<bool()>& come) {
  constexpr int most_tries = 30'000;  // five minutes, in case of a hang
  for (int tries = 0; tries < most_tries && !come(); ++tries) std::this_thread::sleep_for(10ms);
  return come();
}

std::string contents(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace slipstream
