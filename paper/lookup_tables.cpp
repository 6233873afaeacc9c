#include "paper/lookup_tables.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <time.h>

#include "base/statistics.h"
#include "decode/phase_decoder.h"
#include "paper/published_loops.h"
#include "reconstruct/fused/fused_engine.h"
#include "slipstream/named_scenes.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"

namespace slipstream {
namespace {

struct Operations {
  int multiplications = 0, divisions = 0, additions = 0;
};

/// A number that counts the operations on it.
class Counted {
 public:
  explicit Counted(Operations& count) : count_(&count) {}
  friend Counted operator+(Counted a, Counted) { return ++a.count_->additions, a; }
  friend Counted operator*(Counted a, Counted) { return ++a.count_->multiplications, a; }
  friend Counted operator/(double, Counted b) { return ++b.count_->divisions, b; }
  friend Counted operator/(Counted a, Counted) { return ++a.count_->divisions, a; }

 private:
  Operations* count_;
};

/// Operations of a form of the point table. All of its entries are one number, since only the
/// operations matter.
template <class Form>
Operations operations_of(const Form& form) {
  Operations count;
  form(Counted(count));
  return count;
}

Reproduction table_21(std::uint64_t /*seed*/) {
  const auto T = [](Counted v) { return 1.0 / (v * v + v); };  // the 1 of C y + 1 is an entry too
  const auto point = [](auto... coordinates) { return std::array{coordinates...}; };
  const Operations first = operations_of([&](Counted v) {
    const Counted t = T(v);
    return point((v * v + v) * t, (v * v + v) * t, (v * v + v) * t);
  });
  const Operations second = operations_of([&](Counted v) {
    const Counted t = T(v);
    return point(v + v * t, v + v * t, v + v * t);
  });
  const Operations third = operations_of([&](Counted v) {
    const Counted z = v + v / (v * v + v);
    return point(v * z + v, v * z + v, z);
  });
  const Operations ours = operations_of([&](Counted v) {
    const Counted z = v + v / (v * v + v);
    return point(v * z, v * z, z);
  });
  Reproduction result;
  const auto add = [&](const char* form, const Operations& printed, const Operations& counted,
                       const Operations* better) {
    const auto row = [&](const char* what, int Operations::*of) {
      result.add(fmt::format("{}, {}", what, form), {}, printed.*of, counted.*of,
                 better == nullptr ? std::nullopt : std::optional<double>(better->*of));
    };
    row("multiplications", &Operations::multiplications);
    row("divisions", &Operations::divisions);
    row("additions", &Operations::additions);
  };
  add("Eqs. (2.21)-(2.24)", {7, 1, 4}, first, nullptr);
  add("Eqs. (2.25)-(2.28)", {4, 1, 4}, second, nullptr);
  add("Eqs. (2.29)-(2.31)", {3, 1, 4}, third, &ours);
  result.notes.emplace_back("Counted by evaluating the equations with a type that counts.");
  result.notes.emplace_back(
      "Improved: in the camera's own frame, as in slipstream, F_x and F_y are 0.");
  return result;
}

double own_milliseconds() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

/// Milliseconds of `work`: the median of seven runs.
template <class Work>
double milliseconds_of(const Work& work) {
  std::vector<double> times;
  for (int run = 0; run <= 7; ++run) {
    const double start = own_milliseconds();
    work();
    if (run > 0) times.push_back(own_milliseconds() - start);  // the first fills the caches
  }
  return median(std::move(times));
}

/// The same of slipstream's fused pass, from frames to points, on one thread.
double milliseconds_of_fused(const VirtualScan& scan, int steps) {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const EngineSetup setup{.scanner = example_scanner(),
                          .sequence = {.strategy = PhaseMeasuring{.steps = steps, .frequency = 1},
                                       .projector = example_scanner().projector.size}};
  const FusedEngine engine = FusedEngine::make(setup, {}).value();
  FusedMemory memory;
  Cloud cloud;
  return milliseconds_of([&] { engine(scan.frames, {.cloud = &cloud}, memory); });
}

using Loop = void (PublishedLoops::*)();

/// A row of Table 2.2, with the printed milliseconds for N = 3, 4, 6.
struct TimedProcess {
  const char* name;
  std::vector<Loop> stages;
  std::array<double, 3> published;
};

const std::vector<TimedProcess>& timed_processes() {
  using Loops = PublishedLoops;
  static const std::vector<TimedProcess> processes{
      {"Eq. (1.4)", {&Loops::general_modulation}, {58.88, 67.34, 127.72}},
      {"Eq. (1.7)", {&Loops::general_phase}, {71.40, 79.53, 135.31}},
      {"*1 Eq. (1.15)", {&Loops::inverse}, {45.00, 44.85, 45.16}},
      {"*2 Eqs. (2.1), (2.2), (2.3)", {&Loops::closed_modulation}, {6.72, 2.34, 10.00}},
      {"*3 Eqs. (2.13), (2.14), (2.15)", {&Loops::closed_phase}, {17.97, 18.90, 18.75}},
      {"MLUT", {&Loops::mlut}, {0.94, 1.25, 2.18}},
      {"PLUT", {&Loops::plut}, {0.94, 1.25, 2.19}},
      {"MLUT and PLUT, combined", {&Loops::mlut_plut}, {1.40, 1.72, 2.81}},
      {"MLUT and PLUT for 2+1", {&Loops::two_plus_one}, {1.39, 0, 0}},
      {"3-D LUT, Eqs. (2.29), (2.30), (2.31)", {&Loops::form3}, {4.37, 4.37, 4.38}},
      {"traditional: *2, *3, and then *1",
       {&Loops::closed_modulation, &Loops::closed_phase, &Loops::inverse},
       {65.97, 65.0, 68.75}},
      {"MLUT and PLUT, and then 3-D LUT", {&Loops::mlut_plut, &Loops::form3}, {5.77, 6.09, 7.18}}};
  return processes;
}

/// A virtual scan of 640x480 pixels.
VirtualScan scan_of(int steps) {
  const Scanner scanner = example_scanner();
  return take_scan(scanner, scene_named("statue", scanner),
                   pattern_set(PhaseMeasuring{.steps = steps, .frequency = 1}, Axis::x),
                   {.ambient = 5, .noise_variance = 1.55});
}

/// Loops over a scan, which must outlive them.
PublishedLoops loops_over(const VirtualScan& scan) {
  return scan.frames.visit([&]<class Pixel>(const Frames<Pixel>& frames) -> PublishedLoops {
    if constexpr (sizeof(Pixel) == 1) return {example_scanner(), Axis::x, frames};
    throw std::logic_error("the virtual scanner gave no 8-bit frames");
  });
}

Reproduction table_22(std::uint64_t /*seed*/) {
  Reproduction result;
  std::array<double, 3> speed_up{}, speed_up_of_fused{};
  constexpr std::array<int, 3> counts{3, 4, 6};
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const VirtualScan scan = scan_of(counts[i]);
    PublishedLoops loops = loops_over(scan);
    loops.general();  // gives the rows of points their phase
    const double fused = milliseconds_of_fused(scan, counts[i]);
    double traditional = 0;
    for (const auto& [name, stages, published] : timed_processes()) {
      if (published[i] == 0) continue;
      const double time = milliseconds_of([&, &stages = stages] {
        for (const Loop stage : stages) (loops.*stage)();
      });
      const bool is_by_tables = stages.size() == 2;
      if (stages.size() == 3) traditional = time;
      if (is_by_tables) speed_up[i] = traditional / time;
      result.add(fmt::format("{}, ms", name), {{"N", counts[i]}}, published[i], time,
                 is_by_tables ? std::optional(fused) : std::nullopt);
      if (stages == std::vector<Loop>{&PublishedLoops::two_plus_one}) loops.general();
    }
    speed_up_of_fused[i] = traditional / fused;
  }
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const double published = std::array{65.97 / 5.77, 65.0 / 6.09, 68.75 / 7.18}[i];
    result.add("times as fast by tables as traditional", {{"N", counts[i]}}, published, speed_up[i],
               speed_up_of_fused[i]);
  }
  result.notes.emplace_back(
      "Recomputed: processor time of this machine. The gain is smaller than printed because "
      "processors have become faster at arctangents, roots and the matrix inverse (*1, *2, *3) "
      "than at reading tables.");
  result.notes.emplace_back(
      "Improved: the fused pass on one thread, which also corrects the projector's lens. "
      "\"Traditional\" is the print's: closed forms and matrix inverse, not Eqs. (1.4) and (1.7).");
  result.notes.emplace_back(
      "For N = 6 each table has 16.7 MB, more than most second-level caches, so Eq. (2.3) can be "
      "faster than the MLUT.");
  result.notes.emplace_back(
      "Eqs. (1.4) and (1.7) take sines and cosines from a list; the print computes them per pixel. "
      "2+1 uses the tables of N = 4.");
  return result;
}

