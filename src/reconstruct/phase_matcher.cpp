#include "reconstruct/phase_matcher.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "base/numbers.h"
#include "base/parallel_rows.h"
#include "base/statistics.h"
#include "base/throw_if-inl.h"
#include "reconstruct/band_search.h"
#include "reconstruct/camera_agreement.h"
#include "reconstruct/camera_orders.h"
#include "reconstruct/camera_pair.h"
#include "reconstruct/engine_setup.h"
#include "reconstruct/fused/fused_engine.h"
#include "reconstruct/fused/match_rows.h"
#include "reconstruct/fused/pair_rows.h"
#include "slipstream/unwrapping.h"

namespace slipstream {
namespace {

EngineSetup setup_of(const Scanner& scanner, const Sequence& sequence,
                     const ReconstructSettings& settings) {
  // Each axis of a scan along both is read as a sequence of its own.
  Sequence merged = merged_sequence(sequence);
  merged.both_axes = false;
  return {scanner, std::move(merged), settings};
}

}  // namespace

/// Tables and settings of one pair of scanners and one sequence.
struct PhaseMatcher::Tables {
  Tables(const Scanner& one, const Scanner& other, const Sequence& sequence,
         const ReconstructSettings& settings, const PhaseMatchSettings& match_settings)
      : first(setup_of(one, sequence, settings)),
        second(setup_of(other, sequence, settings)),
        match(match_settings),
        depths(depth_range(first)),
        there(one, other, first.sequence.axis),
        bands(band_search(first.sequence.strategy.layout(), other.camera.size.width)),
        period(1 / highest_frequency(first.sequence.strategy)),
        searches(!has_coordinate(first.sequence.strategy)),
        by_bands(order_source(first.sequence.strategy.layout()) == OrderSource::bands),
        given(sequence) {
    if (searches) back.emplace(other, one, first.sequence.axis);
  }

  /// Further columns before and after each row, see MatchedRows.
  [[nodiscard]] int side() const { return match.window + least_row_width; }

  EngineSetup first, second;
  PhaseMatchSettings match;
  DepthRange depths;  ///< of points

  EpipolarTables there;                ///< of the first camera in the second
  std::optional<EpipolarTables> back;  ///< of the second in the first, to search orders
  BandSearch bands;

  double period;   ///< of the finest band, fields
  bool searches;   ///< the second camera gives the order
  bool by_bands;   ///< else the first camera's own order must be the second camera's, too
  Sequence given;  ///< before frames are separated
};

/// What scans share, and memory that they reuse.
struct PhaseMatcher::Memory {
  explicit Memory(const Tables& tables) : clean(tables.first.settings.clean) {}

  using Readers = std::array<PhaseReader, 2>;

  std::vector<Readers> readers;  ///< one for each first pattern of a window
  std::optional<Readers> other_readers;
  std::array<CameraPhases, 2> phases, others;  ///< `others`: of frames along the other axis
  bool has_others = false;
  double full_scale = 255;  ///< of the first camera's frames
  Cleaner clean;

  std::optional<CameraAgreement> agreement;
  int scans_until_search = 0;  ///< of an agreement, if there is none
  DepthRange depths;           ///< of the orders
  std::optional<CameraOrders> orders, back_orders;
  std::array<Image<float>, 2> wrapped;  ///< phase from the beginning of the field
  std::array<Image<float>, 2> coordinates;

