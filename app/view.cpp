#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/save_scan.h"
#include "app/scan_input.h"
#include "app/view_flags.h"
#include "slipstream/error/error.h"
#include "slipstream/io/cloud_file.h"
#include "slipstream/io/file.h"
#include "slipstream/io/image_file.h"
#include "slipstream/reconstruct/reconstructor.h"
#include "slipstream/view/viewer.h"

namespace slipstream::app {
namespace fs = std::filesystem;
namespace {

struct ViewPathFlags {
  std::string path;
  ScanInputFlags input;
  std::string of_scan;  ///< a flag given that is of scans alone; empty where there is none
  ViewFlags view;
};

Image<float> narrowed(const Image<double>& image) {
  Image<float> narrow(image.size());
  std::copy(image.begin(), image.end(), narrow.begin());
  return narrow;
}

FusedCloud narrowed(const Cloud& cloud) {
  FusedCloud narrow;
  narrow.x = narrowed(cloud.x);
  narrow.y = narrowed(cloud.y);
  narrow.z = narrowed(cloud.z);
  narrow.intensity = cloud.intensity;
  narrow.validity = cloud.validity;
  return narrow;
}

/// A share of its own in a value.
template <class Value>
Pooled<Value> pooled(Value value) {
  Pool<Value> pool(1, [&] { return std::move(value); });
  return pool.take();
}

template <class Pixel>
Pooled<Frame> pooled_frame(const ImageView<const Pixel>& image, int bits) {
  Image<Pixel> pixels(image.size());
  for (int row = 0; row < image.height(); ++row) {
    std::copy_n(image.row(row), image.width(), pixels.row(row));
  }
  Frame frame;
  frame.pixels = std::move(pixels);
  frame.bits = bits;
  return pooled(std::move(frame));
}

/// None of unquantised frames, which no camera gives.
std::vector<Pooled<Frame>> pooled_frames(const FrameSet& frames) {
  std::vector<Pooled<Frame>> all;
  frames.visit([&]<class Pixel>(const Frames<Pixel>& views) {
    if constexpr (!std::is_same_v<Pixel, double>) {
      for (const auto& image : views) all.push_back(pooled_frame<Pixel>(image, frames.bits()));
    }
  });
  return all;
}

Pooled<LiveCloud> still(const Cloud& cloud, std::vector<Pooled<Frame>> frames) {
  LiveCloud whole;
  whole.cloud = narrowed(cloud);
  whole.frames = std::move(frames);
  whole.finished = std::chrono::steady_clock::now();
  return pooled(std::move(whole));
}

view::ViewSource source_of_file(const std::string& path) {
  const Pooled<LiveCloud> cloud = still(read_cloud(path), {});
  view::ViewSource source;
  source.newest = [cloud] { return cloud; };
  return source;
}

/// A scan that is reconstructed again whenever something else is looked for in it.
class StillScan {
 public:
  StillScan(const fs::path& folder, const ScanInputFlags& flags, Output& output) {
    const ScanDescription described = describe(folder, flags);
    LoadedFrames loaded = read_frames(described.frames, described.bits);
    for (const std::string& warning : loaded.warnings) output.warn(warning);
    frames_ = std::move(loaded.frames);
    const GammaChoice gamma = choose_gamma(flags.gamma, described, frames_);
    const std::vector<std::uint8_t> text = read_file(*described.scanner);
    scanner_ = {.text = {text.begin(), text.end()},
                .name = described.scanner->string(),
                .photometry = flags.photometry,
                .gammas = {gamma, {}, choose_gamma("blind", described, frames_)}};
    const std::array labels{"as given", "none", "blind"};
    for (std::size_t i = 0; i < labels.size(); ++i) {
      gammas_.emplace_back(labels[i], scanner_.gammas[i].corrections);
    }
    scan_.scanner = scanner_for(described, frames_.size());
    scan_.strategy = described.strategy;
    scan_.axis = described.axis;
    scan_.settings.backend = Backend::fused;
    scan_.settings =
        settings_for(scan_.settings, described, gamma, photometry_for(described, flags));
    shares_ = pooled_frames(frames_);
    look_for(scan_);
  }

