#include "app/session_outputs.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/live_session.h"
#include "frames/pattern_windows.h"
#include "io/file.h"
#include "io/file_names.h"
#include "io/result_files.h"
#include "io/scan_folder.h"
#include "reconstruct/engine_setup.h"
#include "slipstream/scan_files.h"

namespace slipstream::app {
namespace {

constexpr const char* other_strategy = "the displayed frames do not match the selected strategy";

/// The maps of a session's clouds for PublishedRun; callable from any sink.
class CloudMaps {
 public:
  explicit CloudMaps(const LiveSession& session) : session_(session) {}

  Image<std::uint8_t> phase(const LiveCloud& cloud) {
    const std::lock_guard lock(mutex_);
    const auto frames = measure(cloud);
    if (!frames) return {};

    const double least = least_modulation(engine_->setup().settings, frames->full_scale());
    Image<std::uint8_t> phase(frames->size());

    // The wrapped phase, 0 to 2 pi, as grey levels 1 to 255; 0 stands for a pixel without a phase.
    std::transform(maps_.wrapped_phase.begin(), maps_.wrapped_phase.end(), maps_.modulation.begin(),
                   phase.begin(), [&](float angle, float modulation) {
                     const float step = angle * (255 / (2 * std::numbers::pi_v<float>));
                     if (!(modulation >= least) || !(step >= 0)) return std::uint8_t{0};
                     return static_cast<std::uint8_t>(1 + std::min(step, 254.0F));
                   });

    return phase;
  }

  std::optional<Uncertainty> uncertainty(const LiveCloud& cloud) {
    const std::lock_guard lock(mutex_);
    const auto frames = measure(cloud);
    if (!frames) return std::nullopt;
    return engine_->uncertainty(cloud.cloud, maps_, *frames);
  }

 private:
  /// The frames to make maps from; empty if they belong to another sequence than the current one.
  std::optional<FrameViews> measure(const LiveCloud& cloud) {
    // The engine is built again when the setup has changed since the last cloud.
    if (const std::uint64_t changes = session_.changes(); !engine_ || changes != changes_) {
      EngineSetup setup = session_.setup();
      sequence_ = setup.sequence;
      setup.sequence.motion = 0;
      if (session_.has_two_cameras()) {  // the points are not of one camera's phases
        setup.scanner = without_geometry(setup.scanner.camera.size, setup.scanner.projector.size,
                                         setup.scanner.photometry);
      }

      engine_.emplace(setup);
      changes_ = changes;
    }

    // A window with extra motion frames holds the cycle in its middle.
    if (*cloud.sequence != sequence_) return std::nullopt;
    const FrameViews cycle =
        middle_cycle(views_of(cloud.frames), cloud.first_pattern, sequence_.motion);
    const FrameViews& frames = engine_->merged(cycle);
    engine_->maps(frames, maps_);
    return frames;
  }

