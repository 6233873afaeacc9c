#include "slipstream/check/mistaken_orders.h"

#include <algorithm>
#include <numeric>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace slipstream {
namespace {

FrameOrder in_order(int count) {
  FrameOrder order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), 0);
  return order;
}

/// The runs of steps that share no frame; the whole cycle where there are none.
std::vector<StepRun> runs_of(const Layout& layout) {
  std::vector<StepRun> runs;
  for (const Band& band : layout.bands) {
    if (const auto run = step_run(band);
        run && std::find(runs.begin(), runs.end(), *run) == runs.end()) {
      runs.push_back(*run);
    }
  }
  std::sort(runs.begin(), runs.end(),
            [](const StepRun& a, const StepRun& b) { return a.first < b.first; });
  if (runs.empty()) runs.push_back({0, layout.frames});
  return runs;
}

FrameOrder::iterator begin_of(FrameOrder& order, const StepRun& run) {
  return order.begin() + run.first;
}

FrameOrder rotated(FrameOrder order, const StepRun& run, int places) {
  std::rotate(begin_of(order, run), begin_of(order, run) + places,
              begin_of(order, run) + run.steps);
  return order;
}

FrameOrder reversed(FrameOrder order, const StepRun& run) {
  std::reverse(begin_of(order, run), begin_of(order, run) + run.steps);
  return order;
}

std::string frames_text(const StepRun& run) {
  return fmt::format("frames {} to {}", run.first, run.first + run.steps - 1);
}

class Orders {
 public:
  explicit Orders(int frames) : right_(in_order(frames)) { known_.insert(right_); }

  void add(FrameOrder order, std::string words,
           MistakenOrder::Kind kind = MistakenOrder::Kind::usual) {
    if (known_.insert(order).second) list_.push_back({std::move(order), std::move(words), kind});
  }
  [[nodiscard]] const FrameOrder& right() const { return right_; }
  [[nodiscard]] std::vector<MistakenOrder> take() { return std::move(list_); }

 private:
  FrameOrder right_;
  std::set<FrameOrder> known_;
  std::vector<MistakenOrder> list_;
};

/// Every run rotated by the same share of a period, forwards or reversed: the phases go on
/// agreeing.
void add_common_turns(const std::vector<StepRun>& runs, Orders& orders) {
  int least = runs.front().steps;
  for (const StepRun& run : runs) least = std::gcd(least, run.steps);
  FrameOrder backwards = orders.right();
  for (const StepRun& run : runs) backwards = reversed(backwards, run);
  orders.add(backwards, "the frames of each band are in reversed order");
  for (int part = 1; part < least; ++part) {
    FrameOrder turned = orders.right(), turned_back = backwards;
    for (const StepRun& run : runs) {
      turned = rotated(turned, run, part * run.steps / least);
      turned_back = rotated(turned_back, run, part * run.steps / least);
    }
    orders.add(turned, runs.size() == 1 ? fmt::format("the frames are rotated by {}", part)
                                        : "the frames of each band are rotated");
    orders.add(turned_back, "the frames of each band are in reversed order");
  }
}

void add_single_turns(const std::vector<StepRun>& runs, Orders& orders) {
  for (const StepRun& run : runs) {
    for (int places = 1; places < run.steps; ++places) {
      orders.add(rotated(orders.right(), run, places),
                 fmt::format("{} look rotated by {}", frames_text(run), run.steps - places));
    }
    orders.add(reversed(orders.right(), run), fmt::format("{} look reversed", frames_text(run)));
    for (int places = 1; places < run.steps; ++places) {
      orders.add(rotated(reversed(orders.right(), run), run, places),
                 fmt::format("{} look reversed", frames_text(run)));
    }
  }
}

void add_two_runs(const std::vector<StepRun>& runs, Orders& orders) {
  if (runs.size() != 2) return;
  const auto [a, b] = std::pair(runs[0], runs[1]);
  if (a.steps + b.steps != static_cast<int>(orders.right().size())) return;
  FrameOrder swapped;
  for (int n = 0; n < a.steps; ++n) swapped.push_back(a.first + b.steps + n);
  for (int n = 0; n < b.steps; ++n) swapped.push_back(n);
  orders.add(swapped, "the frames of the two bands are swapped");
  orders.add(FrameOrder(orders.right().rbegin(), orders.right().rend()),
             "all frames are in reversed order");
  if (a.steps != b.steps) return;
  FrameOrder in_turns, in_turns_from_second;
  for (int n = 0; n < a.steps; ++n) in_turns.push_back(2 * n);
  for (int n = 0; n < a.steps; ++n) in_turns.push_back(2 * n + 1);
  for (int n = 0; n < a.steps; ++n) in_turns_from_second.push_back(2 * n + 1);
  for (int n = 0; n < a.steps; ++n) in_turns_from_second.push_back(2 * n);
  orders.add(in_turns, "the frames of the two bands are interleaved");
  orders.add(in_turns_from_second, "the frames of the two bands are interleaved");
}

}  // namespace

std::vector<MistakenOrder> mistaken_orders(const Layout& layout) {
  const std::vector<StepRun> runs = runs_of(layout);
  Orders orders(layout.frames);
  if (runs.size() > 1) {
    for (int places = 1; places < layout.frames; ++places) {
      orders.add(rotated(orders.right(), {0, layout.frames}, places),
                 fmt::format("the frames have slipped: the cycle begins at frame {}", places),
                 MistakenOrder::Kind::slipped);
    }
  }
  add_two_runs(runs, orders);
  add_common_turns(runs, orders);
  for (int n = 0; n + 1 < layout.frames; ++n) {
    FrameOrder exchanged = orders.right();
    std::swap(exchanged[static_cast<std::size_t>(n)], exchanged[static_cast<std::size_t>(n) + 1]);
    orders.add(std::move(exchanged), fmt::format("frames {} and {} look swapped", n, n + 1));
  }
  add_single_turns(runs, orders);
  for (int n = 0; n < layout.frames; ++n) {
    for (int m = n + 2; m < layout.frames; ++m) {
      FrameOrder exchanged = orders.right();
      std::swap(exchanged[static_cast<std::size_t>(n)], exchanged[static_cast<std::size_t>(m)]);
      orders.add(std::move(exchanged), fmt::format("frames {} and {} look swapped", n, m),
                 MistakenOrder::Kind::far_fetched);
    }
  }
  return orders.take();
}

FrameOrder composed(const FrameOrder& first, const FrameOrder& then) {
  if (first.empty()) return then;
  FrameOrder both;
  for (const int place : then) both.push_back(first.at(static_cast<std::size_t>(place)));
  return both;
}

std::string text_of(const FrameOrder& order) {
  return fmt::format("{}", fmt::join(order, ","));
}

}  // namespace slipstream
