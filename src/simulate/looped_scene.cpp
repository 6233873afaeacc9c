#include "simulate/looped_scene.h"

#include <algorithm>
#include <optional>
#include <thread>
#include <type_traits>

#include "base/throw_if-inl.h"
#include "simulate/rendered_reel.h"
#include "slipstream/virtual_world.h"

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

}  // namespace slipstream
