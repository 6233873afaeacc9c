#include "slipstream/reconstruct/gpu/gpu_engine.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>

#include "slipstream/base/error.h"
#include "slipstream/base/parallel_rows.h"

namespace slipstream {
namespace {

constexpr std::uint32_t coordinates_spirv[] =  // NOLINT(modernize-avoid-c-arrays)
#include "coordinates.spirv.inc"
    ;
constexpr std::uint32_t points_spirv[] =  // NOLINT(modernize-avoid-c-arrays)
#include "points.spirv.inc"
    ;
constexpr std::uint32_t vote_spirv[] =  // NOLINT(modernize-avoid-c-arrays)
#include "vote.spirv.inc"
    ;

/// Passes of the vote, by the tasks of vote.comp: choose, restore, settle and finish.
constexpr std::array<std::size_t, 13> vote_passes{0, 2, 0, 2, 0, 2, 1, 2, 1, 2, 1, 2, 3};

constexpr std::size_t whole_words = 4;  // an invocation has four pixels

std::size_t pixels_of(Size size) {
  return static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
}

std::size_t padded(Size size) {
  return (pixels_of(size) + whole_words - 1) / whole_words * whole_words;
}

/// Pixels that are computed at once, so few that the largest buffer is small enough: results, or
/// frames.
std::size_t pixels_in_buffers(int frames, std::size_t pixels, std::size_t most_bytes) {
  constexpr std::size_t most_planes = 8, most_pixel_bytes = 2;
  const std::size_t each =
      std::max(most_planes * sizeof(float),
               static_cast<std::size_t>(frames) * most_pixel_bytes + sizeof(float));
  return std::min(pixels, most_bytes / each);
}

int part_count(Size size, int beside, std::size_t pixels) {
  const std::size_t seen_beside = pixels_of({size.width, 2 * beside});
  pixels = pixels > seen_beside ? pixels - seen_beside : 1;
  return static_cast<int>(std::clamp<std::size_t>((pixels_of(size) + pixels - 1) / pixels, 1,
                                                  static_cast<std::size_t>(size.height)));
}

GpuProgram coordinate_program(const std::shared_ptr<const Gpu>& gpu, std::size_t bands,
                              std::uint32_t bits) {
  return {gpu, coordinates_spirv, std::array{bits, static_cast<std::uint32_t>(bands)}};
}

/// Four E_x, then their E_y, and so on.
GpuBuffer rays_on(const std::shared_ptr<const Gpu>& gpu, const RayTable& rays, int first,
                  int last) {
  const Size size{rays.E_x.width(), last - first};
  GpuBuffer buffer(gpu, 2 * padded(size) * sizeof(float), GpuMemory::upload);
  auto* const to = reinterpret_cast<float*>(buffer.data());
  const float* const E_x = rays.E_x.row(first);
  const float* const E_y = rays.E_y.row(first);
  for (std::size_t i = 0; i < pixels_of(size); ++i) {
    float* const four = to + i / whole_words * 2 * whole_words + i % whole_words;
    four[0] = E_x[i];
    four[whole_words] = E_y[i];
  }
  return buffer;
}

std::size_t bytes_of_pixels(const FrameViews& frames) {
  return frames.visit([]<class Pixel>(const Frames<Pixel>&) { return sizeof(Pixel); });
}

/// Rows from `first` to `last`, frame after frame without gaps.
template <class Pixel>
void copy_frames(const Frames<Pixel>& frames, int first, int last, std::size_t frame_bytes,
                 std::byte* to) {
  for (const ImageView<const Pixel>& frame : frames) {
    const std::size_t row_bytes = static_cast<std::size_t>(frame.width()) * sizeof(Pixel);
    for (int row = first; row < last; ++row) {
      std::memcpy(to + static_cast<std::size_t>(row - first) * row_bytes, frame.row(row),
                  row_bytes);
    }
    to += frame_bytes;
  }
}

/// NaN, which a shader need not know, becomes a coordinate that is none.
void copy_coarse(const Image<float>& coarse, int first, int last, std::byte* to) {
  constexpr float none = 1e30F;
  std::transform(coarse.row(first), coarse.row(last - 1) + coarse.width(),
                 reinterpret_cast<float*>(to), [](float y) { return std::isnan(y) ? none : y; });
}

/// The planes of an output, one after another, and where each goes.
struct PlaneList {
  std::size_t plane_pixels;
  GpuStages::Planes planes{};
  std::vector<Image<float>*> images{};

