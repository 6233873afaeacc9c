#pragma once

#include <array>
#include <memory>

#include "slipstream/base/image.h"
#include "slipstream/cloud/clean_settings.h"
#include "slipstream/cloud/cloud.h"

namespace slipstream {

/// What the frames' noise does to depth: at a point P in the camera's frame, under a modulation of
/// B grey levels of the frames, sigma_Z = noise / B (projector_depth (P, 1))^2 Z / |parallax P|.
struct DepthNoise {
  float noise = 0;  ///< sigma of the projector coordinate times B
  std::array<float, 4> projector_depth{};
  std::array<float, 3> parallax{};
};

/// Leaves out points of organised clouds, see CleanSettings, each with its reason as Validity: low
/// trust first, then mixed pixels and outliers together, then small components, then what is
/// outside the region. Where the modulation is known, so are mixed pixels at edges between surfaces
/// far apart by its dip. Gaps are filled and points smoothed after that. Depth edges and outliers
/// are told by limits that follow the cloud's own noise, measured from it, and the distance between
/// pixels.
///
/// The result does not depend on the number of threads. Memory is kept from cloud to cloud, so that
/// from the second one of a size on nothing is allocated. One thread uses it at a time.
class Cleaner {
 public:
  /// Throws Error as require_valid.
  explicit Cleaner(const CleanSettings& settings = {});
  Cleaner(const Cleaner& other);  ///< with memory of its own
  Cleaner(Cleaner&&) noexcept;
  Cleaner& operator=(Cleaner other) noexcept;
  ~Cleaner();

  /// How many points each reason took, and at `valid` how many gaps got one. The cloud's Z is NaN
  /// where it has no point, and positive elsewhere.
  ValidityCounts operator()(Cloud& cloud);
  /// With trust by noise; `modulation`: of the cloud's pixels, grey levels of the frames.
  ValidityCounts operator()(Cloud& cloud, const Image<float>& modulation, const DepthNoise& noise);

  [[nodiscard]] const CleanSettings& settings() const { return settings_; }
  /// Whether trust by noise is asked for.
  [[nodiscard]] bool wants_modulation() const;

 private:
  struct Memory;
  struct Pass;

  ValidityCounts clean(Cloud& cloud, const Image<float>* modulation, const DepthNoise& noise);

  CleanSettings settings_;
  std::unique_ptr<Memory> memory_;
};

}  // namespace slipstream
