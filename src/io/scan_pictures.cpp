#include "io/scan_pictures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "base/statistics.h"
#include "base/throw_if-inl.h"
#include "io/image_file.h"
#include "io/scan_folder.h"
#include "slipstream/scan_files.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

/// Grey levels of 255 of each picture at places spread over it.
using SampledPictures = std::vector<std::vector<double>>;

SampledPictures sampled(const std::vector<fs::path>& pictures) {
  constexpr int places = 4096;

  SampledPictures levels;
  for (const fs::path& picture : pictures) {
    const FrameSet frame = read_frames({picture}).frames;
    const auto [width, height] = frame.size();
    std::vector<double>& of_picture = levels.emplace_back();

    frame.visit([&](const auto& views) {
      for (int i = 0; i < places; ++i) {
        const auto [x, y] = spread_place(i);
        const double level = views[0](static_cast<int>(x * width), static_cast<int>(y * height));
        of_picture.push_back(level * 255 / frame.full_scale());
      }
    });
  }

  return levels;
}

constexpr double picture_noise = 6;  // grey levels

/// Places whose levels differ by more than noise between some of the pictures; empty if too few.
std::vector<std::size_t> lit_places(const SampledPictures& levels) {
  constexpr double least_range = 4 * picture_noise;
  constexpr std::size_t fewest = 100;

  std::vector<std::size_t> lit;
  for (std::size_t i = 0; i < levels.front().size(); ++i) {
    double darkest = levels.front()[i], brightest = darkest;
    for (const std::vector<double>& picture : levels) {
      darkest = std::min(darkest, picture[i]);
      brightest = std::max(brightest, picture[i]);
    }
    if (brightest - darkest >= least_range) lit.push_back(i);
  }

  return lit.size() < fewest ? std::vector<std::size_t>() : lit;
}

/// Whether two pictures are equal at nearly all lit places.
bool are_equal(const std::vector<double>& a, const std::vector<double>& b,
               const std::vector<std::size_t>& lit) {
  constexpr double nearly_all = 0.95;
  const auto same = std::ranges::count_if(
      lit, [&](std::size_t i) { return std::abs(a[i] - b[i]) <= picture_noise; });
  return static_cast<double>(same) >= nearly_all * static_cast<double>(lit.size());
}

/// The pictures that are likely no pattern, by index, each with the reason: the brightest or the
/// darkest at nearly all lit places, or a repetition.
std::vector<std::pair<int, std::string>> likely_extra(const SampledPictures& levels) {
  const std::vector<std::size_t> lit = lit_places(levels);
  if (lit.empty()) return {};

  // 1. The darkest and the brightest level of each place over all pictures.
  std::vector<double> darkest = levels.front(), brightest = darkest;
  for (const std::vector<double>& picture : levels) {
    for (std::size_t i = 0; i < picture.size(); ++i) {
      darkest[i] = std::min(darkest[i], picture[i]);
      brightest[i] = std::max(brightest[i], picture[i]);
    }
  }

  // 2. Compares the pictures at the lit places. A pattern is neither the brightest nor the darkest
  // at nearly all of them, and no two patterns are equal.
  std::vector<std::pair<int, std::string>> extra;
  for (auto picture = levels.begin(); picture != levels.end(); ++picture) {
    const auto first = std::find_if(levels.begin(), picture, [&](const auto& before) {
      return are_equal(before, *picture, lit);
    });

    const int n = static_cast<int>(picture - levels.begin());

    if (are_equal(*picture, brightest, lit)) {
      extra.emplace_back(n, "white");
    } else if (are_equal(*picture, darkest, lit)) {
      extra.emplace_back(n, "black");
    } else if (first != picture) {
      extra.emplace_back(n, fmt::format("repeats frame {}", first - levels.begin()));
    }
  }

  return extra;
}

/// The first picture of each pattern if each was taken several times in a row; otherwise empty.
/// Judges the first patterns.
std::vector<int> first_of_repeats(const std::vector<fs::path>& pictures, int wanted) {
  constexpr int most_times = 16, judged_patterns = 3;
  const int count = static_cast<int>(pictures.size()), times = count / wanted;
  if (count % wanted != 0 || times < 2 || times > most_times) return {};

  const int judged = std::min(count, judged_patterns * times);
  const SampledPictures levels = sampled({pictures.begin(), pictures.begin() + judged});
  const std::vector<std::size_t> lit = lit_places(levels);
  if (lit.empty()) return {};

  // Equal to the picture before, unless it is the first of its pattern.
  for (std::size_t n = 1; n < levels.size(); ++n) {
    const bool is_first = n % static_cast<std::size_t>(times) == 0;
    if (are_equal(levels[n - 1], levels[n], lit) == is_first) return {};
  }

  std::vector<int> order;
  for (int pattern = 0; pattern < wanted; ++pattern) order.push_back(pattern * times);
  return order;
}