  void add(GpuStages::Word& plane, Image<float>& image) {
    plane = static_cast<GpuStages::Word>(images.size() * (plane_pixels / whole_words));
    images.push_back(&image);
  }
};

Image<Validity>* reasons_of(const Outputs& output) {
  if (output.cloud != nullptr) return &output.cloud->validity;
  return output.depth != nullptr ? &output.depth->validity : nullptr;
}

PlaneList planes_of(const Outputs& output, std::size_t plane_pixels) {
  PlaneList list{.plane_pixels = plane_pixels};
  GpuStages::Planes& at = list.planes;
  if (Cloud* const cloud = output.cloud) {
    list.add(at.x, cloud->x);
    list.add(at.y, cloud->y);
    list.add(at.z, cloud->z);
    if (output.maps == nullptr) list.add(at.mean, cloud->intensity);
  } else if (output.depth != nullptr) {
    list.add(at.z, output.depth->z);
  }
  if (Maps* const maps = output.maps) {
    list.add(at.mean, maps->mean);
    list.add(at.modulation, maps->modulation);
    list.add(at.phase, maps->wrapped_phase);
    list.add(at.coordinate, maps->coordinate);
    if (!maps->fringe_order_doubt.empty()) list.add(at.doubt, maps->fringe_order_doubt);
  } else if (output.modulation != nullptr) {
    list.add(at.modulation, *output.modulation);
  }
  return list;
}

/// Pixels of whole rows.
template <class Pixel>
void copy_rows(const std::byte* from, int first, int last, Image<Pixel>& to) {
  std::memcpy(to.row(first), from, pixels_of({to.width(), last - first}) * sizeof(Pixel));
}

void scale_intensity(const Image<float>& mean, double full_scale, Image<float>& intensity) {
  const auto to_8_bits = static_cast<float>(255 / full_scale);
  std::transform(mean.begin(), mean.end(), intensity.begin(),
                 [&](float level) { return to_8_bits * level; });
}

}  // namespace

/// Scans on their way through the device.
struct GpuEngine::Job {
  GpuStages stages;
  std::vector<PlaneList> planes;  ///< of each scan
  std::span<const FrameViews> scans;
  std::span<const Outputs> outputs;
  const Image<float>* coarse;
  std::size_t plane_pixels;
  std::size_t pixel_bytes;  ///< of frames
  std::size_t together;     ///< scans that are computed at once

