#include "slipstream/virtual_scanner.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <thread>
#include <type_traits>
#include <variant>
#include <vector>

#include "base/parallel_rows.h"
#include "base/throw_if-inl.h"
#include "simulate/camera_picture.h"
#include "simulate/looped_scene.h"
#include "simulate/projected_light.h"
#include "simulate/rendered_reel.h"
#include "simulate/seen_scene.h"

namespace slipstream {
namespace {

/// The same light on a sensor that neither rounds nor adds noise, with equal pixels, and without a
/// camera's processing.
Photometry before_sensor(Photometry photometry) {
  photometry.bits.reset();
  photometry.noise_variance = 0;

  Physics& physics = photometry.physics;
  physics.full_well = physics.read_noise = physics.row_noise = 0;
  physics.dark_spread = physics.sensitivity_spread = 0;
  physics.auto_exposure = physics.sharpening = 0;
  physics.tone = Response{};
  physics.jpeg_quality = 0;

  return photometry;
}

constexpr std::size_t channels = 3;

/// Share of channel c's light that the paint reflects at a point of the surface.
double kept(double paint, const Eigen::Vector3d& point, std::size_t c) {
  constexpr double around = 40;  // mm
  const double hue = (point.x() + point.y()) / around - static_cast<double>(c) / channels;
  return 1 - paint * (0.5 + 0.5 * std::cos(2 * std::numbers::pi * hue));
}

/// The channels of one picture before the sensor, from the light of each projector colour alone.
std::vector<Image<double>> mixed(const std::vector<ImageView<const double>>& lights,
                                 const VirtualScan& seen, const Lens& camera,
                                 const ColourDevices& devices) {
  const Size size = lights.front().size();
  std::vector<Image<double>> picture(channels, Image<double>(size));
  for_each_pixel(size, [&](int column, int row) {
    const double depth = seen.depth(column, row);
    const Eigen::Vector3d point = std::isnan(depth)
                                      ? Eigen::Vector3d::Zero()
                                      : Eigen::Vector3d(depth * ray_through(camera, {column, row}));

    for (std::size_t c = 0; c < channels; ++c) {
      double sum = 0;
      for (std::size_t p = 0; p < channels; ++p) {
        sum += devices.mixture[c][p] * lights[p](column, row);
      }
      picture[c](column, row) = kept(devices.paint, point, c) * sum;
    }
  });

  return picture;
}

constexpr double exposed_for = 0.5;  // of a frame, with motion blur

/// The scene during the exposure of a frame: one moment, or several with motion blur.
std::vector<SeenScene> looks(const Scanner& scanner, const Scene& scene,
                             const Photometry& photometry, double time,
                             const std::function<bool()>& stopped) {
  const bool blurred = photometry.physics.motion_blur && is_moving(scene);
  const int times = blurred ? 4 : 1;

  std::vector<SeenScene> seen;
  for (int i = 0; i < times; ++i) {
    const double later = blurred ? exposed_for * (i + 0.5) / times : 0;
    seen.push_back(look(scanner, scene, photometry, time + later, stopped));
  }

  return seen;
}

}  // namespace

void require_valid(const Photometry& photometry) {
  const int bits = photometry.bits.value_or(8);
  require_in_range(std::abs(photometry.ambient) <= 255, "ambient light", photometry.ambient,
                   "-255 to 255");

  const auto* const law = std::get_if<PowerLaw>(&photometry.response);
  const double gamma = law != nullptr ? law->gamma : 1;
  require_in_range(gamma >= 0.1 && gamma <= 20, "gamma", gamma, "0.1 to 20");

  require_in_range(photometry.noise_variance >= 0 && photometry.noise_variance <= 255.0 * 255,
                   "noise variance", photometry.noise_variance, "0 to 255^2");

  require_in_range(bits >= 8 && bits <= 16, "bits", bits, "8 to 16");

  require_in_range(photometry.rays >= 1 && photometry.rays <= 256, "rays", photometry.rays,
                   "1 to 256");

  const int quality = photometry.physics.jpeg_quality;
  require_in_range(quality >= 0 && quality <= 100, "JPEG quality", quality, "0 to 100");
  throw_if(quality > 0 && photometry.bits != 8,
           "JPEG pictures have 8 bits; set `bits` to 8, or simulate no JPEG");
}

VirtualScan take_scan(const Scanner& scanner, const Scene& scene, const PatternSet& patterns,
                      const Photometry& photometry, double time,
                      const std::function<bool()>& stopped) {
  require_valid(scanner);
  require_valid(photometry);

  const Size projector = scanner.projector.size;
  std::vector<SeenScene> seen = looks(scanner, scene, photometry, time, stopped);
  const auto first = std::make_shared<const SeenScene>(seen.front());

  // 1. The frames. With motion blur each is the mean of several moments.
  std::vector<Image<double>> exposures;
  for (int n = 0; n < patterns.count; ++n) {
    if (n > 0 && is_moving(scene)) seen = looks(scanner, scene, photometry, time + n, stopped);

    Image<double> frame(scanner.camera.size);
    for (const SeenScene& now : seen) {
      const auto light = projected_light(patterns, n, projector, photometry, now);
      const Image<double> exposure = exposed(now, photometry, n, patterns.exposure(n), light);
      const double share = 1.0 / static_cast<double>(seen.size());
      std::ranges::transform(frame, exposure, frame.begin(),
                             [=](double sum, double more) { return sum + share * more; });
    }

    exposures.push_back(std::move(frame));
  }

  // 2. The truth half way through the exposures.
  const double exposure = photometry.physics.motion_blur ? exposed_for : 0;
  const double middle = time + 0.5 * (patterns.count - 1 + exposure);
  const SeenScene truth = middle > time && is_moving(scene)
                              ? look(scanner, scene, photometry, middle, stopped)
                              : *first;

  Image<double> coordinate = patterns.axis == Axis::x ? truth.lit_column : truth.lit_row;
  for (double& position : coordinate) position /= length_along(patterns.axis, projector);

  return {camera_pictures(std::move(exposures), 0, photometry),
          truth.depth,
          std::move(coordinate),
          truth.reflectivity,
          first,
          projector,
          false,
          {},
          middle};
}

FrameSet take_again(const VirtualScan& scan, const PatternSet& patterns,
                    const Photometry& photometry) {
  require_valid(photometry);

  std::vector<Image<double>> exposures;
  for (int n = 0; n < patterns.count; ++n) {
    exposures.push_back(
        exposed(*scan.seen, photometry, n, patterns.exposure(n),
                projected_light(patterns, n, scan.projector, photometry, *scan.seen)));
  }

  return camera_pictures(std::move(exposures), 0, photometry);
}

VirtualScan take_colour_scan(const Scanner& scanner, const Scene& scene, const PatternSet& patterns,
                             const Photometry& photometry, const ColourDevices& devices) {
  throw_if(patterns.count % static_cast<int>(channels) != 0,
           "{} patterns in colour; expected a multiple of 3", patterns.count);
  if (is_moving(scene)) throw Error("a scene in colour must be static; remove its motion");
  require_in_range(devices.paint >= 0 && devices.paint <= 1, "paint", devices.paint, "0 to 1");

  // 1. The light of each projector colour alone. The sensor comes after the mixture.
  const Photometry light = before_sensor(photometry);
  VirtualScan scan = take_scan(scanner, scene, patterns, light);

  // 2. The camera's channels of each picture: three patterns mixed, with the sensor's noise.
  const auto seen_in_colour = [&](const FrameSet& lights, int first_noise) {
    std::vector<Image<double>> exposures;
    lights.visit([&]<class Pixel>(const Frames<Pixel>& frames) {
      if constexpr (std::is_same_v<Pixel, double>) {
        for (std::size_t n = 0; n < frames.size(); n += channels) {
          std::vector<Image<double>> picture =
              mixed({frames[n], frames[n + 1], frames[n + 2]}, scan, scanner.camera, devices);
          std::move(picture.begin(), picture.end(), std::back_inserter(exposures));
        }
      }
    });

    return camera_pictures(std::move(exposures), first_noise, photometry, channels);
  };

  // The white picture has noise of its own.
  scan.white =
      seen_in_colour(take_again(scan, white_pattern(patterns.light), light), patterns.count);
  scan.frames = seen_in_colour(scan.frames, 0);
  scan.in_colour = true;

  return scan;
}

std::vector<Frame> virtual_frames(const Scanner& scanner, const Scene& scene,
                                  const PatternSet& patterns, const Photometry& photometry,
                                  int cycles) {
  return rendered(looped_scene(scanner, scene, patterns, photometry, cycles)).frames;
}

VirtualCamera::VirtualCamera(std::shared_ptr<const RenderedReel> reel, std::optional<double> rate)
    : player_(std::make_unique<ReelPlayer>(std::move(reel))), rate_(rate) {
  if (rate_ && !(*rate_ > 0 && std::isfinite(*rate_))) {
    throw Error(fmt::format("frame rate {} Hz is out of range; expected above 0", *rate_));
  }
}

VirtualCamera::VirtualCamera(Reel reel, std::optional<double> rate)
    : VirtualCamera(std::make_shared<RenderedReel>(std::move(reel)), rate) {}

VirtualCamera::VirtualCamera(std::vector<Frame> loop, std::optional<double> rate)
    : VirtualCamera(reel_of(std::move(loop)), rate) {}

VirtualCamera::~VirtualCamera() = default;

FrameFormat VirtualCamera::format() const {
  return player_->reel().format();
}

void VirtualCamera::start() {
  start_ = pace_start_ = Clock::now();
  sequence_ = 0;
  is_late_ = false;
  player_->restart();
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
    player_->advance(static_cast<std::size_t>(behind));
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
  is_late_ |= player_->frame() == nullptr;
  if (is_late_) {
    if (!player_->wait_for_frame(end)) return Arrival::nothing;
    if (rate_) {
      const std::chrono::duration<double> before(static_cast<double>(sequence_) / *rate_);
      pace_start_ = Clock::now() - std::chrono::duration_cast<Clock::duration>(before);
    }
    is_late_ = false;
  }

  // 2. The frame that is due: after losses not the one above.
  const auto whole = wait_until(end);
  if (!whole) return Arrival::nothing;
  const Frame* const seen = player_->frame();
  if (seen == nullptr) return Arrival::nothing;

  frame = *seen;
  frame.stamp = {.sequence = sequence_++,
                 .pattern_index = seen->stamp.pattern_index,
                 .device_time = *whole - start_,
                 .host_time = *whole};
  player_->advance();
  ++delivered_;
  return Arrival::frame;
}

}  // namespace slipstream
