#include "io/scan_folder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <optional>
#include <set>
#include <string_view>
#include <tuple>
#include <vector>

#include <yaml-cpp/yaml.h>

#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "frames/mosaic.h"
#include "io/file.h"
#include "io/image_file.h"
#include "io/unique_keys.h"
#include "io/yaml_map.h"
#include "slipstream/recording.h"
#include "slipstream/scan_files.h"
#include "slipstream/scanner_file.h"
#include "slipstream/strategy.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

/// The optional files named in scan.yaml, except the frames.
constexpr std::array<std::tuple<const char*, const char*, std::optional<fs::path> ScanFiles::*>, 4>
    named_files{{{"scanner", "a file", &ScanFiles::scanner},
                 {"white", "a picture", &ScanFiles::white},
                 {"colour_scanner", "a file", &ScanFiles::colour_scanner},
                 {"guard", "a folder", &ScanFiles::guard}}};

/// Keys of Sequence::lengths, and the settings that they replace.
constexpr std::array<std::pair<const char*, const char*>, 2> lengths{
    {{"period_pixels", "periods"}, {"stripe_pixels", "stripes"}}};

Strategy read_strategy(const YamlMap& map) {
  const std::set<std::string> others{"name",   "axis",   "alpha_p",       "beta_p",       "marker",
                                     "binary", "motion", "period_pixels", "stripe_pixels"};

  // All other keys are settings of the strategy; make_strategy refuses unknown ones.
  StrategySettings settings;
  for (const std::string& key : map.keys()) {
    if (others.contains(key)) continue;
    settings[key] = map.value<std::string>(key, "a number, numbers with commas or a word");
  }

  return make_strategy(map.value<std::string>("name", "the name of a strategy"), settings);
}

Sequence read_sequence(const YamlMap& map) {
  constexpr int largest_side = 65536;

  // 1. The strategy and the light of its patterns.
  const YamlMap strategy = map.map("strategy");
  Sequence sequence{.strategy = read_strategy(strategy)};
  strategy.read_number("alpha_p", sequence.light.alpha_p);
  strategy.read_number("beta_p", sequence.light.beta_p);
  require_valid(sequence.light);

  // 2. How the patterns are shown.
  strategy.read("marker", "true or false", sequence.marker);
  strategy.read("binary", "true or false", sequence.binary);

  for (const auto& [key, setting] : lengths) {
    if (!strategy.has(key)) continue;
    sequence.lengths[setting] = strategy.value<std::string>(key, "numbers with commas");
  }

  if (strategy.has("motion")) sequence.motion = strategy.whole_number("motion", 0, 16);

  std::string axes = "x";
  strategy.read("axis", "x, y or both", axes);
  set_axes(sequence, axes);

  // 3. The projector's size and the exposures, beside the strategy in the file.
  if (map.has("projector")) {
    const YamlMap projector = map.map("projector");
    projector.require_known_keys({"width", "height"});
    sequence.projector = {projector.whole_number("width", 1, largest_side),
                          projector.whole_number("height", 1, largest_side)};
  }

  if (map.has("exposures")) {
    sequence.exposures = map.list<double>("exposures", "numbers", "numbers");
  }

  require_mergeable(sequence);
  return sequence;
}

