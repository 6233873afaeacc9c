#include "slipstream/reconstruct/detail/gpu_engine.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <utility>

#include "slipstream/error/error.h"
#include "slipstream/image/parallel_rows.h"

namespace slipstream {
namespace {

constexpr std::uint32_t coordinates_spirv[] =  // NOLINT(modernize-avoid-c-arrays)
#include "coordinates.spirv.inc"
    ;
constexpr std::uint32_t points_spirv[] =  // NOLINT(modernize-avoid-c-arrays)
#include "points.spirv.inc"
    ;

constexpr std::size_t whole_words = 4;  // an invocation has four pixels

std::size_t padded(Size size) {
  const std::size_t pixels =
      static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
  return (pixels + whole_words - 1) / whole_words * whole_words;
}

GpuProgram coordinate_program(const std::shared_ptr<const Gpu>& gpu, std::size_t bands,
                              std::uint32_t bits) {
  return {gpu, coordinates_spirv, std::array{bits, static_cast<std::uint32_t>(bands)}};
}

/// Four E_x, then their E_y, and so on.
GpuBuffer rays_on(const std::shared_ptr<const Gpu>& gpu, const RayTable& rays) {
  const std::size_t pixels = rays.E_x.pixel_count();
  GpuBuffer buffer(gpu, 2 * padded(rays.E_x.size()) * sizeof(float), GpuMemory::upload);
  auto* const to = reinterpret_cast<float*>(buffer.data());
  for (std::size_t i = 0; i < pixels; ++i) {
    float* const four = to + i / whole_words * 2 * whole_words + i % whole_words;
    four[0] = rays.E_x.begin()[i];
    four[whole_words] = rays.E_y.begin()[i];
  }
  return buffer;
}

/// Frame after frame without gaps.
template <class Pixel>
void copy_frames(const Frames<Pixel>& frames, std::size_t frame_bytes, std::byte* to) {
  for (std::size_t n = 0; n < frames.size(); ++n) {
    const ImageView<const Pixel>& frame = frames[n];
    const std::size_t row_bytes = static_cast<std::size_t>(frame.width()) * sizeof(Pixel);
    for (int row = 0; row < frame.height(); ++row) {
      std::memcpy(to + n * frame_bytes + static_cast<std::size_t>(row) * row_bytes, frame.row(row),
                  row_bytes);
    }
  }
}

/// NaN, which a shader need not know, becomes a coordinate that is none.
void copy_coarse(const Image<float>& coarse, std::byte* to) {
  constexpr float none = 1e30F;
  std::transform(coarse.begin(), coarse.end(), reinterpret_cast<float*>(to),
                 [](float y) { return std::isnan(y) ? none : y; });
}

/// The planes of an output, one after another, and where each goes.
struct PlaneList {
  GpuStages::Planes planes;
  std::vector<Image<float>*> images;

