#include "slipstream/simulate/virtual_camera.h"

#include <thread>

#include "slipstream/base/throw_if-inl.h"

namespace slipstream {

Frame first_frame(const FrameSet& exposed) {
  Frame frame({exposed.size(), exposed.bits()});
  exposed.visit([&]<class Pixel>(const Frames<Pixel>& views) {
    if constexpr (std::is_integral_v<Pixel>) {
      auto& image = std::get<Image<Pixel>>(frame.pixels);
      std::copy_n(views[0].row(0), image.pixel_count(), image.begin());
    }
  });
  return frame;
}

std::vector<Frame> virtual_frames(const Scanner& scanner, const Scene& scene,
                                  const PatternSet& patterns, const Photometry& photometry,
                                  int cycles) {
  throw_if(cycles < 1, "{} cycles of patterns; expected 1 or more", cycles);
  throw_if(!photometry.bits, "a virtual camera has 8 to 16 bits; none are given");
  const bool moving = is_moving(scene);
  const int count = patterns.count * cycles;
  const std::optional<double> turn = frames_of_a_turn(scene);
  const bool round = turn && 2 * std::abs(count - *turn) <= patterns.count;
  std::vector<Frame> frames(count);
  std::optional<VirtualScan> seen;
  const auto expose = [&](int n) {
    const PatternSet pattern = pattern_alone(patterns, n % patterns.count);
    Photometry light = photometry;
    light.seed += static_cast<std::uint64_t>(n);
    Frame& frame = frames[n];
    if (seen) {
      frame = first_frame(take_again(*seen, pattern, light));
    } else {
      // Uniform rotation, or back and forth.
      const double time = round ? n : count / 4.0 - std::abs(n - count / 2.0);
      seen = take_scan(scanner, scene, pattern, light, time);
      frame = first_frame(seen->frames);
    }
    frame.stamp.sequence = static_cast<std::uint64_t>(n);
    frame.stamp.pattern_index = n % patterns.count;
  };
  // On its way back, the scene repeats its positions.
  for (int n = 0; n < (round ? count : count / 2 + 1); ++n) {
    if (moving) seen.reset();
    expose(n);
    if (!round && n > 0 && count - n > n) expose(count - n);
  }
  return frames;
}

Reel moved_board(const VirtualWorld& world, Body sheet, const std::vector<Eigen::Isometry3d>& poses,
                 const std::vector<PatternSet>& sets, int still_cycles,
                 const std::function<void()>& rendered) {
  throw_if(poses.empty() || sets.empty() || still_cycles < 1,
           "a moving board requires at least one pose, one set of patterns and one cycle");
  std::vector<PatternSet> cycle;  // each pattern separately, in the order shown
  for (const PatternSet& set : sets) {
    for (int n = 0; n < set.count; ++n) cycle.push_back(pattern_alone(set, n));
  }
  Photometry photometry = world.photometry;
  photometry.rays = 1;  // a printed sheet already has soft edges
  Reel reel;
  const auto expose = [&](const PatternSet& patterns) {
    std::vector<Frame> seen = virtual_frames(world.scanner, {sheet}, patterns, photometry, 1);
    photometry.seed += seen.size();
    std::ranges::move(seen, std::back_inserter(reel.frames));
  };
  for (std::size_t p = 0; p < poses.size(); ++p) {
    const std::size_t first = reel.frames.size();
    reel.enough = reel.order.size() + cycle.size();  // capturing a pose takes one cycle
    const Eigen::Isometry3d &here = poses[p], &next = poses[(p + 1) % poses.size()];
    const Eigen::Quaterniond turn(here.linear()), next_turn(next.linear());
    sheet.pose = here;
    for (const PatternSet& set : sets) expose(set);
    for (std::size_t k = 0; k < cycle.size() * still_cycles; ++k) {
      reel.order.push_back(first + k % cycle.size());
    }
    for (std::size_t k = 0; k < cycle.size(); ++k) {
      const double share = static_cast<double>(k + 1) / static_cast<double>(cycle.size() + 1);
      sheet.pose =
          Eigen::Translation3d((1 - share) * here.translation() + share * next.translation()) *
          turn.slerp(share, next_turn);
      reel.order.push_back(reel.frames.size());
      expose(cycle[k]);
    }
    rendered();
  }
  for (std::size_t k = 0; k < reel.order.size(); ++k) {
    reel.frames[reel.order[k]].stamp.pattern_index = static_cast<int>(k % cycle.size());
  }
  return reel;
}

VirtualCamera::VirtualCamera(Reel reel, std::optional<double> rate)
    : reel_(std::move(reel)), rate_(rate) {
  if (reel_.frames.empty()) throw Error("a virtual camera without frames; expected at least one");
  for (const Frame& frame : reel_.frames) {
    throw_if(frame.format() != format(),
             "a virtual camera with frames of several sizes or bits; all must have one format");
  }
  if (rate_ && !(*rate_ > 0 && std::isfinite(*rate_))) {
    throw Error(fmt::format("frame rate {} Hz is out of range; expected above 0", *rate_));
  }
}

void VirtualCamera::start() {
  start_ = Clock::now();
  sequence_ = 0;
}

std::optional<VirtualCamera::Clock::time_point> VirtualCamera::wait_until(Clock::time_point end) {
  const Clock::time_point now = Clock::now();
  if (!rate_) return now;
  const double taken = std::chrono::duration<double>(now - start_).count() * *rate_;
  const double behind = std::floor(taken) - static_cast<double>(sequence_) - waiting_frames;
  if (behind > 0) {
    sequence_ += static_cast<std::uint64_t>(behind);
    lost_ += static_cast<std::uint64_t>(behind);
  }
  const std::chrono::duration<double> due(static_cast<double>(sequence_ + 1) / *rate_);
  const Clock::time_point whole = start_ + std::chrono::duration_cast<Clock::duration>(due);
  // A sleep may end early by a tick of the system's clock.
  while (Clock::now() < std::min(whole, end)) std::this_thread::sleep_until(std::min(whole, end));
  if (whole > end) return std::nullopt;
  return whole;
}

Arrival VirtualCamera::next(Frame& frame, std::chrono::milliseconds timeout) {
  const auto whole = wait_until(Clock::now() + timeout);
  if (!whole) return Arrival::nothing;
  const Frame& seen = reel_.frames[reel_.order[sequence_ % reel_.order.size()]];
  frame = seen;
  frame.stamp = {.sequence = sequence_++,
                 .pattern_index = seen.stamp.pattern_index,
                 .device_time = *whole - start_,
                 .host_time = *whole};
  ++delivered_;
  return Arrival::frame;
}

}  // namespace slipstream
