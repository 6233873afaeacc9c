#include "slipstream/virtual_camera.h"

#include <thread>

#include "base/throw_if-inl.h"

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

namespace {

/// The scene as it is at `time`, without motion; nullopt if a body has another size then.
std::optional<Scene> at_rest(Scene scene, double time) {
  for (Body& body : scene) {
    const Eigen::Affine3d moved = body.motion.at(time);
    if (!moved.linear().isUnitary(1e-9)) return std::nullopt;
    body.pose = Eigen::Isometry3d(moved.matrix()) * body.pose;
    body.motion = {};
  }

  return scene;
}

}  // namespace

ReelScript looped_scene(const Scanner& scanner, const Scene& scene, const PatternSet& patterns,
                        const Photometry& photometry, int cycles, FirstRest first_rest) {
  throw_if(cycles < 1, "{} cycles of patterns; expected 1 or more", cycles);
  ReelScript script{.scanner = scanner, .photometry = photometry};
  for (int n = 0; n < patterns.count; ++n) script.cycle.push_back(pattern_alone(patterns, n));

  const int count = patterns.count * cycles;
  for (int n = 0; n < count; ++n) {
    script.patterns.push_back(n % patterns.count);
    script.order.push_back(n);
  }

  if (!is_moving(scene)) {
    script.moments.push_back({scene, 0, script.order});
    return script;
  }

  // 1. Uniform rotation, or back and forth.
  const std::optional<double> turn = frames_of_a_turn(scene);
  const bool round = turn && 2 * std::abs(count - *turn) <= patterns.count;
  const auto time_of = [&](int n) { return round ? n : count / 4.0 - std::abs(n - count / 2.0); };

  // 2. The rest before the loop.
  const auto rest = first_rest == FirstRest::none ? std::nullopt : at_rest(scene, time_of(0));
  if (rest) {
    // Repeated, the rest has two cycles: the same frames twice in a row would look like a mistake.
    const bool repeats = first_rest == FirstRest::until_rendered;
    Moment moment{*rest, 0, {}};
    for (int n = 0; n < (repeats ? 2 : 1) * patterns.count; ++n) {
      moment.frames.push_back(script.patterns.size());
      script.patterns.push_back(n % patterns.count);
    }
    if (repeats) script.holds = {0};
    script.hold_length = script.loop_from = moment.frames.size();
    script.order.insert(script.order.begin(), moment.frames.begin(), moment.frames.end());
    script.moments.push_back(std::move(moment));
  }

  // 3. The loop. On its way back, the scene repeats its positions.
  for (int n = 0; n < (round ? count : count / 2 + 1); ++n) {
    Moment moment{scene, time_of(n), {static_cast<std::size_t>(n)}};
    if (!round && n > 0 && count - n > n) moment.frames.push_back(count - n);
    script.moments.push_back(std::move(moment));
  }

  return script;
}

std::vector<Frame> virtual_frames(const Scanner& scanner, const Scene& scene,
                                  const PatternSet& patterns, const Photometry& photometry,
                                  int cycles) {
  return rendered(looped_scene(scanner, scene, patterns, photometry, cycles)).frames;
}

