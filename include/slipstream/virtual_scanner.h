#pragma once

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "slipstream/frame_set.h"
#include "slipstream/frame_source.h"
#include "slipstream/image.h"
#include "slipstream/pattern_set.h"
#include "slipstream/scanner.h"
#include "slipstream/scene.h"

namespace slipstream {

/// Sharpness of a device's picture.
struct Sharpness {
  double blur = 0;  ///< standard deviation of its Gaussian at the working distance, pixels
  /// Added in quadrature, pixels, at twice the working distance; proportional to the defocus.
  double defocus = 0;

  /// Pixels, at `distance` times the working distance.
  [[nodiscard]] double at(double distance) const {
    const double more = defocus * (distance - 1);
    return std::sqrt(blur * blur + more * more);
  }

  friend bool operator==(const Sharpness&, const Sharpness&) = default;
};

/// Effects of a real rig beyond the equations; all off by default.
struct Physics {
  bool projector_pixels = false;  ///< light is constant over each pixel, with 256 levels
  Sharpness projector{}, camera{};
  double vignetting = 0;  ///< share of the light lost in each lens's corners
  /// Light falls off with the distance squared; nominal half way to the near end of the working
  /// volume.
  bool fall_off = false;
  double gloss = 0;              ///< added to every body's gloss
  double translucency = 0;       ///< mm by which half of the light spreads within a surface
  int bounces = 0;               ///< rays per pixel for light from other surfaces; one bounce
  double ambient_gradient = 0;   ///< relative rise of ambient light from the centre to the right
  double flicker = 0;            ///< relative change of all light from frame to frame
  bool motion_blur = false;      ///< bodies move during the exposure, half of the frame time
  bool rolling_shutter = false;  ///< the last row is exposed almost a frame after the first
  double lens_residue = 0;       ///< largest error of any lens model, camera pixels

  // The sensor, by the model of EMVA 1288.
  double full_well = 0;           ///< electrons at full scale, for shot noise
  double read_noise = 0;          ///< standard deviation, electrons; requires full_well
  double row_noise = 0;           ///< standard deviation of a row's offset in a frame, grey levels
  double dark_spread = 0;         ///< of the pixels' offsets, constant over frames, grey levels
  double sensitivity_spread = 0;  ///< of the pixels' sensitivities, relative

  // Cameras that make pictures for people, in this order.
  double auto_exposure = 0;  ///< share of the stops from a picture's mean to grey level 64
  Response tone{};           ///< from the sensor's signal to the picture's level, both 0 to 1
  double sharpening = 0;     ///< unsharp mask of 1 pixel: this share of the detail is added
  int jpeg_quality = 0;      ///< 1 to 100, for 8 bits; 0: not compressed

  // Calibration boards.
  double board_bend = 0;     ///< mm by which the middle of a board bulges out
  double board_stretch = 0;  ///< relative stretch of the print along its rows

