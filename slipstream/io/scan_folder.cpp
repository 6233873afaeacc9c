#include "slipstream/io/scan_folder.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <initializer_list>
#include <set>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "slipstream/base/error.h"
#include "slipstream/base/numbers.h"
#include "slipstream/codes/registry.h"
#include "slipstream/io/file.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/recording.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

/// A map of scan.yaml, with errors that name the file and the key.
class YamlMap {
 public:
  YamlMap(YAML::Node node, std::string where) : node_(std::move(node)), where_(std::move(where)) {
    if (!node_.IsMap()) throw Error(fmt::format("{}: a map of keys is wanted", where_));
  }

  void require_known_keys(std::initializer_list<std::string_view> known) const {
    for (const auto& entry : node_) {
      const auto key = entry.first.as<std::string>();
      if (std::find(known.begin(), known.end(), key) == known.end()) {
        throw Error(fmt::format("{}: key '{}' is not known; there are: {}", where_, key,
                                fmt::join(known, ", ")));
      }
    }
  }

  [[nodiscard]] bool has(const std::string& key) const { return node_[key].IsDefined(); }

  [[nodiscard]] YAML::Node required(const std::string& key) const {
    if (!has(key)) throw Error(fmt::format("{}: key '{}' is missing", where_, key));
    return node_[key];
  }

  [[nodiscard]] YamlMap map(const std::string& key) const {
    return {required(key), fmt::format("{}: {}", where_, key)};
  }

  template <class Value>
  [[nodiscard]] Value value(const std::string& key, const char* wanted) const {
    return convert<Value>(required(key), key, wanted);
  }

  template <class Value>
  [[nodiscard]] Value value_or(const std::string& key, const Value& otherwise,
                               const char* wanted) const {
    return has(key) ? value<Value>(key, wanted) : otherwise;
  }

  [[nodiscard]] double number(const std::string& key) const {
    const auto number = value<double>(key, "a number");
    if (!std::isfinite(number)) {
      throw Error(fmt::format("{}: {} is {}; it must be finite", where_, key, number));
    }
    return number;
  }

  [[nodiscard]] int whole_number(const std::string& key, int least, int most) const {
    const int number = value<int>(key, "a whole number");
    if (number < least || number > most) {
      throw Error(
          fmt::format("{}: {} {} is out of range; {} to {}", where_, key, number, least, most));
    }
    return number;
  }

  template <class Value>
  [[nodiscard]] std::vector<Value> list(const std::string& key, const char* of,
                                        const char* wanted) const {
    const YAML::Node list = required(key);
    std::vector<Value> values;
    if (list.IsSequence()) {
      for (const auto& item : list) values.push_back(convert<Value>(item, key, wanted));
    }
    if (values.empty()) throw Error(fmt::format("{}: {} is not a list of {}", where_, key, of));
    return values;
  }

  [[nodiscard]] std::vector<std::string> keys() const {
    std::vector<std::string> keys;
    for (const auto& entry : node_) keys.push_back(entry.first.as<std::string>());
    return keys;
  }

 private:
  template <class Value>
  [[nodiscard]] Value convert(const YAML::Node& node, const std::string& key,
                              const char* wanted) const {
    try {
      return node.as<Value>();
    } catch (const YAML::Exception&) {
      throw Error(fmt::format("{}: {} is not {}", where_, key, wanted));
    }
  }

  YAML::Node node_;
  std::string where_;
};

YamlMap parse(const std::string& text, const std::string& name) {
  try {
    return {YAML::Load(text), name};
  } catch (const YAML::Exception& exception) {
    throw Error(
        fmt::format("{}: line {}: not YAML: {}", name, exception.mark.line + 1, exception.msg));
  }
}

Strategy read_strategy(const YamlMap& map) {
  const std::set<std::string> others{"name",   "axis",   "alpha_p", "beta_p",
                                     "marker", "binary", "motion"};
  StrategySettings settings;
  for (const std::string& key : map.keys()) {
    if (others.contains(key)) continue;
    settings[key] = map.value<std::string>(key, "a number, numbers with commas or a word");
  }
  return make_strategy(map.value<std::string>("name", "the name of a strategy"), settings);
}

PatternLight read_light(const YamlMap& map) {
  PatternLight light;
  if (map.has("alpha_p")) light.alpha_p = map.number("alpha_p");
  if (map.has("beta_p")) light.beta_p = map.number("beta_p");
  require_valid(light);
  return light;
}

