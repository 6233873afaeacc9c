#include "frames/scan_camera.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <optional>
#include <type_traits>
#include <variant>
#include <vector>

#include "base/throw_if-inl.h"

namespace slipstream {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

/// Even a slow camera delivers a frame within this time.
constexpr milliseconds longest_wait{5000};

void set_exposure(FrameSource& source, double seconds) {
  CameraControls* const controls = source.controls();
  throw_if(controls == nullptr,
           "this source cannot change the exposure while it runs; omit `exposures`");

  controls->set_control(CameraControl::exposure, seconds * 1e3);
}

}  // namespace

bool is_still(const FrameViews& before, const FrameViews& after) {
  if (before.count() != after.count() || before.size() != after.size() ||
      before.bits() != after.bits()) {
    return false;
  }

  const double noise = 16.0 / 255 * before.full_scale();
  constexpr std::size_t one_of = 200;

  return before.visit([&]<class Pixel>(const Frames<Pixel>& a) {
    return after.visit([&]<class Other>(const Frames<Other>& b) {
      std::size_t pixels = 0, changed = 0;

      for (std::size_t n = 0; n < a.size(); ++n) {
        for_each_pixel_in_order(a[n].size(), [&](int column, int row) {
          const auto level = static_cast<double>(a[n](column, row));
          changed += std::abs(level - static_cast<double>(b[n](column, row))) > noise ? 1 : 0;
          ++pixels;
        });
      }

      return std::is_same_v<Pixel, Other> && changed * one_of < pixels;
    });
  });
}

FrameSet frame_set_of(std::vector<Frame> frames) {
  return std::visit(
      [&]<class Pixel>(const Image<Pixel>&) {
        std::vector<Image<Pixel>> images;
        for (Frame& frame : frames) {
          images.push_back(std::move(std::get<Image<Pixel>>(frame.pixels)));
        }
        return FrameSet(std::move(images), frames.front().bits);
      },
      frames.at(0).pixels);
}

ShownScans::ShownScans(PatternSink& sink, FrameSource& source,
                       std::vector<std::vector<Image<std::uint8_t>>> scans, StepSettings settings)
    : sink_(sink), source_(source), settings_(settings), frame_(source.format()) {
  std::vector<Image<std::uint8_t>> patterns;
  std::uint8_t brightest = 0;

  for (std::vector<Image<std::uint8_t>>& scan : scans) {
    counts_.push_back(scan.size());
    for (Image<std::uint8_t>& pattern : scan) {
      brightest = std::max(brightest, *std::max_element(pattern.begin(), pattern.end()));
      patterns.push_back(std::move(pattern));
    }
  }

  throw_if(patterns.empty(), "no patterns to show; at least one is required");

  // The last pattern is uniform light.
  light_ = patterns.size();
  patterns.emplace_back(patterns.front().size(), brightest);
  sink_.load(std::move(patterns));

  if (!settings_.exposures.empty()) set_exposure(source_, settings_.exposures.front());
}

bool ShownScans::next(milliseconds timeout) {
  const auto end = Clock::now() + timeout;
  do {
    const Arrival arrival = source_.next(frame_, std::min(timeout, milliseconds(50)));
    if (arrival == Arrival::ended) throw WorldError("the source of frames has ended");
    if (arrival != Arrival::frame) continue;
    // Frames buffered in the camera are older: skip them.
    while (source_.has_own_pace() && !settings_.triggered) {
      if (source_.next(frame_, milliseconds(0)) != Arrival::frame) break;
    }
    return true;
  } while (Clock::now() < end);
  return false;
}

bool ShownScans::show(std::size_t pattern, milliseconds timeout) {
  sink_.show(pattern);

  lit_ = pattern == light_;
  if (!source_.has_own_pace()) return next(timeout);

  // Drop frames that may still contain the old pattern.
  const auto settled = Clock::now() + settings_.settling;
  while (Clock::now() < settled) source_.next(frame_, milliseconds(5));
  if (!settings_.triggered) return next(timeout) && next(timeout);  // the first is older

  source_.trigger();
  return next(timeout);
}

std::optional<Glimpse> ShownScans::look(milliseconds timeout) {
  if (lit_ && settings_.triggered) source_.trigger();
  if (!(lit_ ? next(timeout) : show(light_, timeout))) return std::nullopt;

  FrameSet seen = frame_set_of({frame_});
  const bool still = is_still(glimpse_, seen);
  glimpse_ = std::move(seen);

  return Glimpse{{glimpse_}, still};
}

std::optional<std::vector<FrameSet>> ShownScans::take() {
  std::vector<FrameSet> scans;
  std::size_t pattern = 0;

  for (const std::size_t count : counts_) {
    std::vector<Frame> frames;
    const std::size_t group = count / std::max<std::size_t>(1, settings_.exposures.size());

    for (std::size_t n = 0; n < count; ++n, ++pattern) {
      if (!settings_.exposures.empty() && n % group == 0) {
        set_exposure(source_, settings_.exposures[n / group]);
      }

      if (!show(pattern, longest_wait)) return std::nullopt;
      frames.push_back(frame_);
    }

    scans.push_back(frame_set_of(std::move(frames)));
  }

  // Back to the first exposure, to see whether anything moved meanwhile.
  if (settings_.exposures.size() > 1) set_exposure(source_, settings_.exposures.front());
  if (!show(light_, longest_wait) || !is_still(glimpse_, frame_set_of({frame_})))
    return std::nullopt;

  return scans;
}

}  // namespace slipstream
