#pragma once

#include <memory>
#include <optional>
#include <string>

#include "slipstream/engine.h"
#include "slipstream/scan.h"

namespace slipstream {

struct PixelMatches;

struct PhaseMatchSettings {
  /// Half width, pixels of the first camera, of the window in which a plane is fitted to the
  /// matches, weighted by the slope of the phase, which gamma flattens in places. 0: no fit.
  int window = 5;
};

/// What two cameras agree on where a single band of many periods leaves the order open: found from
/// the first scan in which most of the light belongs to surfaces that both see.
struct CameraAgreement {
  /// Added to the measured phase, rad: not 0 if the cameras agree nowhere with the phase's origin
  /// as given, and most of the light with this one.
  double phase_shift = 0;
  DepthRange depths{};  ///< of the surfaces, with a margin, mm; as set if both ends are
};

/// Two cameras and one projector, Liu 2010, Section 4.4: a pixel's point is where its ray in the
/// first camera meets a place that the second camera sees under the same phase. Gamma distorts both
/// phases equally and cancels. The projector coordinate only gives the start of the search; for a
/// single band of many periods the second camera's phase also resolves the fringe order.
///
/// Builds its tables once and reuses its memory. For one thread at a time.
class PhaseMatcher {
 public:
  /// `first`, `second`: each camera with the same projector. Phases are matched as measured,
  /// without correction. Throws Error if a scanner or a setting is invalid, the projectors differ,
  /// the cameras are in the same place, or the frames give no phase.
  PhaseMatcher(const Scanner& first, const Scanner& second, const Sequence& sequence,
               const ReconstructSettings& settings = {}, const PhaseMatchSettings& match = {});
  PhaseMatcher(PhaseMatcher&&) noexcept;
  PhaseMatcher& operator=(PhaseMatcher&&) noexcept;
  ~PhaseMatcher();

  /// Result in the first camera's image and frame.
  struct Result {
    Cloud cloud{};
    Maps maps{};               ///< of the first camera
    ValidityCounts cleaned{};  ///< points that cleaning removed, by reason
    /// For a single band of many periods; nullopt if the surfaces do not show it.
    std::optional<CameraAgreement> agreement{};
  };

  /// A point for each pixel of the first camera that has a match; `no_point` for the others: hidden
  /// from the second camera, unlit there, or outside its image. Frames along the other axis, if
  /// both cameras have them, exclude wrong places: there the other phases must agree, too. Throws
  /// Error if frames do not fit.
  [[nodiscard]] Result operator()(const Scan& first, const Scan& second);
  [[nodiscard]] Result operator()(const FrameViews& first, const FrameViews& second);

  /// The same into `result`, whose memory is reused. Frames of a sequence along both axes contain
  /// both. `first_pattern`: of a window with motion frames, see merged_sequence.
  void run(const FrameViews& first, const FrameViews& second, Result& result,
           int first_pattern = 0);

  /// Phase method used for frames of either camera.
  [[nodiscard]] std::string method_for(const FrameViews& frames) const;

 private:
  struct Tables;
  struct Memory;

  void read(const FrameViews& first, const FrameViews& second, int first_pattern);
  void read_across(const FrameViews& first, const FrameViews& second);
  void search_orders();

  /// Projector coordinates that camera 0 or 1 uses.
  [[nodiscard]] const Image<float>& coordinates(int camera) const;
  [[nodiscard]] bool agrees_across(int column, int row, const Eigen::Vector2f& at) const;
  [[nodiscard]] bool is_certain(const PixelMatches& matches, std::size_t k) const;
  void match_rows();

  [[nodiscard]] double remaining_phase_shift() const;
  void improve_phase_shift();

  [[nodiscard]] Validity validity_at(int column, int row, float depth) const;
  void make_points(Cloud& cloud) const;
  void match(Result& result);

  std::unique_ptr<Tables> tables_;
  std::unique_ptr<Memory> memory_;
};

}  // namespace slipstream
