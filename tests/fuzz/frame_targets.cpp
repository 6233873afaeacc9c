// Frames of any content: their alignment as they come, and both engines on them.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <type_traits>

#include "decode/frame_adapter.h"
#include "decode/neighbours.h"
#include "frames/pattern_windows.h"
#include "slipstream/engine.h"
#include "slipstream/frame_source.h"
#include "slipstream/named_scenes.h"
#include "tests/every_strategy.h"
#include "tests/fuzz/target.h"

namespace slipstream {
namespace {

/// Strategies that live scans are made with, by a number from the input.
Strategy strategy_of(InputNumbers& numbers, const std::vector<Strategy>& all) {
  return all[static_cast<std::size_t>(numbers.below(static_cast<int>(all.size())))];
}

/// Frames in any order, again, late, told wrongly: every window is whole, in pattern order and of
/// frames of one cycle's length.
void align_frames(std::span<const std::uint8_t> input) {
  static const std::vector<Strategy> all = every_phase_strategy();
  InputNumbers numbers(input);
  const Strategy strategy = strategy_of(numbers, all);
  const auto indexing = static_cast<PatternIndexing>(numbers.below(3));
  const FrameFormat format{{8, 4}, 8};
  const auto count = static_cast<std::uint64_t>(frame_count(strategy));
  PatternWindows windows(pattern_cycle({.strategy = strategy}), indexing, format.size);
  Pool<Frame> pool(6 * (count + 1), [&] { return Frame(format); });
  std::vector<Pooled<Frame>> window;
  std::uint64_t sequence = 0;
  for (int frames = 0; frames < 100 && !numbers.rest().empty(); ++frames) {
    Pooled<Frame> frame = pool.take();
    if (!frame) throw std::logic_error("frames are kept for ever");
    const auto how = numbers.next<std::uint8_t>();
    sequence = how < 200   ? sequence + 1
               : how < 250 ? sequence + how - 225
                           : numbers.next<std::uint64_t>();
    const auto level = numbers.next<std::uint8_t>(), slope = numbers.next<std::uint8_t>();
    auto& image = std::get<Image<std::uint8_t>>(frame.fill().pixels);
    std::uint8_t value = level;
    for (std::uint8_t& pixel : image) pixel = value = static_cast<std::uint8_t>(value + slope);
    frame.fill().stamp = {.sequence = sequence};
    if (how % 2 == 0) frame.fill().stamp.pattern_index = static_cast<int>(level) - 4;
    if (how == 255) windows.restart();
    (void)windows.put(frame);
    while (windows.next(window)) {
      if (window.size() != count) throw std::logic_error("a window that is not whole");
    }
    window.clear();
  }
}

/// A scanner of a few pixels with lenses bent and turned at will.
Scanner scanner_of(InputNumbers& numbers) {
  Scanner scanner = example_scanner({20, 3});
  for (Lens* lens : {&scanner.camera, &scanner.projector}) {
    for (const auto [row, column] : {std::pair{0, 0}, {0, 2}, {1, 1}, {1, 2}}) {
      lens->intrinsic(row, column) *= numbers.between(0.3, 3);
    }
    for (int i = 0; i < 5; ++i) {
      lens->distortion.coefficients[static_cast<std::size_t>(i)] = numbers.between(-0.3, 0.3);
    }
  }
  const Eigen::Vector3d axis(numbers.between(-1, 1), numbers.between(-1, 1), 1);
  scanner.rotation = Eigen::AngleAxisd(numbers.between(-0.5, 0.5), axis.normalized()).matrix();
  for (int i = 0; i < 3; ++i) scanner.translation[i] *= numbers.between(-3, 3);
  scanner.translation[0] += numbers.between(-200, 200);
  return scanner;
}

/// Past the field the lens polynomial of the fused pass says nothing, so that it does not tell what
/// lies there from what lies nowhere.
bool is_off_field(Validity validity) {
  return validity == Validity::no_point || validity == Validity::outside_field;
}

EngineSetup setup_from(InputNumbers& numbers) {
  static const std::vector<Strategy> all = every_phase_strategy();
  EngineSetup setup{.scanner = scanner_of(numbers),
                    .sequence = {.strategy = strategy_of(numbers, all)}};
  setup.settings.clean = CleanSettings::none();
  // Tables of phases take long to build; tests of phases compare them with the equation.
  setup.settings.phase_method = PhaseMethod::equation;
  setup.scanner.photometry.ambient = numbers.between(-20, 60);
  setup.sequence.axis = numbers.below(2) == 0 ? Axis::x : Axis::y;
  return setup;
}

/// The pixel that a byte stands for: of all grey levels, and beyond them if unquantised.
template <class Pixel>
Pixel pixel_of(std::uint8_t byte) {
  if constexpr (std::is_same_v<Pixel, double>) {
    using Limits = std::numeric_limits<double>;
    constexpr std::array special{Limits::quiet_NaN(), Limits::infinity(), -Limits::infinity(),
                                 Limits::max(),       Limits::lowest(),   Limits::denorm_min()};
    const std::size_t place = 255U - byte;
    return place < special.size() ? special[place] : 1.1 * byte - 20;
  } else {
    return static_cast<Pixel>(std::numeric_limits<Pixel>::max() / 255 * byte);
  }
}

/// The frames of a scan, of the input's bytes over and over.
template <class Pixel>
std::vector<Image<Pixel>> frames_from(std::span<const std::uint8_t> bytes,
                                      const EngineSetup& setup) {
  std::vector<Image<Pixel>> frames;
  std::size_t next = 0;
  for (int n = 0; n < frame_count(setup.sequence); ++n) {
    for (Pixel& pixel : frames.emplace_back(setup.scanner.camera.size)) {
      pixel = bytes.empty() ? Pixel{} : pixel_of<Pixel>(bytes[next++ % bytes.size()]);
    }
  }
  return frames;
}

void require_finite_where_valid(const Cloud& cloud) {
  for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
    if (std::isfinite(cloud.z.begin()[i]) != (cloud.validity.begin()[i] == Validity::valid)) {
      throw std::logic_error("a valid point that is not finite, or the other way round");
    }
  }
}

/// Any pixels in any scanner: a point is finite where it is valid, and the fused pass and the
/// reference engine agree on nearly all of them. Where a limit or a tie is met to rounding they may
/// not.
void compare_engines(std::span<const std::uint8_t> input) {
  InputNumbers numbers(input);
  EngineSetup setup = setup_from(numbers);
  const FrameSet frames = frames_from<std::uint8_t>(numbers.rest(), setup);
  Cloud fused, reference;
  Engine(setup).cloud(frames, fused);
  setup.settings.engine = EngineKind::reference;
  Engine(setup).cloud(frames, reference);
  require_finite_where_valid(fused);

  std::size_t other = 0;
  for (std::size_t i = 0; i < fused.z.pixel_count(); ++i) {
    const float a = fused.z.begin()[i], b = reference.z.begin()[i];
    const Validity by_fused = fused.validity.begin()[i],
                   by_reference = reference.validity.begin()[i];
    const bool same = by_fused == by_reference
                          ? !std::isfinite(a) || std::abs(a - b) <= 1e-2F * std::abs(b)
                          : is_off_field(by_fused) && is_off_field(by_reference);
    other += same ? 0 : 1;
  }
  if (other > fused.z.pixel_count() / 8) {
    throw std::logic_error(std::to_string(other) + " pixels of other points by the engines");
  }
}

/// Pixels of 16 bits and unquantised ones, not all of which are finite.
void make_clouds(std::span<const std::uint8_t> input) {
  InputNumbers numbers(input);
  EngineSetup setup = setup_from(numbers);
  const FrameSet sets[]{{frames_from<std::uint16_t>(numbers.rest(), setup), 16},
                        {frames_from<double>(numbers.rest(), setup)}};
  for (const EngineKind engine : {EngineKind::automatic, EngineKind::reference}) {
    setup.settings.engine = engine;
    for (const FrameSet& frames : sets) {
      Cloud cloud;
      Engine(setup).cloud(frames, cloud);
      require_finite_where_valid(cloud);
    }
  }
}

std::vector<Bytes> noise(std::size_t bytes) {
  std::mt19937 random(7);
  std::vector<Bytes> seeds(24, Bytes(bytes));
  for (Bytes& seed : seeds) {
    for (std::uint8_t& byte : seed) byte = static_cast<std::uint8_t>(random());
  }
  return seeds;
}

/// A pattern that is known by its neighbours, and anything over it: places are in the field.
void locate(std::span<const std::uint8_t> input) {
  static const std::vector<SymbolGrid> grids = {symbol_array(8, 8), coloured_stripes(16)};
  InputNumbers numbers(input);
  const SymbolGrid& grid = grids[static_cast<std::size_t>(numbers.below(2))];
  const Axis axis = numbers.below(2) == 0 ? Axis::x : Axis::y;
  const Size size{numbers.below(96) + 1, numbers.below(96) + 1};
  std::vector<Image<float>> frames(grid.rows() > 1 ? 1 : 3, Image<float>(size));
  for (std::size_t n = 0; n < frames.size(); ++n) {
    for (int row = 0; row < size.height; ++row) {
      for (int column = 0; column < size.width; ++column) {
        const double u = (column + 0.5) / size.width, v = (row + 0.5) / size.height;
        const double shape = axis == Axis::x ? grid_intensity(grid, static_cast<int>(n), u, v)
                                             : grid_intensity(grid, static_cast<int>(n), v, u);
        frames[n](column, row) = static_cast<float>(200 * shape);
      }
    }
  }
  while (!numbers.rest().empty()) {
    Image<float>& frame =
        frames[static_cast<std::size_t>(numbers.below(static_cast<int>(frames.size())))];
    const int column = numbers.below(size.width), row = numbers.below(size.height);
    const auto length = std::min<int>(numbers.next<std::uint8_t>(), size.width - column);
    std::fill_n(frame.row(row) + column, length, static_cast<float>(numbers.next<std::uint8_t>()));
  }
  for (const float y : located_by_neighbours(grid, axis, std::move(frames)).coordinate) {
    if (y < 0 || y > 1) throw std::logic_error("a place beyond the field");
  }
}

const bool knows_frame_targets =
    add_fuzz_target({"alignment", [] { return noise(200); }, align_frames}) &&
    add_fuzz_target({"decoder", [] { return noise(1000); }, compare_engines, 4}, 1000,
                    std::uint64_t{1} << 30) &&  // tables of two engines
    add_fuzz_target({"values", [] { return noise(1000); }, make_clouds, 8}, 1000,
                    std::uint64_t{1} << 30) &&
    add_fuzz_target({"locate", [] { return noise(400); }, locate, 4});

}  // namespace
}  // namespace slipstream