ScanFiles files_from(const YamlMap& map, const fs::path& folder) {
  map.require_known_keys({"slipstream", "strategy", "exposures", "projector", "bits", "frames",
                          "scanner", "white", "colour", "colour_scanner", "mosaic", "temperature",
                          "second_camera", "guard"});

  // Read only to refuse other versions of the file's layout.
  [[maybe_unused]] const int version = map.whole_number("slipstream", 1, 1);

  ScanFiles scan{.sequence = read_sequence(map)};
  if (map.has("bits")) scan.bits = map.whole_number("bits", 8, 16);

  // A path in the file is relative to its folder.
  for (const std::string& frame : map.list<std::string>("frames", "files", "a name")) {
    scan.frames.push_back(folder / frame);
  }

  for (const std::string& picture : map.list<std::string>("colour", "pictures", "a name")) {
    scan.colour.push_back(folder / picture);
  }
  throw_if(scan.colour.size() > 3 || scan.colour.size() == 2,
           "colour: expected one picture in colour, or three in red, green and blue light");
  if (map.has("mosaic")) scan.mosaic = mosaic_named(map.value<std::string>("mosaic", "a word"));

  map.read("temperature", "a map of numbers, e.g. {Sensor: 41.5}", scan.temperatures);
  for (const auto& [part, celsius] : scan.temperatures) {
    throw_if(part.empty() || !std::isfinite(celsius),
             "temperature: '{}: {}'; expected e.g. 'Sensor: 41.5'", part, celsius);
  }

  if (map.has("second_camera")) {
    for (const std::string& camera : map.one_or_list("second_camera", "folders", "a folder")) {
      scan.further_cameras.push_back(folder / camera);
    }
  }
  for (const auto& [key, wanted, file] : named_files) {
    if (!map.has(key)) continue;
    const fs::path path = map.value<std::string>(key, wanted);
    // A scanner may be two files, separated by a comma.
    const bool is_scanner = file == &ScanFiles::scanner || file == &ScanFiles::colour_scanner;
    scan.*file = is_scanner ? scanner_in(folder, path) : folder / path;
  }

  return scan;
}

/// Appends the order of one cycle of a strategy whose code, or whose sinusoids, come first.
void add_order_by_kind(bool code_first, const Strategy& strategy, std::vector<int>& order) {
  const int patterns = frame_count(strategy), begin = static_cast<int>(order.size());
  const std::vector<int> sinusoids = measuring_frames(strategy.layout());
  std::vector<int> shown(sinusoids);
  order.resize(order.size() + static_cast<std::size_t>(patterns));

  // `shown` lists the patterns in the order of capture: the sinusoids, then the code.
  for (int n = 0; n < patterns; ++n) {
    if (!std::binary_search(sinusoids.begin(), sinusoids.end(), n)) shown.push_back(n);
  }

  throw_if(sinusoids.empty() || shown.size() == sinusoids.size(),
           "`order` in words requires a strategy of sinusoids and a code; {} has only one of them",
           strategy.name());

  if (code_first) {
    std::rotate(shown.begin(), shown.begin() + static_cast<std::ptrdiff_t>(sinusoids.size()),
                shown.end());
  }

  // Inverts that order: this pattern is frame n.
  for (int n = 0; n < patterns; ++n) {
    const int pattern = shown[static_cast<std::size_t>(n)];
    order[static_cast<std::size_t>(begin + pattern)] = begin + n;
  }
}

/// The order if the code or the sinusoids come first in each cycle.
std::vector<int> order_by_kind(bool code_first, const Sequence& sequence) {
  std::vector<int> order;
  for (std::size_t i = 0; i < sequence.exposures.size(); ++i) {
    add_order_by_kind(code_first, sequence.strategy, order);
    if (!sequence.both_axes) continue;
    add_order_by_kind(code_first, along(sequence, across(sequence.axis)).strategy, order);
  }
  return order;
}

/// Keeps only the pictures of the window.
void keep_window(ScanFiles& files, const std::vector<fs::path>& pictures) {
  const std::uint64_t count = window_count(pictures.size(), files.sequence);
  throw_if(*files.window >= count,
           "{}: the recording has {} windows, counted from 0; window {} does not exist",
           files.path.string(), count, *files.window);

  // Windows begin one cycle apart; with motion frames, each reaches into the next one.
  const auto first = pictures.begin() + static_cast<std::ptrdiff_t>(*files.window) *
                                            frame_count(cycle_of(files.sequence));
  files.frames = std::vector<fs::path>(first, first + frame_count(files.sequence));
}

/// Writes a key and its value.
template <class... Value>
void put_value(YAML::Emitter& yaml, const std::string& key, const Value&... value) {
  yaml << YAML::Key << key << YAML::Value;
  (yaml << ... << value);
}

