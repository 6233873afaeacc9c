#include "reconstruct/gpu/gpu_engine.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "geometry/ray_table.h"
#include "reconstruct/fused/voted_band.h"

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

constexpr std::size_t whole_words = 4;  // pixels per invocation

std::size_t pixels_of(Size size) {
  return static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
}

std::size_t padded(Size size) {
  return (pixels_of(size) + whole_words - 1) / whole_words * whole_words;
}

/// Interleaved: four E_x, then their E_y, and so on.
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

/// Copies the rows from `first` to `last`, frame after frame without gaps.
void copy_frames(const FrameViews& frames, int first, int last, std::size_t frame_bytes,
                 std::byte* to) {
  frames.visit([&]<class Pixel>(const Frames<Pixel>& views) {
    for (const ImageView<const Pixel>& frame : views) {
      const std::size_t row_bytes = static_cast<std::size_t>(frame.width()) * sizeof(Pixel);
      for (int row = first; row < last; ++row) {
        std::memcpy(to + static_cast<std::size_t>(row - first) * row_bytes, frame.row(row),
                    row_bytes);
      }
      to += frame_bytes;
    }
  });
}

/// Replaces NaN, which shaders need not support, by the value for no coordinate.
void copy_coarse(const Image<float>& coarse, int first, int last, std::byte* to) {
  constexpr float none = 1e30F;
  std::transform(coarse.row(first), coarse.row(last - 1) + coarse.width(),
                 reinterpret_cast<float*>(to), [](float y) { return std::isnan(y) ? none : y; });
}

/// Planes of an output, one after another, and their positions.
struct PlaneList {
  std::size_t plane_pixels;
  GpuPlanes planes{};
  std::vector<Image<float>*> images{};

  void add(int& plane, Image<float>& image) {
    plane = static_cast<int>(images.size() * (plane_pixels / whole_words));
    images.push_back(&image);
  }
};

