#include "app/view_files.h"

#include "slipstream/error/error.h"
#include "slipstream/io/file.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/result_files.h"
#include "slipstream/io/saved_scan.h"
#include "slipstream/reconstruct/engine.h"
#include "slipstream/view/view_settings.h"

namespace slipstream::app {
namespace {

void draw(const view::ViewSource& source, const ViewFlags& flags, view::Surround surround,
          const char* name, const std::string& path, Output& output) {
  if (path.empty()) return;
  if (!source.newest()) {
    throw WorldError(fmt::format("{}: no cloud came that could be drawn", path));
  }
  write_picture(name, path,
                view::render_screen(source, view_settings_from(flags), size_from(flags), surround),
                output);
}

}  // namespace

std::string save_in_new_folder(const view::ShownCloud& shown, const EngineSetup& setup,
                               const ViewFlags& flags, const std::vector<std::string>& remarks) {
  Sequence sequence = setup.sequence;
  if (shown.frames.count() != frame_count(sequence)) {
    throw Error("the frames shown are not of the strategy looked for");
  }
  sequence.projector = setup.scanner.projector.size;
  sequence.marker = false;
  const std::filesystem::path folder = path_named_by_time(flags.save_to, "scan", "");
  if (!has_geometry(setup.scanner)) {
    save_scan(folder, shown.frames, sequence, std::nullopt);
    return folder.string();
  }
  Cloud cloud;
  Maps maps;
  Engine(setup).cloud_and_maps(shown.frames, cloud, maps);
  make_folder(folder);
  if (!shown.frames.merged()) save_scan(folder, shown.frames, sequence, setup.scanner);
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

void write_picture(const char* name, const std::string& path, const Image<Colour>& picture,
                   Output& output) {
  write_image(path, picture);
  output.say("{}: {}", name, path);
  output.object("files")[name] = path;
}

void write_snapshot(const view::ViewSource& source, const ViewFlags& flags, Output& output) {
  draw(source, flags, view::Surround::nothing, "snapshot", flags.snapshot, output);
}

void write_screenshot(const view::ViewSource& source, const ViewFlags& flags, Output& output) {
  draw(source, flags, view::Surround::panel, "screenshot", flags.screenshot, output);
}

}  // namespace slipstream::app