/// The strategy and how it is shown, the exposures and the projector.
void put_sequence(YAML::Emitter& yaml, const Sequence& sequence) {
  // 1. The strategy, in one line.
  put_value(yaml, "strategy", YAML::Flow, YAML::BeginMap);
  put_value(yaml, "name", sequence.strategy.name());
  for (const auto& [name, value] : sequence.strategy.settings()) {
    put_value(yaml, name, value.text());
  }

  // Along one axis, the setting itself gives the same patterns.
  for (const auto& [key, setting] : lengths) {
    if (sequence.both_axes && sequence.lengths.contains(setting)) {
      put_value(yaml, key, sequence.lengths.at(setting).text());
    }
  }

  put_value(yaml, "axis", std::string(axes_of(sequence)));
  put_value(yaml, "alpha_p", sequence.light.alpha_p);
  put_value(yaml, "beta_p", sequence.light.beta_p);

  // Defaults are left out.
  if (sequence.marker) put_value(yaml, "marker", true);
  if (sequence.binary) put_value(yaml, "binary", true);
  if (sequence.motion > 0) put_value(yaml, "motion", sequence.motion);
  yaml << YAML::EndMap;

  // 2. The exposures and the projector.
  if (sequence.exposures != Sequence{}.exposures) {
    put_value(yaml, "exposures", YAML::Flow, sequence.exposures);
  }

  const Size projector = sequence.projector;
  if (projector != Size{}) {
    put_value(yaml, "projector", YAML::Flow, YAML::BeginMap);
    put_value(yaml, "width", projector.width);
    put_value(yaml, "height", projector.height);
    yaml << YAML::EndMap;
  }
}

/// The files, named from the folder, and the bits of the frames.
void put_files(YAML::Emitter& yaml, const ScanFiles& scan, const fs::path& folder) {
  const auto name_of = [&](const fs::path& file) {
    return file.lexically_proximate(folder).string();
  };

  if (scan.bits != 0) put_value(yaml, "bits", scan.bits);

  if (!scan.frames.empty()) {
    put_value(yaml, "frames", YAML::BeginSeq);
    for (const fs::path& frame : scan.frames) yaml << name_of(frame);
    yaml << YAML::EndSeq;
  }

  if (!scan.mosaic.empty()) put_value(yaml, "mosaic", scan.mosaic);
  if (!scan.temperatures.empty()) {
    put_value(yaml, "temperature", YAML::Flow, scan.temperatures);
  }
  const auto put_names = [&](const char* key, const std::vector<fs::path>& files) {
    std::vector<std::string> names;
    for (const fs::path& file : files) names.push_back(name_of(file));
    put_value(yaml, key, YAML::Flow, names);
  };
  if (!scan.colour.empty()) put_names("colour", scan.colour);

  // One camera as earlier versions read it.
  const std::vector<fs::path>& cameras = scan.further_cameras;
  if (cameras.size() == 1) put_value(yaml, "second_camera", name_of(cameras.front()));
  if (cameras.size() > 1) put_names("second_camera", cameras);

  for (const auto& [key, wanted, file] : named_files) {
    if (scan.*file) put_value(yaml, key, name_of(*(scan.*file)));
  }
}

}  // namespace

ScanFiles read_scan_files(const fs::path& file) {
  ScanFiles scan = scan_files_from(read_text(file), file.string(), file.parent_path());
  scan.path = file.parent_path();
  scan.frames = with_pages(scan.frames);
  scan.described = true;

  throw_if(scan.frames.empty(), "{}: key 'frames' is missing", file.string());
  return scan;
}

ScanFiles scan_files_from(const std::string& text, const std::string& name,
                          const fs::path& folder) {
  return naming(name, [&] {
    try {
      return files_from(YamlMap(yaml_document(text)), folder);
    } catch (const YAML::Exception& exception) {
      throw Error(exception.msg);
    }
  });
}

void write_scan_files(const fs::path& file, const ScanFiles& scan) {
  write_file(file, scan_yaml_of(scan, file.parent_path()));
}

void require_as_taken(const Strategy& strategy) {
  throw_if(strategy.is_spectral() && !strategy.demodulation(),
           "the frames of {} were separated on reading and cannot be written as captured; copy the "
           "original scan",
           strategy.name());
}