PlaneList planes_of(const Outputs& output, std::size_t plane_pixels) {
  PlaneList list{.plane_pixels = plane_pixels};
  GpuPlanes& at = list.planes;

  // Points. Maps also give the cloud's intensity, at the end.
  if (Cloud* const cloud = output.cloud) {
    list.add(at.x, cloud->x);
    list.add(at.y, cloud->y);
    list.add(at.z, cloud->z);
    if (output.maps == nullptr) list.add(at.mean, cloud->intensity);
  } else if (output.depth != nullptr) {
    list.add(at.z, output.depth->z);
  }

  // Maps, or the modulation alone.
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

/// Scans in progress, and the sizes of their buffers.
struct Job {
  GpuStages stages;
  std::vector<PlaneList> planes{};  ///< one per scan
  std::span<const FrameViews> scans;
  std::span<const Outputs> outputs;
  const Image<float>* coarse;
  std::size_t together;  ///< scans computed at once
  std::size_t pixels;    ///< of a plane
  std::size_t frame_bytes = 0, between_bytes = 0;
  std::size_t all_frames_bytes = 0, upload_bytes = 0, output_bytes = 0;  ///< of each scan
};

/// Work of one submission: rows of one scan, or several scans.
struct Step {
  const GpuEngine::Part& part;
  std::size_t first, scans;
};

Job job_for(const GpuEngine& engine, std::span<const FrameViews> scans,
            std::span<const Outputs> outputs, const Image<float>* coarse) {
  const FrameViews& frames = scans.front();
  const Outputs& output = outputs.front();
  const GpuStages& of = engine.text.stages;

  // 1. The scans and their outputs.
  Job job{.stages = of,
          .scans = scans,
          .outputs = outputs,
          .coarse = coarse,
          .together = std::min(engine.together, scans.size()),
          .pixels = padded(engine.largest)};
  for (const Outputs& each : outputs) {
    prepare(each, {of.width, of.height}, of.links > 0 || !engine.vote.empty());
    job.planes.push_back(planes_of(each, job.pixels));
  }

  // 2. Sizes of the buffers. The coarse coordinates follow the frames.
  const std::size_t plane_bytes = job.pixels * sizeof(float);
  const std::size_t planes = job.planes.front().images.size();
  job.frame_bytes = job.pixels * bytes_of_pixels(frames);
  job.all_frames_bytes = job.frame_bytes * static_cast<std::size_t>(frames.count());
  job.upload_bytes = job.all_frames_bytes + (coarse != nullptr ? plane_bytes : 0);
  job.output_bytes = planes * plane_bytes;
  job.between_bytes = job.together * static_cast<std::size_t>(of.kept) * plane_bytes;

  // 3. Limits, which depend on the camera's bits.
  GpuStages& stages = job.stages;
  std::vector<SinusoidLimits> limits;
  engine.fused.find_limits(frames, output, limits);
  for (std::size_t i = 0; i < limits.size(); ++i) stages.bands[i].limits = limits[i];

  if (!engine.vote.empty()) {
    const double full_scale = frames.full_scale();
    const auto level = static_cast<float>(full_scale / 255);
    const auto mean_of = static_cast<float>(output.maps != nullptr ? 1 : 255 / full_scale);
    stages.cue_limits = cue_limits(*engine.fused.stages, engine.fused.settings, full_scale);
    stages.vote.to_8_bits = 1 / level;
    stages.vote.shade = mean_of * level * stages.cue.shade;
  }

  const GpuBand& first = stages.bands.front();
  stages.code.mean_to_frames =
      1 / (first.limits.mean_scale * static_cast<float>(first.sinusoid.steps));

  // 4. Where and how the shaders write.
  stages.plane_at = job.planes.front().planes;
  stages.packing = {.wanted = output.makes_points() ? 1 : 0,
                    .numbers_per_mm = output.depth16 != nullptr ? 1 / output.scale.scale : 0,
                    .offset = output.scale.offset};

  stages.plane_fours = static_cast<int>(job.pixels / whole_words);
  stages.scan_words = static_cast<int>(job.upload_bytes / sizeof(int));
  stages.scan_fours = stages.plane_fours * static_cast<int>(planes);
  if (coarse != nullptr) stages.coarse_given = static_cast<int>(job.all_frames_bytes / sizeof(int));

  return job;
}

GpuScanMemory::Slot slot_for(const GpuEngine& engine, const Job& job, bool resident) {
  const auto& words = engine.text.words;
  const std::size_t word_bytes = words.size() * sizeof(int);
  const GpuMemory results = resident ? GpuMemory::device : GpuMemory::download;

  const auto buffer = [&](std::size_t bytes, GpuMemory memory) {
    return GpuBuffer(engine.gpu, bytes, memory);
  };

  GpuScanMemory::Slot slot{
      .frames = buffer(job.together * job.upload_bytes, GpuMemory::upload),
      .stages = buffer(sizeof(GpuStages) + word_bytes, GpuMemory::upload),
      .between = buffer(job.between_bytes, GpuMemory::device),
      .output = buffer(job.together * job.output_bytes, results),
      .packed = buffer(job.together * job.pixels * sizeof(std::uint16_t), results),
      .run = GpuRun(engine.gpu)};

  std::memcpy(slot.stages.data() + sizeof(GpuStages), words.data(), word_bytes);
  return slot;
}

void upload(const Step& step, const Job& job, const GpuBuffer& to) {
  const int first = step.part.first_seen, last = step.part.last_seen;

  for (std::size_t scan = 0; scan < step.scans; ++scan) {
    std::byte* const place = to.data() + scan * job.upload_bytes;

    copy_frames(job.scans[step.first + scan], first, last, job.frame_bytes, place);
    if (job.coarse != nullptr) copy_coarse(*job.coarse, first, last, place + job.all_frames_bytes);
  }
}

void start(const GpuEngine& engine, const Step& step, Job& job, GpuScanMemory::Slot& slot) {
  const GpuEngine::Part& part = step.part;

  // The stages of this part.
  job.stages.height = part.last_seen - part.first_seen;
  std::memcpy(slot.stages.data(), &job.stages, sizeof(job.stages));

  // The shaders: coordinates, the vote if there is a cue, points if wanted.
  std::vector programs{bytes_of_pixels(job.scans.front()) == 1 ? &engine.coordinates_of_8_bits
                                                               : &engine.coordinates_of_16_bits};
  if (!engine.vote.empty()) {
    for (const std::size_t task : vote_passes) programs.push_back(&engine.vote[task]);
  }
  if (job.outputs.front().makes_points()) programs.push_back(&engine.points);

  slot.run.start(std::array<const GpuBuffer*, 6>{&slot.frames, &slot.stages, &part.rays,
                                                 &slot.between, &slot.output, &slot.packed},
                 programs, padded({job.stages.width, job.stages.height}) / whole_words,
                 static_cast<std::uint32_t>(step.scans));
}

void collect(const Step& step, const Job& job, const GpuScanMemory::Slot& slot) {
  const GpuEngine::Part& part = step.part;
  const std::size_t skipped = pixels_of({job.stages.width, part.first - part.first_seen});
  const std::size_t planes = job.planes.front().images.size();

  const auto copy = [&]<class Pixel>(const GpuBuffer& from, std::size_t plane, Image<Pixel>& to) {
    std::memcpy(to.row(part.first), from.data() + (plane * job.pixels + skipped) * sizeof(Pixel),
                pixels_of({to.width(), part.last - part.first}) * sizeof(Pixel));
  };

  // Planes of numbers, then validity or 16-bit depth.
  for_each_row(static_cast<int>(step.scans * planes), [&](int plane) {
    const auto i = static_cast<std::size_t>(plane);
    copy(slot.output, i, *job.planes[step.first + i / planes].images[i % planes]);
  });
  for (std::size_t scan = 0; scan < step.scans; ++scan) {
    const Outputs& output = job.outputs[step.first + scan];
    if (output.cloud != nullptr) copy(slot.packed, scan, output.cloud->validity);
    if (output.depth != nullptr) copy(slot.packed, scan, output.depth->validity);
    if (output.depth16 != nullptr) copy(slot.packed, scan, *output.depth16);
  }
}

/// Throws Error unless all frames have one format that the GPU takes.
void require_one_format(const GpuEngine& engine, std::span<const FrameViews> scans) {
  const GpuStages& stages = engine.text.stages;
  const FrameViews& like = scans.front();

  for (const FrameViews& frames : scans) {
    require_frames(frames, engine.fused.stages->frames, {stages.width, stages.height});
    if (frames.quantised() && bytes_of_pixels(frames) == bytes_of_pixels(like) &&
        frames.full_scale() == like.full_scale() && frames.merged() == like.merged()) {
      continue;
    }
    throw Error("frames are not quantised or differ in format; the GPU takes 8 to 16 bits");
  }
}

/// Whether the buffers of the last call are large enough.
bool have_room(const std::vector<GpuScanMemory::Slot>& slots, const Job& job) {
  if (slots.empty()) return false;

  // The last slot is never larger than the others.
  const GpuScanMemory::Slot& last = slots.back();
  return last.frames.size() >= job.together * job.upload_bytes &&
         last.between.size() >= job.between_bytes &&
         last.output.size() >= job.together * job.output_bytes;
}

/// A cloud with maps takes its intensity from their mean.
void add_intensity(std::span<const Outputs> outputs, double full_scale) {
  const auto to_8_bits = static_cast<float>(255 / full_scale);

  for (const Outputs& output : outputs) {
    if (output.cloud == nullptr || output.maps == nullptr) continue;
    const Image<float>& mean = output.maps->mean;
    std::transform(mean.begin(), mean.end(), output.cloud->intensity.begin(),
                   [&](float level) { return to_8_bits * level; });
  }
}

}  // namespace

