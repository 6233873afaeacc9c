#include "bench/bench_report.h"

#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace slipstream {
namespace {

/// Rows reported by how many times as fast the fused pass is; other ratios are of times.
constexpr std::array peers{"lut", "traditional", "equations", "simd", "opencv-psp", "opencv-hand"};
constexpr std::array<std::pair<const char*, const char*>, 6> relatives{
    {{"engine", "time of the public call, over the time of the fused pass alone:"},
     {"clean", "time of cleaning a cloud by default, over the time of the fused pass alone:"},
     {"live-check", "time of live's check of a cycle of 3 frames, over the time of one cloud:"},
     {"model-view", "time of adding a view to a model, over the time of the fused pass:"},
     {"fused-corrected", "time with a phase correction, over the time without:"},
     {"fused-dual", "time of two frequencies (6 frames), over the time of one:"}}};

bool is_fused_of_three(const TimedRow& timed) {
  return timed.row.name == "fused" && timed.row.steps == 3;
}

/// Row with this name and N, 640x480, on one thread; null if there is none.
const TimedRow* find(const std::vector<TimedRow>& rows, const std::string& name, int steps) {
  const auto found = std::find_if(rows.begin(), rows.end(), [&](const TimedRow& timed) {
    return timed.row.name == name && timed.row.steps == steps && timed.row.width == 640 &&
           timed.row.threads == 1;
  });
  return found == rows.end() ? nullptr : &*found;
}

template <class Value>
void add_once(std::vector<Value>& values, const Value& value) {
  if (std::find(values.begin(), values.end(), value) == values.end()) values.push_back(value);
}

std::string cell(const TimedRow* timed) {
  if (timed == nullptr) return fmt::format("{:>26}", "");
  const auto& [median, lower_quartile, upper_quartile, runs] = timed->timing;
  return fmt::format("{:>9.3f} ms +-{:>3.0f}%{:>7.0f}/s", median,
                     50 * (upper_quartile - lower_quartile) / median, timed->runs_per_second());
}

std::string table_by_steps(const std::vector<TimedRow>& rows) {
  std::vector<std::string> names;
  std::vector<int> steps;
  for (const TimedRow& timed : rows) {
    if (timed.row.is_coding) continue;
    add_once(names, timed.row.name);
    add_once(steps, timed.row.steps);
  }
  std::string text = fmt::format("{:<18}", "640x480, one thread");
  for (const int N : steps) text += fmt::format("{:>26}", fmt::format("N = {}", N));
  for (const std::string& name : names) {
    text += fmt::format("\n{:<18}", name);
    for (const int N : steps) text += cell(find(rows, name, N));
  }
  return text + "\n";
}

std::string codings(const BenchReport& report) {
  std::string text = "\nother codings, vectors   ms      fps   of fused, N = 3\n";
  for (const TimedRow& timed : report.rows) {
    if (!timed.row.is_coding) continue;
    text += fmt::format("{:<18} {:>8.3f} {:>8.0f} {:>17.2f}\n", timed.row.name, timed.timing.median,
                        timed.runs_per_second(), report.ratios.over_fused.at(timed.row.name));
  }
  return text;
}

std::string sizes(const BenchReport& report) {
  std::string text =
      "\nfused, N = 3        threads        ms      fps   ns/pixel   bytes/pixel   of bandwidth\n";
  for (const TimedRow& timed : report.rows) {
    if (!is_fused_of_three(timed)) continue;
    const auto& [row, timing] = timed;
    text += fmt::format(
        "{:>5}x{:<4} {:>5.1f} MP {:>6} {:>11.3f} {:>8.0f} {:>10.3f} {:>13.1f} {:>13.0f}%\n",
        row.width, row.height, 1e-6 * row.pixels(), row.threads, timing.median,
        timed.runs_per_second(), 1e6 * timing.median / row.pixels(), row.bytes_per_pixel,
        100 * timed.bytes_per_second() / report.machine.bandwidth);
  }
  return text;
}

/// Rows of the GPU, each with the fused pass's row of the same result.
std::string beside_gpu(const std::vector<TimedRow>& rows) {
  std::string text =
      "\nframes to                                gpu ms        /s   GB/s   fused ms   "
      "times as fast\n";
  for (const TimedRow& timed : rows) {
    const auto& [row, timing] = timed;
    if (row.name.find("gpu") == std::string::npos) continue;
    std::string name = "fused" + row.name.substr(row.name.rfind("gpu") + 3);
    if (const auto end = name.find("resident"); end != std::string::npos) {
      name.replace(end, std::string::npos, "cloud");
    }
    const auto fused = std::find_if(rows.begin(), rows.end(), [&](const TimedRow& other) {
      return other.row.name == name && other.row.width == row.width;
    });
    text += fmt::format("{:<20} {:>5}x{:<5} {:>14.3f} {:>9.1f} {:>6.1f}", row.name, row.width,
                        row.height, timing.median, timed.runs_per_second(),
                        1e-9 * timed.bytes_per_second());
    if (fused != rows.end()) {
      text += fmt::format(" {:>10.3f} {:>15.2f}", fused->timing.median,
                          fused->timing.median / timing.median);
    }
    text += "\n";
  }
  return text;
}

std::string ratios(const BenchRatios& ratios) {
  std::string text = "\nN = 3, 640x480, one thread, fused against\n";
  const auto& over_fused = ratios.over_fused;
  for (const char* name : peers) {
    if (const auto peer = over_fused.find(name); peer != over_fused.end()) {
      text += fmt::format("  {:<12} {:.1f} times as fast\n", name, peer->second);
    }
  }
  const auto add = [&](const char* words, double ratio) {
    text += fmt::format("  {} {:.2f}\n", words, ratio);
  };
  for (const auto& [name, words] : relatives) {
    if (const auto one = over_fused.find(name); one != over_fused.end()) add(words, one->second);
  }
  if (ratios.largest_per_pixel) {
    add("time per pixel of the largest picture, over the time at 640x480:",
        *ratios.largest_per_pixel);
  }
  if (ratios.threads) add("time on one thread, over the time on all:", *ratios.threads);
  return text;
}

}  // namespace