  [[nodiscard]] std::size_t frame_bytes() const { return plane_pixels * pixel_bytes; }
  [[nodiscard]] std::size_t all_frames() const {
    return frame_bytes() * static_cast<std::size_t>(scans.front().count());
  }
  [[nodiscard]] std::size_t plane_bytes() const { return plane_pixels * sizeof(float); }
  [[nodiscard]] std::size_t between_bytes() const {
    return together * static_cast<std::size_t>(stages.kept) * plane_bytes();
  }
  // Of each scan:
  [[nodiscard]] std::size_t upload_bytes() const {
    return all_frames() + (coarse != nullptr ? plane_bytes() : 0);
  }
  [[nodiscard]] std::size_t output_bytes() const {
    return planes.front().images.size() * plane_bytes();
  }
  [[nodiscard]] std::size_t packed_bytes() const {
    const bool numbers = outputs.front().depth16 != nullptr;
    return plane_pixels * (numbers ? sizeof(std::uint16_t) : sizeof(Validity));
  }
};

/// What one submission computes: rows of one scan, or several scans.
struct GpuEngine::Step {
  const Part& part;
  std::size_t first, scans;
};

GpuEngine::GpuEngine(const FusedEngine& fused, GpuProgramText text, std::shared_ptr<const Gpu> gpu,
                     std::size_t pixels)
    : settings_(fused.settings()),
      frames_(fused.stages().frames),
      text_(std::move(text)),
      gpu_(std::move(gpu)),
      coordinates_of_8_bits_(coordinate_program(gpu_, fused.stages().bands.size(), 8)),
      coordinates_of_16_bits_(coordinate_program(gpu_, fused.stages().bands.size(), 16)),
      points_(gpu_, points_spirv, {}) {
  const FusedStages& stages = fused.stages();
  for (const auto& band : stages.bands) sinusoids_.push_back(band.sinusoid);
  const auto [width, height] = stages.rays.E_x.size();
  const std::size_t at_once = pixels_in_buffers(stages.frames, pixels, gpu_->most_bytes());
  const int beside = stages.cue ? VoteBlock::seen : 1;
  const int count = part_count({width, height}, beside, at_once);
  const auto border = [&, height = height](int i) {
    return static_cast<int>(std::int64_t{height} * i / count);
  };
  for (int i = 0; i < count; ++i) {
    const int first = border(i), last = border(i + 1);
    const int first_seen = std::max(first - beside, 0), last_seen = std::min(last + beside, height);
    parts_.push_back(
        {first, last, first_seen, last_seen, rays_on(gpu_, stages.rays, first_seen, last_seen)});
    largest_ = {width, std::max(largest_.height, last_seen - first_seen)};
  }
  if (stages.cue) {
    cue_limits_ = cue_limits(stages, settings_, 255);
    for (std::uint32_t task = 0; task < 4; ++task) {
      vote_.emplace_back(gpu_, vote_spirv, std::array{task});
    }
  }
  if (count > 1) return;
  together_ = std::clamp<std::size_t>(at_once / padded(largest_), 1, GpuRun::most_layers);
}

std::optional<GpuEngine> GpuEngine::make(const FusedEngine& fused, std::optional<int> device,
                                         std::size_t pixels) {
  std::optional<GpuProgramText> text = gpu_stages(fused.stages());
  if (!text) return std::nullopt;
  return GpuEngine(fused, std::move(*text), Gpu::open(device), pixels);
}

GpuScanMemory::Slot GpuEngine::slot_for(const Job& job, bool resident) const {
  const std::size_t stage_bytes = sizeof(GpuStages) + text_.words.size() * sizeof(GpuStages::Word);
  const GpuMemory results = resident ? GpuMemory::device : GpuMemory::download;
  GpuScanMemory::Slot slot{
      .frames = GpuBuffer(gpu_, job.together * job.upload_bytes(), GpuMemory::upload),
      .stages = GpuBuffer(gpu_, stage_bytes, GpuMemory::upload),
      .between = GpuBuffer(gpu_, job.between_bytes(), GpuMemory::device),
      .output = GpuBuffer(gpu_, job.together * job.output_bytes(), results),
      .packed = GpuBuffer(gpu_, job.together * job.plane_pixels * sizeof(std::uint16_t), results),
      .run = GpuRun(gpu_)};
  std::memcpy(slot.stages.data() + sizeof(GpuStages), text_.words.data(),
              stage_bytes - sizeof(GpuStages));
  return slot;
}

void GpuEngine::upload(const Step& step, const Job& job, const GpuBuffer& to) {
  const int first = step.part.first_seen, last = step.part.last_seen;
  for (std::size_t scan = 0; scan < step.scans; ++scan) {
    std::byte* const place = to.data() + scan * job.upload_bytes();
    job.scans[step.first + scan].visit([&]<class Pixel>(const Frames<Pixel>& views) {
      copy_frames(views, first, last, job.frame_bytes(), place);
    });
    if (job.coarse != nullptr) copy_coarse(*job.coarse, first, last, place + job.all_frames());
  }
}

void GpuEngine::start(const Step& step, Job& job, GpuScanMemory::Slot& slot) const {
  const Part& part = step.part;
  job.stages.height = part.last_seen - part.first_seen;
  std::memcpy(slot.stages.data(), &job.stages, sizeof(job.stages));
  std::vector programs{job.pixel_bytes == 1 ? &coordinates_of_8_bits_ : &coordinates_of_16_bits_};
  if (!vote_.empty()) {
    for (const std::size_t task : vote_passes) programs.push_back(&vote_[task]);
  }
  if (job.outputs.front().makes_points()) programs.push_back(&points_);
  slot.run.start(std::array<const GpuBuffer*, 6>{&slot.frames, &slot.stages, &part.rays,
                                                 &slot.between, &slot.output, &slot.packed},
                 programs, padded({job.stages.width, job.stages.height}) / whole_words,
                 static_cast<std::uint32_t>(step.scans));
}

void GpuEngine::collect(const Step& step, const Job& job, const GpuScanMemory::Slot& slot) {
  const Part& part = step.part;
  const std::size_t skipped = pixels_of({job.stages.width, part.first - part.first_seen});
  const std::size_t planes = job.planes.front().images.size();
  for_each_row(static_cast<int>(step.scans * planes), [&](int plane) {
    const auto i = static_cast<std::size_t>(plane);
    copy_rows(slot.output.data() + i * job.plane_bytes() + skipped * sizeof(float), part.first,
              part.last, *job.planes[step.first + i / planes].images[i % planes]);
  });
  for (std::size_t scan = 0; scan < step.scans; ++scan) {
    const Outputs& output = job.outputs[step.first + scan];
    const std::byte* const packed = slot.packed.data() + scan * job.packed_bytes();
    if (Image<Validity>* const reasons = reasons_of(output)) {
      copy_rows(packed + skipped * sizeof(Validity), part.first, part.last, *reasons);
    }
    if (output.depth16 != nullptr) {
      copy_rows(packed + skipped * sizeof(std::uint16_t), part.first, part.last, *output.depth16);
    }
  }
}

GpuEngine::Job GpuEngine::job_for(std::span<const FrameViews> scans,
                                  std::span<const Outputs> outputs,
                                  const Image<float>* coarse) const {
  const Size size{text_.stages.width, text_.stages.height};
  const FrameViews& frames = scans.front();
  const Outputs& output = outputs.front();
  Job job{.stages = text_.stages,
          .planes = {},
          .scans = scans,
          .outputs = outputs,
          .coarse = coarse,
          .plane_pixels = padded(largest_),
          .pixel_bytes = bytes_of_pixels(frames),
          .together = std::min(together_, scans.size())};
  for (const Outputs& of : outputs) {
    prepare(of, size, text_.stages.links > 0 || !vote_.empty());
    job.planes.push_back(planes_of(of, job.plane_pixels));
  }
  GpuStages& stages = job.stages;
  const double full_scale = frames.full_scale();
  const double mean_of = output.maps != nullptr ? 1 : 255 / full_scale;
  for (std::size_t i = 0; i < sinusoids_.size(); ++i) {
    const SinusoidLimits limits =
        sinusoid_limits(sinusoids_[i], settings_, full_scale, frames.saturation(), mean_of);
    stages.bands[i].least_square = limits.least_square;
    stages.bands[i].mean_scale = limits.mean_scale;
    stages.bands[i].full_scale = limits.full_scale;
  }
  if (!vote_.empty()) {
    const auto level = static_cast<float>(full_scale / 255);
    stages.cue.ambient = level * cue_limits_.ambient;
    stages.cue.lit_square = level * level * cue_limits_.lit_square;
    stages.cue.voting_square = level * level * cue_limits_.voting_square;
    stages.cue.to_8_bits = 1 / level;
    stages.cue.shade =
        static_cast<float>(mean_of) * level * stages.cue.cue_share / stages.cue.share;
  }
  const GpuStages::Band& first = stages.bands.front();
  stages.code.mean_to_frames = 1 / (first.mean_scale * static_cast<float>(first.steps));
  stages.planes = job.planes.front().planes;
  stages.packed = {.wanted = output.makes_points() ? 1 : 0, .offset = output.scale.offset};
  if (output.depth16 != nullptr) stages.packed.numbers_per_mm = 1 / output.scale.scale;
  const auto words = [](std::size_t bytes) {
    return static_cast<GpuStages::Word>(bytes / sizeof(GpuStages::Word));
  };
  stages.plane_fours = static_cast<GpuStages::Word>(job.plane_pixels / whole_words);
  stages.scan_words = words(job.upload_bytes());
  stages.scan_fours =
      stages.plane_fours * static_cast<GpuStages::Word>(job.planes.front().images.size());
  stages.coarse_given = coarse != nullptr ? words(job.all_frames()) : 0;
  return job;
}

void GpuEngine::operator()(const FrameViews& frames, const Outputs& output, GpuScanMemory& memory,
                           const Image<float>* coarse) const {
  (*this)(std::span(&frames, 1), std::span(&output, 1), memory, coarse);
}

void GpuEngine::operator()(std::span<const FrameViews> scans, std::span<const Outputs> outputs,
                           GpuScanMemory& memory, const Image<float>* coarse) const {
  const FrameViews& like = scans.front();
  for (const FrameViews& frames : scans) {
    require_frames(frames, frames_, {text_.stages.width, text_.stages.height});
  }
  if (!std::all_of(scans.begin(), scans.end(), [&](const FrameViews& frames) {
        return frames.quantised() && bytes_of_pixels(frames) == bytes_of_pixels(like) &&
               frames.full_scale() == like.full_scale() && frames.merged() == like.merged();
      })) {
    throw Error("frames are not quantised or not alike; the GPU takes 8 to 16 bits");
  }
  Job job = job_for(scans, outputs, coarse);
  const std::size_t at_a_time = (scans.size() + job.together - 1) / job.together;
  const std::size_t steps = at_a_time * parts_.size();
  auto& slots = memory.slots;
  // What was made later is no larger.
  const bool keeps = !slots.empty() &&
                     slots.back().frames.size() >= job.together * job.upload_bytes() &&
                     slots.back().between.size() >= job.between_bytes() &&
                     slots.back().output.size() >= job.together * job.output_bytes();
  if (!keeps) slots.clear();
  while (slots.size() < (memory.resident ? steps : std::min<std::size_t>(steps, 2))) {
    slots.push_back(slot_for(job, memory.resident));
  }
  const auto step_of = [&](std::size_t i) {
    const std::size_t first = i / parts_.size() * job.together;
    return Step{parts_[i % parts_.size()], first, std::min(job.together, scans.size() - first)};
  };
  const auto collect_from = [&](std::size_t i) {
    slots[i % slots.size()].run.wait();
    if (!memory.resident) collect(step_of(i), job, slots[i % slots.size()]);
  };
  for (std::size_t i = 0; i < steps; ++i) {
    GpuScanMemory::Slot& slot = slots[i % slots.size()];
    slot.run.wait();  // of a call that was given up by an exception
    if (!keeps || !memory.resident) upload(step_of(i), job, slot.frames);
    start(step_of(i), job, slot);
    if (i > 0) collect_from(i - 1);
  }
  collect_from(steps - 1);
  if (memory.resident) return;
  for (const Outputs& output : outputs) {
    if (output.cloud == nullptr || output.maps == nullptr) continue;
    scale_intensity(output.maps->mean, like.full_scale(), output.cloud->intensity);
  }
}

}  // namespace slipstream