/// The frames of a strategy by their purpose, e.g. "10 bits + 2 references"; empty if they serve
/// several.
std::string parts_of(const Strategy& strategy) {
  const Layout& layout = strategy.layout();
  std::vector<std::string> parts;
  int rest = strategy.demodulation() ? -1 : layout.frames;

  const auto add = [&](std::size_t frames, const char* what) {
    if (frames > 0) parts.push_back(fmt::format("{} {}", frames, what));
    rest -= static_cast<int>(frames);
  };

  for (const StepRun& run : step_runs(layout)) add(static_cast<std::size_t>(run.steps), "steps");
  add(layout.single_frames.size(), "single frames");
  if (layout.code) {
    add(layout.code->frames.size(), "bits");
    add(layout.code->inverses.size(), "inverses");
    if (rest > 0) add(static_cast<std::size_t>(rest), "references");
  }
  return rest == 0 ? fmt::format("{}", fmt::join(parts, " + ")) : "";
}

/// What to try so that the sequence has `count` frames: "try `bits 8`". If no setting alone does
/// it, which ones to check.
std::string about_settings(const Sequence& sequence, int count) {
  constexpr std::array numbers{"steps", "low_steps", "bits", "carrier_steps"};
  constexpr int most = 64;

  // 1. The settings that may change the number of frames, with their values.
  std::vector<std::pair<std::string, std::string>> tried;
  for (const char* name : numbers) {
    for (int n = 1; n <= most; ++n) tried.emplace_back(name, std::to_string(n));
  }
  for (const char* reference : {"mean", "none", "white-black", "inverse"}) {
    tried.emplace_back("reference", reference);
  }
  for (const char* part : {"complementary", "pi_shift"}) {
    for (const char* value : {"false", "true"}) tried.emplace_back(part, value);
  }

  // 2. Those that the strategy has. The next value of a setting makes no fewer frames, so the first
  // with too many is the last that is tried: a strategy of a thousand frames takes long to make.
  const int present = frame_count(sequence);
  std::vector<std::string> fitting, known{"`strategy`"};
  std::string exceeded;
  for (const auto& [name, value] : tried) {
    if (name == exceeded) continue;
    try {
      const int frames = frame_count(changed(sequence, {.settings = {{name, value}}}));
      const std::string quoted = fmt::format("`{}`", name);
      if (frames != present && known.back() != quoted) known.push_back(quoted);
      if (frames > count) exceeded = name;
      if (frames == count) {
        fitting.push_back(value == "true"    ? quoted
                          : value == "false" ? fmt::format("`no_{}`", name)
                                             : fmt::format("`{} {}`", name, value));
      }
    } catch (const Error&) {  // not a setting or a value of this strategy
    }
  }

  // 3. Several periods have frames of their own.
  const StrategySettings settings = sequence.strategy.settings();
  const auto periods = settings.find("periods");
  const bool is_list =
      periods != settings.end() && periods->second.text().find(',') != std::string::npos;
  if (is_list) known.emplace_back("`periods`");

  if (!fitting.empty()) return fmt::format("try {}", fmt::join(fitting, " or "));
  return fmt::format("check {}", fmt::join(known, ", "));
}

/// Which pictures are too many, and what to do.
std::string about_surplus(const ScanFiles& files, int wanted) {
  constexpr int most_named = 8;  // more are several scans
  const std::vector<fs::path>& pictures = files.frames;
  const int count = static_cast<int>(pictures.size()), surplus = count - wanted;

  if (const std::vector<int> first = first_of_repeats(pictures, wanted); !first.empty()) {
    return fmt::format("{} too many: each pattern was taken {} times; try `order {}`, one of each",
                       surplus, count / wanted, fmt::join(first, ","));
  }

  const auto extra = surplus <= most_named ? likely_extra(sampled(pictures))
                                           : std::vector<std::pair<int, std::string>>();

  // An order is proposed only if exactly as many pictures are suspect as are too many.
  if (static_cast<int>(extra.size()) != surplus) {
    return fmt::format(
        "{} too many; leave them out with `order`, or {}{}", surplus,
        about_settings(files.sequence, count),
        count < 2 * wanted ? "" : "; reconstruct `windows :` takes them as a recording");
  }

  std::vector<int> order;
  std::vector<std::string> named;

  for (int n = 0; n < count; ++n) {
    if (named.size() < extra.size() && extra[named.size()].first == n) {
      named.push_back(fmt::format("{} ({})", n, extra[named.size()].second));
    } else {
      order.push_back(n);
    }
  }

  return fmt::format("{} too many, likely frame{} {}; try `order {}`", surplus,
                     surplus == 1 ? "" : "s", fmt::join(named, ", "), text_of_order(order));
}