ScanFiles interpret(const YamlMap& map, const fs::path& folder) {
  constexpr int largest_picture = 65536;
  map.require_known_keys({"slipstream", "strategy", "exposures", "projector", "bits", "frames",
                          "scanner", "white", "second_camera"});
  [[maybe_unused]] const int version = map.whole_number("slipstream", 1, 1);

  ScanFiles scan;
  const YamlMap strategy = map.map("strategy");
  scan.sequence = {.strategy = read_strategy(strategy),
                   .light = read_light(strategy),
                   .marker = strategy.value_or("marker", false, "true or false"),
                   .binary = strategy.value_or("binary", false, "true or false"),
                   .motion = strategy.has("motion") ? strategy.whole_number("motion", 0, 16) : 0};
  set_axes(scan.sequence, strategy.value_or<std::string>("axis", "x", "x, y or both"));
  if (map.has("projector")) {
    const YamlMap projector = map.map("projector");
    projector.require_known_keys({"width", "height"});
    scan.sequence.projector = {projector.whole_number("width", 1, largest_picture),
                               projector.whole_number("height", 1, largest_picture)};
  }
  if (map.has("exposures"))
    scan.sequence.exposures = map.list<double>("exposures", "numbers", "numbers");
  require_mergeable(scan.sequence);
  if (map.has("bits")) scan.bits = map.whole_number("bits", 8, 16);
  if (map.has("frames")) {
    for (const std::string& name : map.list<std::string>("frames", "files", "a name"))
      scan.frames.push_back(folder / name);
  }
  if (map.has("scanner")) scan.scanner = folder / map.value<std::string>("scanner", "a file");
  if (map.has("white")) scan.white = folder / map.value<std::string>("white", "a picture");
  if (map.has("second_camera")) {
    scan.second_camera = folder / map.value<std::string>("second_camera", "a folder");
  }
  return scan;
}

ScanFiles recorded_files(const fs::path& path, std::shared_ptr<const RecordingReader> recording) {
  const RecordingHeader& header = recording->header();
  ScanFiles files{.path = path,
                  .described = header.sequence.has_value(),
                  .sequence = header.sequence.value_or(Sequence{}),
                  .bits = header.format.bits,
                  .recording = std::move(recording)};
  if (header.scanner) files.scanner = path;
  return files;
}

}  // namespace

bool before_in_order(const std::string& a, const std::string& b) {
  const auto is_digit = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; };
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (is_digit(a[i]) && is_digit(b[j])) {
      const auto number_at = [&](const std::string& text, std::size_t& position) {
        while (position + 1 < text.size() && text[position] == '0' && is_digit(text[position + 1]))
          ++position;
        const std::size_t start = position;
        while (position < text.size() && is_digit(text[position])) ++position;
        return std::string_view(text).substr(start, position - start);
      };
      const std::string_view m = number_at(a, i), n = number_at(b, j);
      if (m.size() != n.size()) return m.size() < n.size();
      if (m != n) return m < n;
    } else if (a[i] != b[j]) {
      return a[i] < b[j];
    } else {
      ++i;
      ++j;
    }
  }
  return std::pair(a.size() - i, a) < std::pair(b.size() - j, b);
}

ScanFiles read_scan_files(const fs::path& file) {
  ScanFiles scan = scan_files_from(read_text(file), file.string(), file.parent_path());
  scan.path = file.parent_path();
  scan.described = true;
  if (scan.frames.empty()) throw Error(fmt::format("{}: key 'frames' is missing", file.string()));
  return scan;
}

ScanFiles scan_files_from(const std::string& text, const std::string& name,
                          const fs::path& folder) {
  const YamlMap map = parse(text, name);
  try {
    return interpret(map, folder);
  } catch (const YAML::Exception& exception) {
    throw Error(fmt::format("{}: {}", name, exception.msg));
  } catch (const Error& error) {
    const std::string_view message = error.what();
    if (message.starts_with(name)) throw;
    throw Error(fmt::format("{}: {}", name, message));
  }
}

void write_scan_files(const fs::path& file, const ScanFiles& scan) {
  write_file(file, scan_yaml_of(scan, file.parent_path()));
}

void require_as_taken(const Strategy& strategy) {
  if (strategy.is_spectral() && !strategy.demodulation()) {
    throw Error(
        fmt::format("a scan of {} is written as it was taken, and these frames were taken apart as "
                    "they were read; copy the scan itself",
                    strategy.name()));
  }
}

std::string scan_yaml_of(const ScanFiles& scan, const fs::path& folder) {
  require_as_taken(scan.sequence.strategy);
  YAML::Emitter yaml;
  const auto put = [&](const std::string& key, const auto& value) {
    yaml << YAML::Key << key << YAML::Value << value;
  };
  const auto put_file = [&](const std::string& key, const std::optional<fs::path>& file) {
    if (file) put(key, file->lexically_proximate(folder).string());
  };
  yaml << YAML::BeginMap;
  put("slipstream", 1);
  yaml << YAML::Key << "strategy" << YAML::Value << YAML::Flow << YAML::BeginMap;
  const auto& [strategy, axis, light, projector, marker, exposures, binary, both_axes, motion] =
      scan.sequence;
  put("name", strategy.name());
  for (const auto& [name, value] : strategy.settings()) put(name, value.text());
  put("axis", std::string(axes_of(scan.sequence)));
  put("alpha_p", light.alpha_p);
  put("beta_p", light.beta_p);
  if (marker) put("marker", true);
  if (binary) put("binary", true);
  if (motion > 0) put("motion", motion);
  yaml << YAML::EndMap;
  if (exposures != Sequence{}.exposures) {
    yaml << YAML::Key << "exposures" << YAML::Value << YAML::Flow << exposures;
  }
  if (projector != Size{}) {
    yaml << YAML::Key << "projector" << YAML::Value << YAML::Flow << YAML::BeginMap;
    put("width", projector.width);
    put("height", projector.height);
    yaml << YAML::EndMap;
  }
  if (scan.bits != 0) put("bits", scan.bits);
  if (!scan.frames.empty()) {
    yaml << YAML::Key << "frames" << YAML::Value << YAML::BeginSeq;
    for (const fs::path& frame : scan.frames) yaml << frame.lexically_proximate(folder).string();
    yaml << YAML::EndSeq;
  }
  put_file("scanner", scan.scanner);
  put_file("white", scan.white);
  put_file("second_camera", scan.second_camera);
  yaml << YAML::EndMap;
  return std::string(yaml.c_str()) + "\n";
}

