#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/app/program.h"
#include "tests/faults/fault_protocol.h"

namespace slipstream {

/// The program, loaded once and run again and again with the same arguments, as fault_library does.
class FaultedProgram {
 public:
  /// `closely`: leaks are known by all of their frames, and those of libraries passed over; slow.
  FaultedProgram(const std::vector<std::string>& arguments, bool closely) {
    const std::filesystem::path record = folder_.path() / "record";
    std::ofstream(record) << "";
    std::filesystem::resize_file(record, sizeof(FaultRecord));
    const int file = ::open(record.c_str(), O_RDWR | O_CLOEXEC);
    void* const memory =
        ::mmap(nullptr, sizeof(FaultRecord), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    ::close(file);
    if (memory == MAP_FAILED) throw std::runtime_error("no memory for what is recorded");
    record_ = static_cast<FaultRecord*>(memory);
    for (const char* pipe : {"requests", "answers"}) {
      ::mkfifo((folder_.path() / pipe).c_str(), 0600);
    }
    const std::filesystem::path passed_over = folder_.path() / "leaks",
                                tests = SLIPSTREAM_SOURCE_FOLDER "/tests";
    std::ofstream(passed_over) << contents(tests / "view/driver_leaks.txt")
                               << contents(tests / "faults/library_leaks.txt");
    ::setenv("LD_PRELOAD", SLIPSTREAM_FAULT_LIBRARY " " SLIPSTREAM_LEAK_LIBRARY, 1);
    ::setenv("LSAN_OPTIONS",
             ("exitcode=99:print_suppressions=0:suppressions=" + passed_over.string() +
              (closely ? ":fast_unwind_on_malloc=0" : ""))
                 .c_str(),
             1);
    ::setenv("SLIPSTREAM_FAULTS_FROM", folder_.path().c_str(), 1);
    // Counts of ./dev coverage that a fault cuts off would spoil those of all other programs.
    ::setenv("GCOV_PREFIX", "/dev/null", 1);
    program_.emplace(arguments);
    ::unsetenv("LD_PRELOAD");
    ::unsetenv("GCOV_PREFIX");
    requests_ = ::open((folder_.path() / "requests").c_str(), O_WRONLY | O_CLOEXEC);
    answers_ = ::open((folder_.path() / "answers").c_str(), O_RDONLY | O_CLOEXEC);
  }
  FaultedProgram(const FaultedProgram&) = delete;
  FaultedProgram& operator=(const FaultedProgram&) = delete;
  ~FaultedProgram() {
    ::close(requests_);  // it ends
    ::close(answers_);
    ::munmap(record_, sizeof(FaultRecord));
  }

  /// The exit code, or what signal ended it, negative; SIGALRM where it hangs.
  int run(FaultRequest request) {
    record_->faults = record_->place = record_->events_made = 0;
    for (auto& calls : record_->calls) calls = 0;
    (void)!::write(requests_, &request, sizeof request);
    pollfd answered{answers_, POLLIN, 0};
    const bool hangs = ::poll(&answered, 1, 60000) == 0;
    if (hangs) ::kill(record_->process, SIGKILL);
    int status = 0;
    if (::read(answers_, &status, sizeof status) != sizeof status) return -SIGPIPE;
    return hangs ? -SIGALRM : WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

  [[nodiscard]] const FaultRecord& record() const { return *record_; }
  [[nodiscard]] std::string err() const { return program_->err(); }

 private:
  TemporaryFolder folder_;
  FaultRecord* record_ = nullptr;
  std::optional<RunningProgram> program_;
  int requests_ = -1, answers_ = -1;
};

}  // namespace slipstream
