#pragma once

#include <mutex>

#include <glog/logging.h>

namespace slipstream {

/// Silences Ceres' log while one lives: a failed step is retried smaller, and a library must not
/// write to its caller's terminal.
class QuietCeres {
 public:
  QuietCeres() {
    const std::scoped_lock lock(mutex);
    if (living++ > 0) return;
    level_before = FLAGS_minloglevel;
    FLAGS_minloglevel = google::GLOG_FATAL;
  }

  QuietCeres(const QuietCeres&) = delete;
  QuietCeres& operator=(const QuietCeres&) = delete;

  ~QuietCeres() {
    const std::scoped_lock lock(mutex);
    if (--living == 0) FLAGS_minloglevel = level_before;
  }

 private:
  // The log level is global.
  static inline std::mutex mutex;
  static inline int living = 0;
  static inline int level_before = 0;
};

}  // namespace slipstream