BenchRatios bench_ratios(const std::vector<TimedRow>& rows) {
  BenchRatios ratios;
  const TimedRow* fused = find(rows, "fused", 3);
  if (fused == nullptr) return ratios;
  const auto set = [&](const TimedRow* timed) {
    if (timed == nullptr) return;
    ratios.over_fused[timed->row.name] = timed->timing.median / fused->timing.median;
  };
  for (const char* name : peers) set(find(rows, name, 3));
  for (const auto& [name, words] : relatives) set(find(rows, name, 3));
  const TimedRow* largest = fused;
  for (const TimedRow& timed : rows) {
    if (timed.row.is_coding) set(&timed);
    if (!is_fused_of_three(timed)) continue;
    const bool alone = timed.row.threads == 1;
    if (alone && timed.row.width > largest->row.width) largest = &timed;
    if (!alone && timed.row.width == 640) {
      ratios.threads = fused->timing.median / timed.timing.median;
    }
  }
  const auto per_pixel = [](const TimedRow& timed) {
    return timed.timing.median / timed.row.pixels();
  };
  if (largest != fused) ratios.largest_per_pixel = per_pixel(*largest) / per_pixel(*fused);
  return ratios;
}

std::string text_of(const BenchMachine& machine) {
  return fmt::format("machine: {}, vectors: {}\nstreaming bandwidth of one thread: {:.1f} GB/s\n",
                     machine.processor, machine.vectors, 1e-9 * machine.bandwidth);
}

std::string text_of(const BenchReport& report) {
  if (!report.rows.empty() && report.rows.front().row.is_beside_gpu) return beside_gpu(report.rows);
  std::string text = table_by_steps(report.rows) + codings(report) + sizes(report) +
                     ratios(report.ratios) + "\npublished, frames to cloud, 640x480, N = 3:";
  for (const PublishedMark& mark : published_marks) {
    text += fmt::format("\n  {:>4}/s  {}", mark.fps, mark.source);
  }
  return text;
}

}  // namespace slipstream