  void look_for(const LiveScan& scan) {
    newest_ =
        still(Reconstructor(scan.scanner, scan.strategy, scan.axis, scan.settings).cloud(frames_),
              shares_);
  }

  /// Borrows this.
  view::ViewSource source(const std::string& save_to) {
    view::ViewSource source;
    source.newest = [this] { return newest_; };
    source.scan = scan_;
    source.full_scale = frames_.full_scale();
    source.gammas = gammas_;
    source.change = [this](const LiveScan& scan) { look_for(scan); };
    if (!shares_.empty()) {
      source.save = [scanner = scanner_, save_to](const LiveCloud& cloud, const LiveScan& scan) {
        return save_scan(cloud, scan, scanner, save_to);
      };
    }
    return source;
  }

 private:
  FrameSet frames_;
  std::vector<Pooled<Frame>> shares_;
  LiveScan scan_;
  SavedScanner scanner_;
  std::vector<std::pair<std::string, PhaseCorrections>> gammas_;
  Pooled<LiveCloud> newest_;
};

void view_path(const ViewPathFlags& flags, Output& output) {
  require_good(flags.view);
  std::optional<StillScan> scan;
  const bool folder = fs::is_directory(flags.path);
  if (!folder && !flags.of_scan.empty() && fs::exists(flags.path)) {
    throw Error(fmt::format("{}: {} is of scan folders", flags.path, flags.of_scan));
  }
  if (folder) scan.emplace(flags.path, flags.input, output);
  view::ViewSource source = scan ? scan->source(flags.view.save_to) : source_of_file(flags.path);
  source.title = flags.path;
  const view::ViewSettings settings = view_settings_from(flags.view);
  const Size size = size_from(flags.view);
  output.document = {{"path", flags.path}, {"files", nlohmann::json::object()}};
  const auto write = [&](const char* name, const std::string& path, view::Surround surround) {
    if (path.empty()) return;
    write_image(path, view::render_screen(source, settings, size, surround));
    output.say("{}: {}", name, path);
    output.document["files"][name] = path;
  };
  write("snapshot", flags.view.snapshot, view::Surround::nothing);
  write("screenshot", flags.view.screenshot, view::Surround::panel);
  if (output.document["files"].empty()) {
    view::run_viewer(source, {.view = settings, .size = size});
  }
}

}  // namespace

void add_view(CLI::App& program, SharedFlags& shared, Command& chosen) {
  CLI::App* command =
      program.add_subcommand("view", "look at a cloud or a scan, in a window or as a picture");
  const auto flags = std::make_shared<ViewPathFlags>();
  command->add_option("path", flags->path, "a PLY file or a scan folder")->required();
  add_view_flags(*command, flags->view);
  const std::size_t before = command->get_options().size();
  add_scan_input_flags(*command, flags->input);
  std::vector<CLI::Option*> of_scans = command->get_options();
  of_scans.erase(of_scans.begin(), of_scans.begin() + static_cast<std::ptrdiff_t>(before));
  add_shared_flags(*command, shared);
  command->footer(
      "Examples:\n  slipstream view scan\n  slipstream view cloud.ply --colour depth --snapshot "
      "cloud.png --size 1920x1080\nDrag to turn, with the right button to move, wheel to zoom; "
      "Tab hides the panel, Esc closes.");
  command->callback([flags, of_scans, &chosen] {
    const auto given = std::find_if(of_scans.begin(), of_scans.end(),
                                    [](const CLI::Option* option) { return option->count() > 0; });
    if (given != of_scans.end()) flags->of_scan = (*given)->get_name();
    chosen = [flags](Output& output) { view_path(*flags, output); };
  });
}

}  // namespace slipstream::app