  const LiveSession& session_;
  std::mutex mutex_;  ///< guards all members below
  std::optional<Engine> engine_;
  std::uint64_t changes_ = 0;
  Sequence sequence_;  ///< of the windows, with their motion frames
  Maps maps_;
};

std::string trouble_of(const LiveSession& session) {
  const LivePipeline& pipeline = session.pipeline();
  if (pipeline.failure()) return "the pipeline has failed";
  const std::string state = pipeline.statistics().source_state;
  if (!state.empty()) return state;

  for (const SinkStatistics& sink : session.sinks()) {
    if (!sink.error.empty()) return fmt::format("{}: {}", sink.name, sink.error);
  }
  return pipeline.running() ? "" : "the source has ended";
}

/// Calls `act`; its Error names flags instead of settings, as everything that the program says.
template <class Act>
auto in_flags(const Act& act) {
  try {
    return act();
  } catch (const Error& error) {
    throw Error(with_flags(error.what()));
  }
}

}  // namespace

void LiveSession::open_sinks() {
  const Scanner scanner = setup().scanner;  // sinks may already change the setup
  std::shared_ptr<const FramePose> frame;
  if (const auto& wanted = wanted_frame(flags_.settings)) frame = frame_after({}, *wanted);

  for (std::string name : flags_.publish) {
    if (constexpr std::string_view to_file = "mcap:"; name.starts_with(to_file)) {
      name = fmt::format("{}{}", to_file, file_to_write(name.substr(to_file.size())));
    }

    const auto maps = std::make_shared<CloudMaps>(*this);
    PublishedRun run{
        .camera = scanner.camera,
        .frame = frame,
        .scanner = has_geometry(scanner) ? text_of(scanner) : std::string(),
        .has_points = has_geometry(scanner),
        .statistics =
            [this] {  // paths need not be UTF-8
              return document().dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
            },
        .trouble = [this] { return with_flags(trouble_of(*this)); },
        .save = [this] { return in_flags([&] { return save_newest(); }); },
        .phase = [maps](const LiveCloud& cloud) { return maps->phase(cloud); },
        .settings = [this] { return settings(); },
        .change = [this](const std::string& setting,
                         const std::string& value) { in_flags([&] { change(setting, value); }); },
        .limit = flags_.limit,
    };

    // Sigma needs the noise variance and the phases of one camera.
    if (scanner.photometry.noise_variance && !has_two_cameras()) {
      run.uncertainty = [maps](const LiveCloud& cloud) { return maps->uncertainty(cloud); };
    }

    publisher_.add(name, open_sink(name, std::move(run)));
  }
}

std::string LiveSession::file_to_write(const std::string& file) {
  if (!flags_.new_files || file == standard_output) return file;

  std::string free = new_files_.emplace_back(file).path().string();
  if (free != file) output_.say("{} already exists; writing {}", file, free);
  return free;
}

std::string LiveSession::save(const FrameViews& frames, const Sequence& of_frames,
                              const EngineSetup& setup) const {
  throw_if(has_two_cameras(),
           "with --second-camera nothing is saved while it runs; the last cloud is written by -o");
  throw_if(of_frames != setup.sequence, other_strategy);

  return save_in_new_folder(frames, setup, flags_.view.save_to,
                            remarks_about(pipeline_->statistics().findings));
}

std::string LiveSession::save_newest() {
  // One save per second is enough: a page's button may be pressed by several people.
  const std::lock_guard lock(saving_);
  throw_if(std::chrono::steady_clock::now() - saved_ < std::chrono::seconds(1),
           "saved a moment ago");

  const Pooled<LiveCloud> newest = pipeline_->newest();
  throw_if(!newest, "no cloud to save yet");

  std::string folder = save(views_of(newest->frames), *newest->sequence, setup());
  saved_ = std::chrono::steady_clock::now();
  return folder;
}

std::string save_in_new_folder(const FrameViews& frames, const EngineSetup& setup,
                               const std::string& parent, const std::vector<std::string>& remarks) {
  Sequence sequence = setup.sequence;
  throw_if(frames.count() != frame_count(sequence), other_strategy);

  sequence.projector = setup.scanner.projector.size;
  sequence.marker = false;
  const auto make_new_folder = [&] {
    return make_free_folder(path_named_by_time(parent, "scan", ""));
  };

  // Without a scanner only the frames are worth saving.
  if (!has_geometry(setup.scanner)) {
    require_as_taken(sequence.strategy);
    const fs::path folder = make_new_folder();
    save_scan(folder, frames, sequence);
    return folder.string();
  }

  Cloud cloud;
  Maps maps;
  Engine(setup).cloud_and_maps(frames, cloud, maps);
  const fs::path folder = make_new_folder();

  // Merged exposures are not frames as taken, so they are left out.
  if (!frames.merged()) save_scan(folder, frames, sequence, {.scanner = setup.scanner});
  write_results({.cloud = folder / "cloud.ply",
                 .depth = folder / "depth.tiff",
                 .coordinate = folder / "coordinate.tiff",
                 .phase = folder / "phase.tiff",
                 .modulation = folder / "modulation.tiff",
                 .mean = folder / "mean.tiff",
                 .preview = folder / "preview.png"},
                cloud, maps, {.remarks = remarks, .frame = setup.settings.clean.box_frame});
  return folder.string();
}

}  // namespace slipstream::app