GpuEngine::GpuEngine(const FusedEngine& of, GpuProgramText program,
                     std::shared_ptr<const Gpu> device, std::size_t pixels)
    : fused(of), text(std::move(program)), gpu(std::move(device)), points(gpu, points_spirv, {}) {
  // 1. The shaders. The GPU's driver compiles them with these constants.
  const FusedStages& stages = *fused.stages;
  const auto bands = static_cast<std::uint32_t>(stages.bands.size());
  coordinates_of_8_bits = {gpu, coordinates_spirv, std::array{8U, bands}};
  coordinates_of_16_bits = {gpu, coordinates_spirv, std::array{16U, bands}};
  for (std::uint32_t task = 0; stages.cue && task < 4; ++task) {
    vote.emplace_back(gpu, vote_spirv, std::array{task});
  }

  // 2. Parts of whole rows. A part also reads the rows that its own need as neighbours.
  const auto [width, height] = stages.rays.E_x.size();
  // Few enough at once for the largest buffer: results, or 16-bit frames.
  constexpr std::size_t results = 8 * sizeof(float);
  const std::size_t frames = static_cast<std::size_t>(stages.frames) * 2 + sizeof(float);
  const std::size_t at_once = std::min(pixels, gpu->most_bytes() / std::max(results, frames));

  const int beside = stages.cue ? VoteBlock::seen : 1;
  const std::size_t seen_beside = pixels_of({width, 2 * beside});
  const std::size_t own = at_once > seen_beside ? at_once - seen_beside : 1;

  const int count = static_cast<int>(std::clamp<std::size_t>(
      (pixels_of({width, height}) + own - 1) / own, 1, static_cast<std::size_t>(height)));

  const auto border = [&, height = height](int i) {
    return static_cast<int>(std::int64_t{height} * i / count);
  };
  for (int i = 0; i < count; ++i) {
    const int first = border(i), last = border(i + 1);
    const int first_seen = std::max(first - beside, 0), last_seen = std::min(last + beside, height);

    parts.push_back(
        {first, last, first_seen, last_seen, rays_on(gpu, stages.rays, first_seen, last_seen)});
    largest = {width, std::max(largest.height, last_seen - first_seen)};
  }

  // 3. Small images: several scans at once.
  if (count > 1) return;
  together = std::clamp<std::size_t>(at_once / padded(largest), 1, GpuRun::most_layers);
}