  friend bool operator==(const Physics&, const Physics&) = default;
};

struct SeenScene;

/// Light and sensor of the virtual scanner. Full scale is grey level 255 for any number of bits.
struct Photometry {
  double ambient = 0;   ///< beta of Liu 2010, Eq. (3.2); may be negative, like a camera's offset
  Response response{};  ///< of the projected intensity / 255, Eq. (4.2); gamma 0.1 to 20
  double noise_variance = 0;    ///< sigma_w^2, Gaussian, grey levels^2
  std::optional<int> bits = 8;  ///< of the camera, 8 to 16; nullopt: not rounded or clipped
  std::uint64_t seed = 1;       ///< of the noise; the same seed gives the same frames
  /// Rays per pixel, 1 to 256, averaged where surface, light or reflectivity vary: an edge is right
  /// to 1 / rays of a pixel. Even pixels use one ray through the centre.
  int rays = 1;
  Physics physics{};
};

/// Frames of a virtual camera, and the ground truth half way through the exposures.
struct VirtualScan {
  FrameSet frames;
  Image<double> depth;  ///< Z of the surface in the camera's frame, mm; NaN without a surface
  /// Projector coordinate y, [0, 1) within half a pixel; NaN in shadow or outside the field.
  Image<double> coordinate;
  Image<double> reflectivity;               ///< alpha with shading and gloss; 0 without a surface
  std::shared_ptr<const SeenScene> seen{};  ///< at the time of the first frame
  Size projector{};
  bool in_colour = false;  ///< three frames are the channels of one picture
  FrameSet white{};        ///< in colour: the channels of a picture under uniform grey
  double truth_time = 0;   ///< of depth, coordinate and reflectivity, in frames: see Motion
};

/// Simulates the frames of `patterns`, the first at `time`, each one frame after the last: I =
/// alpha (I^p + beta) + beta + w, Eq. (3.2), I^p times the pattern's exposure, and 0 in the
/// projector's shadow and outside its field. Without Physics::projector_pixels, patterns are exact,
/// neither sampled by projector pixels nor quantised; binary ones use their pictures. Throws Error
/// if the scanner or the photometry is invalid. Several threads ask `stopped`, if given: once
/// it says true, the function returns soon, with incomplete frames.
VirtualScan take_scan(const Scanner& scanner, const Scene& scene, const PatternSet& patterns,
                      const Photometry& photometry = {}, double time = 0,
                      const std::function<bool()>& stopped = {});

/// Frames of the scene of `scan`, at the same time, with other patterns or light. Reuses the traced
/// rays, with their number, blur and bounces. Throws Error if the photometry is invalid.
FrameSet take_again(const VirtualScan& scan, const PatternSet& patterns,
                    const Photometry& photometry);

/// Throws Error with the first value out of range.
void require_valid(const Photometry& photometry);

/// A colour projector and camera, and painted surfaces.
struct ColourDevices {
  ColourMixture mixture{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};  ///< its dark levels are 0
  double paint = 0;  ///< largest share of a channel's light that paint absorbs, 0 to 1; hues repeat
                     ///< every 40 mm
};

/// A mixture of 20 %, and channels with different gains.
inline constexpr ColourMixture usual_mixture{
    {{1, 0.2, 0.05, 0}, {0.15, 0.9, 0.2, 0}, {0.05, 0.2, 0.75, 0}}};

/// Like take_scan, but shows three patterns at once, takes three frames from each picture, and adds
/// a white picture. Throws Error unless the patterns are a multiple of three, the scene is static
/// and the paint is in range.
VirtualScan take_colour_scan(const Scanner& scanner, const Scene& scene, const PatternSet& patterns,
                             const Photometry& photometry, const ColourDevices& devices);

class ReelPlayer;
class RenderedReel;

/// Whether bodies that move rest first, for a cycle, where the loop of their motion begins.
enum class FirstRest {
  none,
  once,
  until_rendered,  ///< the cycle is repeated until the loop is rendered
};

/// All frames of a camera while the patterns are shown `cycles` times, as a seamless loop: bodies
/// move back and forth through their position at time 0, or rotate continuously if they only turn
/// and the frames last a full turn to within half a cycle. Each frame has its own noise. Throws
/// Error for less than one cycle, without bits of the camera, and as take_scan.
std::vector<Frame> virtual_frames(const Scanner& scanner, const Scene& scene,
                                  const PatternSet& patterns, const Photometry& photometry,
                                  int cycles);

/// Repeats a reel endlessly, and counts its frames as a real camera does. Frames that are not
/// rendered yet come later and do not count as lost.
class VirtualCamera : public FrameSource {
 public:
  /// Frames buffered by a camera with its own pace; beyond these it loses the oldest.
  static constexpr int waiting_frames = 8;

  /// `rate`: Hz; without it, frames arrive as fast as they are requested. Throws Error if the rate
  /// is not positive.
  explicit VirtualCamera(std::shared_ptr<const RenderedReel> reel,
                         std::optional<double> rate = std::nullopt);

  /// Frames of one format, which keep the pattern index of their stamps. Throws Error without
  /// frames, or if their formats differ.
  explicit VirtualCamera(Reel reel, std::optional<double> rate = std::nullopt);

  /// Each frame once.
  explicit VirtualCamera(std::vector<Frame> loop, std::optional<double> rate = std::nullopt);

  ~VirtualCamera() override;

  [[nodiscard]] FrameFormat format() const override;
  [[nodiscard]] bool has_own_pace() const override { return rate_.has_value(); }

  void start() override;
  Arrival next(Frame& frame, std::chrono::milliseconds timeout) override;
  void stop() override {}

  [[nodiscard]] SourceCounters counters() const override {
    return {.delivered = delivered_, .lost = lost_};
  }
  [[nodiscard]] std::string state() const override { return {}; }

 private:
  using Clock = std::chrono::steady_clock;

  /// Waits for frame `sequence_` and returns when it was complete; nullopt if that is after `end`.
  std::optional<Clock::time_point> wait_until(Clock::time_point end);

  std::unique_ptr<ReelPlayer> player_;
  std::optional<double> rate_;
  Clock::time_point start_;
  Clock::time_point pace_start_;  ///< when frame 0 began at the camera's rate, without any waits
  bool is_late_ = false;          ///< the next frame was not rendered when it was asked for
  std::uint64_t sequence_ = 0;
  std::atomic<std::uint64_t> delivered_ = 0, lost_ = 0;
};

}  // namespace slipstream