namespace {

/// Of frames whose code or sinusoids come first, in each showing of all patterns.
std::vector<int> order_by_kind(bool code_first, const Sequence& sequence) {
  const int patterns = frame_count(sequence.strategy);
  const std::vector<int> sinusoids = measuring_frames(sequence.strategy.layout());
  std::vector<int> shown(sinusoids), order(static_cast<std::size_t>(frame_count(sequence)));
  for (int n = 0; n < patterns; ++n) {
    if (!std::binary_search(sinusoids.begin(), sinusoids.end(), n)) shown.push_back(n);
  }
  if (sinusoids.empty() || shown.size() == sinusoids.size()) {
    throw Error(
        fmt::format("--order in words is for frames of sinusoids and of a code; {} has one "
                    "of them alone",
                    sequence.strategy.name()));
  }
  if (code_first) {
    std::rotate(shown.begin(), shown.begin() + static_cast<std::ptrdiff_t>(sinusoids.size()),
                shown.end());
  }
  for (int n = 0; n < frame_count(sequence); ++n) {
    const int pattern = shown[static_cast<std::size_t>(n % patterns)];
    order[static_cast<std::size_t>(n - n % patterns + pattern)] = n;
  }
  return order;
}

std::vector<int> order_from(const std::string& text, const Sequence& sequence) {
  if (text == "sinusoids,code" || text == "code,sinusoids") {
    return order_by_kind(text.starts_with("code"), sequence);
  }
  std::vector<int> order = numbers_in<int>(text, ',');
  if (order.empty()) {
    throw Error(
        fmt::format("--order {} is no order; give numbers with commas between, as 2,0,1, "
                    "or sinusoids,code or code,sinusoids",
                    text));
  }
  return order;
}

}  // namespace

void amend(ScanFiles& files, const ScanChanges& changes) {
  if (!files.described && !changes.sequence.strategy) {
    throw Error(fmt::format(
        "{}: {}; say what the frames show with --strategy", files.path.string(),
        files.frames.empty() ? "does not say what patterns it shows" : "no scan.yaml in it"));
  }
  files.sequence = changed(files.sequence, changes.sequence);
  if (!changes.order.empty()) files.order = order_from(changes.order, files.sequence);
  files.window = changes.window;
  files.bits = changes.bits.value_or(files.bits);
  if (files.bits != 0 && (files.bits < 8 || files.bits > 16)) {
    throw Error(fmt::format("--camera-bits {} is out of range; 8 to 16", files.bits));
  }
  if (changes.scanner) files.scanner = changes.scanner;
}

ScanFiles scan_files_in(const fs::path& path, const ScanChanges& changes) {
  ScanFiles files;
  if (changes.recording || is_recording(path)) {
    files = recorded_files(path, changes.recording ? changes.recording
                                                   : std::make_shared<const RecordingReader>(path));
  } else if (!fs::is_directory(path)) {
    throw Error(fmt::format("{}: {}; a scan folder or a recording is wanted", path.string(),
                            fs::exists(path) ? "is neither" : "no such folder or file"));
  } else if (fs::exists(path / "scan.yaml")) {
    files = read_scan_files(path / "scan.yaml");
  } else {
    files.path = path;
    files.frames = images_in_folder(path);
  }
  amend(files, changes);
  return files;
}

bool is_hidden(const fs::path& path) {
  return path.filename().string().starts_with(".");
}

std::vector<fs::path> images_in_folder(const fs::path& folder) {
  if (!fs::is_directory(folder)) {
    throw Error(fmt::format("{}: no such folder", folder.string()));
  }
  std::vector<fs::path> images;
  bool jpeg = false;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (!entry.is_regular_file() || is_hidden(entry.path())) continue;
    if (is_image_file(entry.path())) images.push_back(entry.path());
    const std::string ending = lower_case_extension(entry.path());
    jpeg = jpeg || ending == ".jpg" || ending == ".jpeg";
  }
  if (images.empty()) {
    throw Error(fmt::format(
        "{}: {}; PNG, TIFF, BMP or PGM files are wanted", folder.string(),
        jpeg ? "its pictures are JPEG, whose lossy compression spoils the phase" : "no pictures"));
  }
  std::sort(images.begin(), images.end(), [](const fs::path& a, const fs::path& b) {
    return before_in_order(a.filename().string(), b.filename().string());
  });
  return images;
}

}  // namespace slipstream