ReelScript moved_board(const VirtualWorld& world, Body sheet,
                       const std::vector<Eigen::Isometry3d>& poses,
                       const std::vector<PatternSet>& sets, int still_cycles) {
  throw_if(poses.empty() || sets.empty() || still_cycles < 1,
           "a moving board requires at least one pose, one set of patterns and one cycle");
  ReelScript script{.scanner = world.scanner, .photometry = world.photometry};
  script.photometry.rays = 1;  // a printed sheet already has soft edges

  for (const PatternSet& set : sets) {
    for (int n = 0; n < set.count; ++n) script.cycle.push_back(pattern_alone(set, n));
  }
  const std::size_t cycle = script.hold_length = script.cycle.size();

  for (std::size_t p = 0; p < poses.size(); ++p) {
    const Eigen::Isometry3d &here = poses[p], &next = poses[(p + 1) % poses.size()];

    // 1. Without motion: one cycle, shown again and again.
    const std::size_t first = script.patterns.size();
    script.enough = script.order.size() + cycle;  // capturing a pose takes one cycle
    script.holds.push_back(script.order.size() + (still_cycles - 1) * cycle);
    sheet.pose = here;
    Moment rest{{sheet}, 0, {}};
    for (std::size_t k = 0; k < cycle; ++k) {
      rest.frames.push_back(first + k);
      script.patterns.push_back(k);
    }
    script.moments.push_back(std::move(rest));
    for (std::size_t k = 0; k < cycle * still_cycles; ++k) {
      script.order.push_back(first + k % cycle);
    }

    // 2. On the way to the next pose: one frame in each position.
    const Eigen::Quaterniond turn(here.linear()), next_turn(next.linear());
    for (std::size_t k = 0; k < cycle; ++k) {
      const double share = static_cast<double>(k + 1) / static_cast<double>(cycle + 1);
      sheet.pose =
          Eigen::Translation3d((1 - share) * here.translation() + share * next.translation()) *
          turn.slerp(share, next_turn);
      script.moments.push_back({{sheet}, 0, {script.patterns.size()}});
      script.order.push_back(script.patterns.size());
      script.patterns.push_back(k);
    }
  }

  return script;
}

VirtualCamera::VirtualCamera(std::shared_ptr<const RenderedReel> reel, std::optional<double> rate)
    : player_(std::move(reel)), rate_(rate) {
  if (rate_ && !(*rate_ > 0 && std::isfinite(*rate_))) {
    throw Error(fmt::format("frame rate {} Hz is out of range; expected above 0", *rate_));
  }
}

void VirtualCamera::start() {
  start_ = pace_start_ = Clock::now();
  sequence_ = 0;
  is_late_ = false;
  player_.restart();
}

std::optional<VirtualCamera::Clock::time_point> VirtualCamera::wait_until(Clock::time_point end) {
  const Clock::time_point now = Clock::now();
  if (!rate_) return now;
  const double taken = std::chrono::duration<double>(now - pace_start_).count() * *rate_;
  const double behind = std::floor(taken) - static_cast<double>(sequence_) - waiting_frames;

  // Frames that no longer fit into the buffer are lost.
  if (behind > 0) {
    sequence_ += static_cast<std::uint64_t>(behind);
    lost_ += static_cast<std::uint64_t>(behind);
    player_.advance(static_cast<std::size_t>(behind));
  }

  const std::chrono::duration<double> due(static_cast<double>(sequence_ + 1) / *rate_);
  const Clock::time_point whole = pace_start_ + std::chrono::duration_cast<Clock::duration>(due);

  // A sleep may end early by a tick of the system's clock.
  while (Clock::now() < std::min(whole, end)) std::this_thread::sleep_until(std::min(whole, end));

  if (whole > end) return std::nullopt;
  return whole;
}

Arrival VirtualCamera::next(Frame& frame, std::chrono::milliseconds timeout) {
  const Clock::time_point end = Clock::now() + timeout;

  // 1. Rendered late, a frame comes late; the camera's pace goes on from it.
  is_late_ |= player_.frame() == nullptr;
  if (is_late_) {
    if (!player_.wait_for_frame(end)) return Arrival::nothing;
    if (rate_) {
      const std::chrono::duration<double> before(static_cast<double>(sequence_) / *rate_);
      pace_start_ = Clock::now() - std::chrono::duration_cast<Clock::duration>(before);
    }
    is_late_ = false;
  }

  // 2. The frame that is due: after losses not the one above.
  const auto whole = wait_until(end);
  if (!whole) return Arrival::nothing;
  const Frame* const seen = player_.frame();
  if (seen == nullptr) return Arrival::nothing;

  frame = *seen;
  frame.stamp = {.sequence = sequence_++,
                 .pattern_index = seen->stamp.pattern_index,
                 .device_time = *whole - start_,
                 .host_time = *whole};
  player_.advance();
  ++delivered_;
  return Arrival::frame;
}

}  // namespace slipstream