  void add(GpuStages::Word& plane, Image<float>& image, Size size) {
    if (image.size() != size) image = Image<float>(size);
    plane = static_cast<GpuStages::Word>(images.size() * (padded(size) / whole_words));
    images.push_back(&image);
  }
};

Image<Validity>* reasons_of(const FusedOutput& output) {
  if (output.cloud != nullptr) return &output.cloud->validity;
  return output.depth != nullptr ? &output.depth->validity : nullptr;
}

PlaneList planes_of(const FusedOutput& output, Size size, bool several_bands) {
  PlaneList list;
  GpuStages::Planes& at = list.planes;
  if (Cloud* const cloud = output.cloud) {
    list.add(at.x, cloud->x, size);
    list.add(at.y, cloud->y, size);
    list.add(at.z, cloud->z, size);
    if (output.maps == nullptr) list.add(at.mean, cloud->intensity, size);
  } else if (output.depth != nullptr) {
    list.add(at.z, output.depth->z, size);
  }
  if (Maps* const maps = output.maps) {
    list.add(at.mean, maps->mean, size);
    list.add(at.modulation, maps->modulation, size);
    list.add(at.phase, maps->wrapped_phase, size);
    list.add(at.coordinate, maps->coordinate, size);
    if (several_bands) {
      list.add(at.doubt, maps->fringe_order_doubt, size);
    } else {
      maps->fringe_order_doubt = {};
    }
  } else if (output.modulation != nullptr) {
    list.add(at.modulation, *output.modulation, size);
  }
  if (Image<Validity>* const reasons = reasons_of(output); reasons && reasons->size() != size) {
    *reasons = Image<Validity>(size);
  }
  if (output.numbers != nullptr && output.numbers->size() != size) {
    *output.numbers = Image<std::uint16_t>(size);
  }
  return list;
}

void copy_results(const GpuScanMemory::Parts& memory, const PlaneList& planes,
                  const FusedOutput& output, double full_scale) {
  for_each_row(static_cast<int>(planes.images.size()), [&](int plane) {
    Image<float>& image = *planes.images[static_cast<std::size_t>(plane)];
    const std::size_t from = static_cast<std::size_t>(plane) * padded(image.size()) * sizeof(float);
    std::memcpy(image.begin(), memory.output.data() + from, image.pixel_count() * sizeof(float));
  });
  if (Image<Validity>* const reasons = reasons_of(output)) {
    std::memcpy(reasons->begin(), memory.packed.data(), reasons->pixel_count());
  }
  if (output.numbers != nullptr) {
    std::memcpy(output.numbers->begin(), memory.packed.data(),
                output.numbers->pixel_count() * sizeof(std::uint16_t));
  }
  if (output.cloud == nullptr || output.maps == nullptr) return;
  const Image<float>& mean = output.maps->mean;
  if (output.cloud->intensity.size() != mean.size()) output.cloud->intensity = mean;
  const auto to_8_bits = static_cast<float>(255 / full_scale);
  std::transform(mean.begin(), mean.end(), output.cloud->intensity.begin(),
                 [&](float level) { return to_8_bits * level; });
}

}  // namespace

GpuEngine::GpuEngine(const FusedEngine& fused, GpuProgramText text, std::shared_ptr<const Gpu> gpu)
    : settings_(fused.settings()),
      text_(std::move(text)),
      gpu_(std::move(gpu)),
      rays_(rays_on(gpu_, fused.stages().rays)),
      coordinates_of_8_bits_(coordinate_program(gpu_, fused.stages().bands.size(), 8)),
      coordinates_of_16_bits_(coordinate_program(gpu_, fused.stages().bands.size(), 16)),
      points_(gpu_, points_spirv, {}) {
  for (const auto& band : fused.stages().bands) sinusoids_.push_back(band.sinusoid);
}

std::optional<GpuEngine> GpuEngine::make(const FusedEngine& fused, std::optional<int> device) {
  std::optional<GpuProgramText> text = gpu_stages(fused.stages());
  if (!text) return std::nullopt;
  return GpuEngine(fused, std::move(*text), Gpu::open(device));
}

GpuScanMemory::Parts GpuEngine::memory_for(std::size_t frame_bytes, std::size_t planes) const {
  const std::size_t pixels = padded({text_.stages.width, text_.stages.height});
  const std::size_t stage_bytes = sizeof(GpuStages) + text_.words.size() * sizeof(GpuStages::Word);
  GpuScanMemory::Parts parts{
      .frames = GpuBuffer(gpu_, frame_bytes, GpuMemory::upload),
      .stages = GpuBuffer(gpu_, stage_bytes, GpuMemory::upload),
      .between = GpuBuffer(gpu_, pixels * 2 * sizeof(float), GpuMemory::device),
      .output = GpuBuffer(gpu_, pixels * planes * sizeof(float), GpuMemory::download),
      .packed = GpuBuffer(gpu_, pixels * sizeof(std::uint16_t), GpuMemory::download),
      .run = GpuRun(gpu_)};
  std::memcpy(parts.stages.data() + sizeof(GpuStages), text_.words.data(),
              stage_bytes - sizeof(GpuStages));
  return parts;
}

void GpuEngine::operator()(const FrameViews& frames, const FusedOutput& output,
                           GpuScanMemory& memory, const Image<float>* coarse) const {
  GpuStages stages = text_.stages;
  const Size size{stages.width, stages.height};
  const double full_scale = frames.full_scale();
  const double mean_of = output.maps != nullptr ? 1 : 255 / full_scale;
  for (std::size_t i = 0; i < sinusoids_.size(); ++i) {
    const SinusoidLimits limits =
        sinusoid_limits(sinusoids_[i], settings_, full_scale, frames.saturation(), mean_of);
    stages.bands[i].least_square = limits.least_square;
    stages.bands[i].mean_scale = limits.mean_scale;
    stages.bands[i].full_scale = limits.full_scale;
  }
  const GpuStages::Band& first = stages.bands.front();
  stages.code.mean_to_frames = 1 / (first.mean_scale * static_cast<float>(first.steps));
  const PlaneList planes = planes_of(output, size, stages.links > 0);
  stages.planes = planes.planes;
  stages.packed = {.wanted = output.makes_points() ? 1 : 0, .offset = output.scale.offset};
  if (output.numbers != nullptr) stages.packed.numbers_per_mm = 1 / output.scale.scale;

  frames.visit([&]<class Pixel>(const Frames<Pixel>& views) {
    if constexpr (std::is_integral_v<Pixel>) {
      const std::size_t frame_bytes = padded(size) * sizeof(Pixel);
      const std::size_t all_frames = views.size() * frame_bytes;
      const std::size_t coarse_bytes = coarse != nullptr ? padded(size) * sizeof(float) : 0;
      const std::size_t plane_bytes = planes.images.size() * padded(size) * sizeof(float);
      if (!memory.parts || memory.parts->frames.size() < all_frames + coarse_bytes ||
          memory.parts->output.size() < plane_bytes) {
        memory.parts.reset();
        memory.parts = memory_for(all_frames + coarse_bytes, planes.images.size());
      }
      const GpuScanMemory::Parts& parts = *memory.parts;
      stages.frame_words = static_cast<GpuStages::Word>(frame_bytes / sizeof(GpuStages::Word));
      stages.coarse_given = static_cast<GpuStages::Word>(
          coarse != nullptr ? all_frames / sizeof(GpuStages::Word) : 0);
      std::memcpy(parts.stages.data(), &stages, sizeof(stages));
      copy_frames(views, frame_bytes, parts.frames.data());
      if (coarse != nullptr) copy_coarse(*coarse, parts.frames.data() + all_frames);
      const GpuProgram& coordinates =
          sizeof(Pixel) == 1 ? coordinates_of_8_bits_ : coordinates_of_16_bits_;
      const std::array programs{&coordinates, &points_};
      memory.parts->run(std::array{&parts.frames, &parts.stages, &rays_, &parts.between,
                                   &parts.output, &parts.packed},
                        std::span(programs).first(output.makes_points() ? 2 : 1),
                        padded(size) / whole_words);
      copy_results(parts, planes, output, full_scale);
    } else {
      throw Error("frames are not quantised; the GPU takes 8 to 16 bits");
    }
  });
}

}  // namespace slipstream
