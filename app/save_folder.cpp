#include "app/save_folder.h"

#include <filesystem>

#include "slipstream/base/error.h"
#include "slipstream/io/file.h"
#include "slipstream/io/result_files.h"
#include "slipstream/io/saved_scan.h"
#include "slipstream/reconstruct/engine.h"

namespace slipstream::app {

std::string save_in_new_folder(const FrameViews& frames, const EngineSetup& setup,
                               const std::string& parent, const std::vector<std::string>& remarks) {
  Sequence sequence = setup.sequence;
  if (frames.count() != frame_count(sequence)) {
    throw Error("the frames shown are not of the strategy looked for");
  }
  sequence.projector = setup.scanner.projector.size;
  sequence.marker = false;
  const std::filesystem::path folder = path_named_by_time(parent, "scan", "");
  if (!has_geometry(setup.scanner)) {
    save_scan(folder, frames, sequence, std::nullopt);
    return folder.string();
  }
  Cloud cloud;
  Maps maps;
  Engine(setup).cloud_and_maps(frames, cloud, maps);
  make_folder(folder);
  if (!frames.merged()) save_scan(folder, frames, sequence, setup.scanner);
  write_results({.cloud = folder / "cloud.ply",
                 .depth = folder / "depth.tiff",
                 .coordinate = folder / "coordinate.tiff",
                 .phase = folder / "phase.tiff",
                 .modulation = folder / "modulation.tiff",
                 .mean = folder / "mean.tiff",
                 .preview = folder / "preview.png"},
                cloud, maps, {.remarks = remarks});
  return folder.string();
}

}  // namespace slipstream::app