/// Every `step`-th entry of a table, NaN where the reflectivity would exceed 1.
Image<double> picture_of(const PhaseTables& tables, bool phase) {
  constexpr double largest = 127.5;
  const int step = tables.form().steps == 6 ? 4 : 2;
  Image<double> drawn({2 * (tables.largest_U() / step) + 1, 2 * (tables.largest_V() / step) + 1});
  for_each_pixel_in_order(drawn.size(), [&](int column, int row) {
    const int U = step * (column - drawn.width() / 2), V = step * (row - drawn.height() / 2);
    const double B = tables.mlut(U, V);
    drawn(column, row) = B > largest ? std::nan("") : phase ? tables.plut(U, V) : B / largest;
  });
  return drawn;
}

Reproduction figure_21(std::uint64_t /*seed*/) {
  Reproduction result;
  for (const int steps : {3, 4, 6}) {
    const PhaseTables tables(steps);
    const Image<double> mlut = picture_of(tables, false);
    const double share = 100.0 * static_cast<double>(finite_values(mlut).size()) /
                         static_cast<double>(mlut.pixel_count());
    result.add("entries with a reflectivity of at most 1, %", {{"N", steps}}, {}, share);
    result.draw_map(fmt::format("figure-2.1-mlut-{}", steps), mlut, "alpha");
    result.draw_map(fmt::format("figure-2.1-plut-{}", steps), picture_of(tables, true), "phi, rad");
  }
  result.notes.emplace_back(
      "U runs across and V down, for N = 3, 4, 6. The valid entries of the MLUT fill an ellipse, "
      "for N = 4 a circle.");
  return result;
}

}  // namespace

std::vector<Reproducible> lookup_table_reproducibles() {
  return {{"figure", "2.1", "tables of modulation and phase", figure_21},
          {"table", "2.1", "operations of the three forms of the point table", table_21},
          {"table", "2.2", "times of the stages, 640x480, one thread", table_22}};
}

}  // namespace slipstream