std::optional<GpuEngine> GpuEngine::make(const FusedEngine& fused, std::optional<int> device,
                                         std::size_t pixels) {
  std::optional<GpuProgramText> text = gpu_stages(*fused.stages);
  if (!text) return std::nullopt;

  return GpuEngine(fused, std::move(*text), Gpu::open(device), pixels);
}

void GpuEngine::operator()(const FrameViews& frames, const Outputs& output, GpuScanMemory& memory,
                           const Image<float>* coarse) const {
  (*this)(std::span(&frames, 1), std::span(&output, 1), memory, coarse);
}

void GpuEngine::operator()(std::span<const FrameViews> scans, std::span<const Outputs> outputs,
                           GpuScanMemory& memory, const Image<float>* coarse) const {
  require_one_format(*this, scans);

  // 1. Buffers: those of the last call, if they are large enough.
  Job job = job_for(*this, scans, outputs, coarse);
  const std::size_t at_a_time = (scans.size() + job.together - 1) / job.together;
  const std::size_t steps = at_a_time * parts.size();

  auto& slots = memory.slots;
  if (!have_room(slots, job)) slots.clear();
  const std::size_t kept = slots.size();

  while (slots.size() < (memory.resident ? steps : std::min<std::size_t>(steps, 2))) {
    slots.push_back(slot_for(*this, job, memory.resident));
  }

  // 2. Upload and start each step, then collect the one before while the device computes.
  const auto step_of = [&](std::size_t i) {
    const std::size_t first = i / parts.size() * job.together;
    return Step{parts[i % parts.size()], first, std::min(job.together, scans.size() - first)};
  };

  const auto collect_from = [&](std::size_t i) {
    slots[i % slots.size()].run.wait();
    if (!memory.resident) collect(step_of(i), job, slots[i % slots.size()]);
  };

  for (std::size_t i = 0; i < steps; ++i) {
    GpuScanMemory::Slot& slot = slots[i % slots.size()];
    slot.run.wait();  // left by a call that ended with an exception
    // Resident slots hold their frames already, unless they are new.
    if (!memory.resident || i >= kept) upload(step_of(i), job, slot.frames);
    start(*this, step_of(i), job, slot);
    if (i > 0) collect_from(i - 1);
  }

  collect_from(steps - 1);
  if (!memory.resident) add_intensity(outputs, scans.front().full_scale());
}

}  // namespace slipstream
