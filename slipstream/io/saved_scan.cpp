#include "slipstream/io/saved_scan.h"

#include <chrono>
#include <cmath>
#include <ctime>
#include <string>
#include <utility>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "slipstream/error/error.h"
#include "slipstream/io/cloud_file.h"
#include "slipstream/io/file.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/preview.h"
#include "slipstream/io/recorded_cycle.h"
#include "slipstream/io/recording.h"
#include "slipstream/io/scanner_file.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

FrameSet recorded_frames(const ScanFiles& files) {
  const RecordingReader recording(files.path);
  if (const int bits = recording.header().format.bits; bits != files.bits) {
    throw Error(fmt::format("{}: its frames have {} bits; --bits {} is of pictures",
                            files.path.string(), bits, files.bits));
  }
  std::optional<FrameSet> frames = first_cycle(recording, files.sequence);
  if (!frames) {
    throw Error(fmt::format("{}: {} frames, and no whole cycle of {} among the first",
                            files.path.string(), recording.count(), cycle_length(files.sequence)));
  }
  return *std::move(frames);
}

/// Which pattern each frame shows.
FrameSet in_order(FrameSet frames, const ScanFiles& files) {
  if (files.order.empty()) return frames;
  if (!is_order_of(files.order, frames.count())) {
    throw Error(fmt::format(
        "{}: --order {} is no order of its {} frames; name each of 0 to {} "
        "once, with commas between",
        files.path.string(), fmt::join(files.order, ","), frames.count(), frames.count() - 1));
  }
  return reordered(std::move(frames), files.order);
}

/// One cycle, whole.
void save_recording(const fs::path& file, const Scan& scan) {
  const std::vector<Frame> frames = frames_of(scan.frames, file.string());
  RecordingWriter writer(file, {.format = {scan.frames.size(), scan.frames.bits()},
                                .sequence = scan.sequence,
                                .scanner = scan.scanner});
  for (const Frame& frame : frames) writer.append(frame);
  writer.finish();
}

void save_results(const fs::path& folder, const Cloud& cloud, const Maps& maps) {
  write_cloud(folder / "cloud.ply", cloud);
  write_map(folder / "depth.tiff", cloud.z);
  write_map(folder / "coordinate.tiff", maps.coordinate);
  write_map(folder / "phase.tiff", maps.wrapped_phase);
  write_map(folder / "modulation.tiff", maps.modulation);
  write_map(folder / "mean.tiff", maps.mean);
  write_depth_preview(folder / "preview.png", cloud);
}

fs::path path_named_by_time(const fs::path& parent, std::string_view what,
                            std::string_view ending) {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  const std::string name = fmt::format("{}-{:%Y%m%d-%H%M%S}", what, fmt::localtime(now));
  fs::path path = parent / fmt::format("{}{}", name, ending);
  for (int copy = 2; fs::exists(path); ++copy) {
    path = parent / fmt::format("{}-{}{}", name, copy, ending);
  }
  return path;
}

std::optional<double> error_against_truth(const fs::path& folder, const Cloud& cloud) {
  const fs::path file = folder / "truth" / "depth.tiff";
  if (!fs::exists(file)) return std::nullopt;
  const Image<double> truth = read_map(file);
  if (truth.size() != cloud.size()) {
    throw Error(fmt::format("{} is {}, the frames are {}; both must agree", file.string(),
                            text_of(truth.size()), text_of(cloud.size())));
  }
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < truth.pixel_count(); ++i) {
    const double difference = cloud.z.begin()[i] - truth.begin()[i];
    if (!std::isfinite(difference)) continue;
    sum += difference * difference;
    ++count;
  }
  if (count == 0) return std::nullopt;
  return std::sqrt(sum / static_cast<double>(count));
}

}  // namespace slipstream