  Image<float> inverse_depth, weight, pixel_step;  ///< with further columns, see MatchedRows
};

PhaseMatcher::PhaseMatcher(const Scanner& first, const Scanner& second, const Sequence& sequence,
                           const ReconstructSettings& settings, const PhaseMatchSettings& match) {
  require_pair(first, second, match);
  require_valid(setup_of(first, sequence, settings));

  // Only sinusoids measured pixel by pixel can be matched: no whole stripes, and no frames that
  // are separated by their spectra.
  const Unwrapping& unwrapping = sequence.strategy.layout().unwrapping;
  throw_if(unwrapping->whole_stripes || sequence.strategy.is_spectral(),
           "{}: frames cannot be matched between cameras; use a strategy of sinusoids, or "
           "`one_camera`",
           sequence.strategy.name());

  tables_ = std::make_unique<Tables>(first, second, sequence, settings, match);
  memory_ = std::make_unique<Memory>(*tables_);

  // A motion window may begin with any pattern of the cycle: a reader for each.
  const int starts = sequence.motion > 0 ? cycle_length(sequence) : 1;
  for (int start = 0; start < starts; ++start) {
    const auto reader = [&](EngineSetup setup) {
      setup.sequence = merged_sequence(sequence, start);
      setup.sequence.both_axes = false;
      return PhaseReader(setup);
    };

    memory_->readers.push_back({reader(tables_->first), reader(tables_->second)});
  }
}

PhaseMatcher::PhaseMatcher(PhaseMatcher&&) noexcept = default;
PhaseMatcher& PhaseMatcher::operator=(PhaseMatcher&&) noexcept = default;
PhaseMatcher::~PhaseMatcher() = default;

std::string PhaseMatcher::method_for(const FrameViews& frames) const {
  return memory_->readers.front()[0].method_for(frames);
}

PhaseMatcher::Result PhaseMatcher::operator()(const FrameViews& first, const FrameViews& second) {
  Result result;
  run(first, second, result);
  return result;
}

PhaseMatcher::Result PhaseMatcher::operator()(const Scan& first, const Scan& second) {
  Result result;
  read(first.frames, second.frames, 0);
  if (!first.other_axis.empty() && !second.other_axis.empty())
    read_across(first.other_axis.front().frames, second.other_axis.front().frames);

  match(result);
  return result;
}

void PhaseMatcher::run(const FrameViews& first, const FrameViews& second, Result& result,
                       int first_pattern) {
  if (!tables_->given.both_axes) {
    read(first, second, first_pattern);
  } else {  // first the frames along x, then those along y
    const int along_x = frame_count(tables_->first.sequence), along_y = first.count() - along_x;
    read(first.part(0, along_x), second.part(0, along_x), 0);
    read_across(first.part(along_x, along_y), second.part(along_x, along_y));
  }

  match(result);
}

void PhaseMatcher::read(const FrameViews& first, const FrameViews& second, int first_pattern) {
  require_size(first, tables_->first.scanner, "first");
  require_size(second, tables_->second.scanner, "second");

  auto& [read_first, read_second] = memory_->readers[first_pattern];
  read_first(first, memory_->phases[0]);
  read_second(second, memory_->phases[1]);

  memory_->has_others = false;
  memory_->full_scale = first.full_scale();
}

void PhaseMatcher::read_across(const FrameViews& first, const FrameViews& second) {
  // Made for the first scan that has frames along the other axis.
  if (!memory_->other_readers) {
    const auto turned = [](EngineSetup setup) {
      setup.sequence = along(setup.sequence, across(setup.sequence.axis));
      return PhaseReader(setup);
    };
    memory_->other_readers.emplace(std::array{turned(tables_->first), turned(tables_->second)});
  }

  (*memory_->other_readers)[0](first, memory_->others[0]);
  (*memory_->other_readers)[1](second, memory_->others[1]);
  memory_->has_others = true;
}

/// Coordinates of both cameras from one band of many periods: each camera resolves the other's
/// orders.
void PhaseMatcher::search_orders() {
  Memory& memory = *memory_;
  const CameraPhases &first = memory.phases[0], &second = memory.phases[1];
  const double periods = 1 / tables_->period;

  // Wrapped phases with the shift added, in [0, 2 pi) again.
  const auto wrap = [&](double phase_shift) {
    for (const int i : {0, 1}) {
      const CameraPhases& camera = memory.phases[i];
      prepare(memory.wrapped[i], camera.validity.size());
      std::ranges::transform(camera.maps.wrapped_phase, memory.wrapped[i].begin(),
                             [shift = static_cast<float>(phase_shift)](float phi) {
                               constexpr auto turn = static_cast<float>(two_pi);
                               phi += shift;
                               return phi < 0 ? phi + turn : phi >= turn ? phi - turn : phi;
                             });
    }
  };

  // 1. Without an agreement of the cameras, search for one: at once, then again after 16 scans.
  const bool is_due = memory.scans_until_search == 0;
  if (!is_due) --memory.scans_until_search;
  if (!memory.agreement && is_due) {
    wrap(0);

    Image<float> lit = memory.wrapped[0];
    std::ranges::transform(lit, first.validity, lit.begin(), [](float phi, Validity pixel) {
      return pixel == Validity::valid ? phi : std::numeric_limits<float>::quiet_NaN();
    });

    const DepthRange& set = tables_->depths;
    memory.agreement = camera_agreement(tables_->there, periods, set, lit, first, second);
    if (memory.agreement && tables_->first.settings.nearest && tables_->first.settings.farthest)
      memory.agreement->depths = set;

    // The bounds of the orders depend on the depths.
    const DepthRange& depths = memory.agreement ? memory.agreement->depths : set;
    constexpr int scans_between_searches = 16;
    if (!memory.agreement) memory.scans_until_search = scans_between_searches;
    if (!memory.orders || depths != memory.depths) {
      const int length = projector_length(tables_->first);
      memory.orders.emplace(tables_->there, periods, depths, false, length);
      memory.back_orders.emplace(*tables_->back, periods, depths, true, length);
      memory.depths = depths;
    }
  }

  // 2. Each camera's coordinates, confirmed by the other.
  wrap(memory.agreement ? memory.agreement->phase_shift : 0);
  memory.coordinates[0] = (*memory.orders)(first, memory.wrapped[0], second);
  memory.coordinates[1] = (*memory.back_orders)(second, memory.wrapped[1], first);
}

const Image<float>& PhaseMatcher::coordinates(int camera) const {
  return tables_->searches ? memory_->coordinates[camera] : memory_->phases[camera].maps.coordinate;
}

/// Whether the phases along the other axis agree.
bool PhaseMatcher::agrees_across(int column, int row, const Eigen::Vector2f& at) const {
  constexpr float most = 1;  // rad; a calibration may be off by a pixel
  const auto& [first, second] = memory_->others;
  if (first.validity(column, row) != Validity::valid) return false;

  const Phasor seen = near_phasor(second, second.bands.back(), at);
  const Phasor apart = seen * std::conj(first.bands.back()(column, row));
  return seen != Phasor(0) && std::abs(std::arg(apart)) < most;
}

/// Whether no test contradicts a match.
bool PhaseMatcher::is_certain(const PixelMatches& matches, std::size_t k) const {
  const Tables& tables = *tables_;
  const float w = matches.w[k], y = matches.coordinates[k], slope = matches.slope[k];
  if (!(w > 0) || !std::isfinite(slope) || slope == 0) return false;

  const int width = tables.there.size().width;
  const int column = matches.pixels[k] % width, row = matches.pixels[k] / width;
  const Eigen::Vector2f at(matches.x[k], matches.y[k]);

  // 1. Where the order is uncertain, the match must be nearer to the guess than a quarter of a
  //    period, and the second camera must find the same point: where the right place is hidden from
  //    it, a wrong one may match by chance, but not both ways.
  if (tables.searches || !tables.by_bands) {
    if (!(matches.quarters[k] < 1)) return false;

    // The last step of a search may lead out of the picture.
    const Image<float>& others = coordinates(1);
    const float right = at.x() + 0.5F, down = at.y() + 0.5F;
    if (!(right >= 0 && down >= 0 && right < static_cast<float>(others.width()) &&
          down < static_cast<float>(others.height()))) {
      return false;
    }

    const float seen = others(static_cast<int>(right), static_cast<int>(down));
    if (!(std::abs(seen - y) < static_cast<float>(tables.period) / 2)) return false;
  }

  // 2. With frames along the other axis, their phases must agree too.
  return !memory_->has_others || agrees_across(column, row, at);
}

/// Matches all pixels of the first camera, leaving out matches that are not certain.
void PhaseMatcher::match_rows() {
  const Tables& tables = *tables_;
  Memory& memory = *memory_;
  const CameraPhases& first = memory.phases[0];
  const Size size = first.validity.size();

  for_each_row(size.height, [&](int row) {
    // 1. The row's valid pixels with their projector coordinates.
    thread_local PixelMatches matches;
    matches.pixels.clear();
    matches.coordinates.clear();
    for (int column = 0; column < size.width; ++column) {
      if (first.validity(column, row) != Validity::valid) continue;
      matches.pixels.push_back(row * size.width + column);
      matches.coordinates.push_back(coordinates(0)(column, row));
    }
    const std::size_t count = matches.pixels.size();
    match_pixels(tables.there.lines(), first, memory.phases[1], tables.bands, matches);

    // 2. Rows of the maps, past their further columns.
    const int side = tables.side();
    float* const depths = memory.inverse_depth.row(row) + side;
    float* const weights = memory.weight.row(row) + side;
    float* const steps = memory.pixel_step.row(row) + side;

    std::fill_n(depths, size.width, std::numeric_limits<float>::quiet_NaN());
    for (std::size_t k = 0; k < count; ++k) {
      if (!is_certain(matches, k)) continue;

      // Phase noise is proportional to 1 / B, and noise of w is phase noise divided by the slope.
      const int pixel = matches.pixels[k], column = pixel - row * size.width;
      depths[column] = matches.w[k];
      weights[column] =
          matches.slope[k] * matches.slope[k] * std::norm(first.bands.back().begin()[pixel]);
      steps[column] = 1 / matches.speed[k];
    }
  });
}

/// How far the phases are from those at which the projector lit the matched points: median, rad.
double PhaseMatcher::remaining_phase_shift() const {
  const Image<float>& coordinate = memory_->coordinates[0];
  const int side = tables_->side();
  std::vector<double> shifts;

  // Every second row and column: a sample is enough for a median.
  for (int row = 0; row < coordinate.height(); row += 2) {
    for (int column = 0; column < coordinate.width(); column += 2) {
      const float w = memory_->inverse_depth(column + side, row);
      if (!std::isfinite(w)) continue;
      const double lit = tables_->there.coordinate_at(column, row, w);
      shifts.push_back(two_pi / tables_->period * (lit - coordinate(column, row)));
    }
  }

  return shifts.empty() ? 0 : median(std::move(shifts));
}

/// Shifts the phase as long as the matched points say so, and more pixels match.
void PhaseMatcher::improve_phase_shift() {
  // A calibration alone may be off by this; a shift once found is refined to 0.01 rad.
  constexpr double of_calibration = 0.3;  // rad
  constexpr int most_steps = 4;

  const auto matched = [&] {
    return std::ranges::count_if(memory_->inverse_depth, [](float w) { return std::isfinite(w); });
  };

  double& shift = memory_->agreement->phase_shift;
  for (int step = 0; step < most_steps; ++step) {
    const double more = remaining_phase_shift(), before = shift;
    const bool is_small = shift == 0 ? std::abs(more) < of_calibration : std::abs(more) < 0.01;
    if (is_small) return;

    // Shift, and match again.
    const auto points = matched();
    shift = std::remainder(shift + more, two_pi);
    search_orders();
    match_rows();

    // Unless this gives 2 % more matches, keep the origin as given.
    if (before == 0 && matched() < points + points / 50) {
      shift = before;
      search_orders();
      match_rows();
      return;
    }
  }
}

/// Whether a pixel of this depth becomes a point, or why not.
Validity PhaseMatcher::validity_at(int column, int row, float depth) const {
  const Validity decoded = memory_->phases[0].validity(column, row);
  if (decoded != Validity::valid) return decoded;

  if (std::isnan(depth)) {
    const bool is_doubtful = tables_->searches && std::isnan(memory_->coordinates[0](column, row));
    return is_doubtful ? Validity::doubtful_order : Validity::no_point;
  }

  const auto& [nearest, farthest] = tables_->depths;
  return depth < nearest || depth > farthest ? Validity::out_of_range : Validity::valid;
}

/// Points at the depths of the matches, smoothed by planes.
void PhaseMatcher::make_points(Cloud& cloud) const {
  const Tables& tables = *tables_;
  const Memory& memory = *memory_;
  const CameraPhases& first = memory.phases[0];
  const Size size = first.validity.size();

  const MatchedRows matches{tables.match.window, tables.side(), memory.inverse_depth, memory.weight,
                            memory.pixel_step};
  const bool smooths = tables.match.window > 0 && size.width >= least_row_width;
  const auto grey_level = static_cast<float>(memory.full_scale / 255);

  if (cloud.size() != size) cloud = Cloud(size);
  cloud.validity = first.validity;

  for_each_row(size.height, [&](int row) {
    const float* const matched = matches.inverse_depth.row(row) + matches.side;
    float* const smooth = cloud.z.row(row);  // 1 / Z until the points are made
    std::copy_n(matched, size.width, smooth);
    if (smooths) plane_row(matches, row, smooth);

    for (int column = 0; column < size.width; ++column) {
      cloud.intensity(column, row) = first.maps.mean(column, row) / grey_level;

      const float Z = 1 / smooth[column];
      const Validity validity = validity_at(column, row, Z);
      if (validity != Validity::valid) {
        cloud.reject(column, row, validity);
        continue;
      }

      const Eigen::Vector2f direction = tables.there.direction(column, row);
      cloud.x(column, row) = Z * direction.x();
      cloud.y(column, row) = Z * direction.y();
      cloud.z(column, row) = Z;
    }
  });
}

void PhaseMatcher::match(Result& result) {
  const Tables& tables = *tables_;
  Memory& memory = *memory_;
  const CameraPhases& first = memory.phases[0];
  const bool had_agreement = memory.agreement.has_value();

  if (tables.searches) search_orders();

  // 1. Matches of all pixels.
  const Size size = first.validity.size();
  const Size padded{size.width + 2 * tables.side(), size.height};
  if (memory.inverse_depth.size() != padded) {
    memory.inverse_depth = Image<float>(padded, std::numeric_limits<float>::quiet_NaN());
    memory.weight = memory.pixel_step = Image<float>(padded);
  }

  match_rows();
  if (memory.agreement && !had_agreement) improve_phase_shift();

  // 2. Points.
  Cloud& cloud = result.cloud;
  make_points(cloud);
  result.cleaned = memory.clean(cloud);

  // 3. The maps, and the agreement of the cameras, which is kept unless the scene has changed.
  result.maps = first.maps;
  if (tables.searches) result.maps.coordinate = memory.coordinates[0];
  result.agreement = memory.agreement;

  const ValidityCounts counts = count_by_validity(cloud);
  const auto count = [&](Validity kind) { return counts[static_cast<std::size_t>(kind)]; };
  const std::size_t lit = cloud.z.pixel_count() - count(Validity::too_dark);
  if (2 * count(Validity::valid) < lit) memory.agreement.reset();
}

}  // namespace slipstream