/// Why the pictures are not as many as the patterns, and what to do.
std::string about_count(const ScanFiles& files, int wanted) {
  const Sequence& sequence = files.sequence;
  const int count = static_cast<int>(files.frames.size()), missing = wanted - count;

  // 1. The patterns of the scan. A code may have other bits along the other axis.
  const std::vector<int> along_axes = frames_along_axes(sequence);
  const bool once = along_axes.size() * sequence.exposures.size() == 1;
  std::string scan = sequence.strategy.name(), parts;
  if (along_axes.front() == along_axes.back()) parts = parts_of(sequence.strategy);

  if (sequence.both_axes) scan += " along both axes";
  if (sequence.exposures.size() > 1) {
    scan += fmt::format(" with {} exposures", sequence.exposures.size());
  }
  const std::string more =
      sequence.motion > 0 ? fmt::format(" + {} for motion", sequence.motion) : "";
  if (!parts.empty()) parts = fmt::format(" ({}{}{})", once ? "" : "each ", parts, more);

  // 2. The remedy.
  const std::string remedy =
      missing < 0 ? about_surplus(files, wanted)
                  : fmt::format("likely {} missing; or {}",
                                missing == 1 ? "a frame is" : fmt::format("{} frames are", missing),
                                about_settings(sequence, count));
  return fmt::format("{} frame{}, but {} has {}{}: {}", count, count == 1 ? "" : "s", scan, wanted,
                     parts, remedy);
}

/// Whether its name begins with a dot, as files left by desktops do: .DS_Store, ._frame.png.
bool is_hidden(const fs::path& path) {
  return path.filename().string().starts_with(".");
}

}  // namespace

std::vector<fs::path> pattern_pictures(const ScanFiles& files, int wanted) {
  const std::vector<fs::path>& pictures = files.frames;
  const int count = static_cast<int>(pictures.size());

  // Without an order, every picture is a pattern.
  if (count < wanted || (count > wanted && files.order.empty())) {
    throw Error(fmt::format("{}: {}", files.path.string(), about_count(files, wanted)));
  }

  if (files.order.empty()) return pictures;

  // The order must list as many different pictures as there are patterns.
  const std::set<int> chosen(files.order.begin(), files.order.end());
  throw_if(static_cast<int>(files.order.size()) != wanted ||
               static_cast<int>(chosen.size()) != wanted || *chosen.begin() < 0 ||
               *chosen.rbegin() >= count,
           "{}: `order {}` is not an order of its {} frames; list {} of 0 to {} once, separated by "
           "commas",
           files.path.string(), text_of_order(files.order), count,
           count == wanted ? "each" : std::to_string(wanted), count - 1);

  std::vector<fs::path> ordered;
  for (const int n : files.order) ordered.push_back(pictures[static_cast<std::size_t>(n)]);

  return ordered;
}

bool before_in_order(const fs::path& a, const fs::path& b) {
  // Prefixes each number with its number of digits.
  const auto key_of = [](const fs::path& path) {
    const std::string name = path.filename().string();
    constexpr const char* digits = "0123456789";
    std::vector<int> key;

    for (std::size_t i = 0; i < name.size();) {
      const std::size_t end = std::min(name.find_first_not_of(digits, i), name.size());
      if (end == i) {
        key.push_back(name[i++]);
        continue;
      }

      // Without leading zeros, more digits mean a larger number.
      i = std::min(name.find_first_not_of('0', i), end - 1);
      key.insert(key.end(), {'0', static_cast<int>(end - i)});
      key.insert(key.end(), name.begin() + static_cast<std::ptrdiff_t>(i),
                 name.begin() + static_cast<std::ptrdiff_t>(end));
      i = end;
    }

    return key;
  };

  // Names with equal numbers, such as 1 and 01, compare as paths.
  return std::pair(key_of(a), a) < std::pair(key_of(b), b);
}

bool is_scan_folder(const fs::path& folder) {
  return !is_hidden(folder) && !fs::exists(folder / "report.html");
}

std::vector<fs::path> images_in_folder(const fs::path& folder) {
  throw_if(!fs::is_directory(folder), "{}: no such folder", folder.string());

  std::vector<fs::path> images, jpegs;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (!entry.is_regular_file() || is_hidden(entry.path())) continue;
    if (is_image_file(entry.path())) images.push_back(entry.path());
    if (is_jpeg_file(entry.path())) jpegs.push_back(entry.path());
  }

  // A folder of lossless pictures may also contain JPEGs, such as photographs of the object.
  if (images.empty()) images = std::move(jpegs);
  throw_if(images.empty(), "{}: no pictures; expected PNG, TIFF, BMP, PGM or JPEG files",
           folder.string());

  std::ranges::sort(images, before_in_order);
  return with_pages(images);
}

}  // namespace slipstream