std::string scan_yaml_of(const ScanFiles& scan, const fs::path& folder) {
  require_as_taken(scan.sequence.strategy);

  YAML::Emitter yaml;
  yaml << YAML::BeginMap;
  put_value(yaml, "slipstream", 1);
  put_sequence(yaml, scan.sequence);
  put_files(yaml, scan, folder);
  yaml << YAML::EndMap;

  return std::string(yaml.c_str()) + "\n";
}

std::string folder_of_camera(std::size_t number) {
  return number == 2 ? "second" : fmt::format("camera-{}", number);
}

std::vector<int> order_from(const std::string& text, const Sequence& sequence) {
  if (text == "sinusoids,code" || text == "code,sinusoids") {
    return order_by_kind(text.starts_with("code"), sequence);
  }

  constexpr int most = 100'000;  // frames in a folder
  std::vector<int> order;
  std::string_view rest = text;
  do {
    // A number, or a range such as 0-17.
    const std::vector<int> ends = numbers_in<int>(take_until(rest, ','), '-');
    const bool is_range =
        (ends.size() == 1 || ends.size() == 2) && ends.front() <= ends.back() && ends.back() < most;
    throw_if(!is_range || text.ends_with(','),
             "`order` '{}': expected numbers or ranges with commas between, e.g. 2,0,1 or 0-17, or "
             "sinusoids,code or code,sinusoids",
             text);

    throw_if(static_cast<std::size_t>(ends.back() - ends.front()) + order.size() >= most,
             "`order` '{}': more than {} frames", text, most);
    for (int frame = ends.front(); frame <= ends.back(); ++frame) order.push_back(frame);
  } while (!rest.empty());
  return order;
}

std::string text_of_order(const std::vector<int>& order) {
  constexpr std::ptrdiff_t most = 40;
  const bool is_cut = std::ssize(order) > most;
  const auto end = is_cut ? order.begin() + most : order.end();
  return fmt::format("{}{}", fmt::join(order.begin(), end, ","), is_cut ? ",..." : "");
}

void amend(ScanFiles& files, const ScanChanges& changes) {
  throw_if(!files.described && !changes.sequence.strategy,
           "{}: {}; set the pattern strategy with `strategy`", files.path.string(),
           files.frames.empty() ? "its patterns are unknown" : "no scan.yaml in it");

  // The order and the window depend on the changed sequence.
  files.sequence = changed(files.sequence, changes.sequence);
  if (!changes.order.empty()) files.order = order_from(changes.order, files.sequence);
  files.window = changes.window;
  if (files.window && !files.recording) {
    keep_window(files, changes.folder ? changes.folder->frames : files.frames);
  }

  files.bits = changes.bits.value_or(files.bits);
  throw_if(files.bits != 0 && (files.bits < 8 || files.bits > 16),
           "`camera_bits {}` is out of range; expected 8 to 16", files.bits);

  files.channel = changes.channel.value_or(files.channel);
  if (!changes.mosaic.empty()) files.mosaic = mosaic_named(changes.mosaic);
  if (changes.grey_patch) files.grey_patch = changes.grey_patch;
  if (changes.scanner) files.scanner = changes.scanner;
  if (changes.camera_region) files.camera_region = changes.camera_region;
  if (!changes.further_cameras.empty()) files.further_cameras = changes.further_cameras;
}

std::uint64_t window_count(std::size_t pictures, const Sequence& sequence) {
  const auto cycle = static_cast<std::uint64_t>(frame_count(cycle_of(sequence)));
  const auto motion = static_cast<std::uint64_t>(sequence.motion);

  // The last cycle counts only if its motion frames follow.
  return pictures < motion ? 0 : (pictures - motion) / cycle;
}

ScanFiles recorded_files(const fs::path& path, std::shared_ptr<const RecordingReader> recording) {
  const RecordingHeader& header = recording->header();
  ScanFiles files{.path = path,
                  .described = header.sequence.has_value(),
                  .sequence = header.sequence.value_or(Sequence{}),
                  .bits = header.format.bits,
                  .temperatures = header.temperatures,
                  .recording = std::move(recording)};

  if (header.scanner) files.scanner = path;
  return files;
}

}  // namespace slipstream
