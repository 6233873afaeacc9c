#include "devices/dlp.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "base/throw_if-inl.h"
#include "devices/hid_port.h"

// Sections and tables are those of the programmer's guides DLPU010G (DLPC350), DLPU018J (DLPC900).
namespace slipstream::dlp {
namespace {

struct Command {
  std::string_view name;
  std::uint16_t usb;
  std::string_view fields;  ///< widths of the values, bytes; data may follow
};

// DLPU010G. "pattern table" defines the three patterns of a picture.
constexpr std::array dlpc350_commands{
    Command{"hardware status", 0x1A0A, "1"},           // 2.1.1
    Command{"main status", 0x1A0C, "1"},               // 2.1.3
    Command{"LED enable", 0x1A07, "1"},                // 2.3.7.1
    Command{"display mode", 0x1A1B, "1"},              // 2.4.1
    Command{"validation", 0x1A1A, "1"},                // 2.4.3.1
    Command{"trigger mode", 0x1A23, "1"},              // 2.4.3.2.1
    Command{"trigger output 1", 0x1A1D, "111"},        // 2.4.3.2.2
    Command{"trigger output 2", 0x1A1E, "11"},         // 2.4.3.2.3
    Command{"pattern source", 0x1A22, "1"},            // 2.4.3.4.1
    Command{"start or stop", 0x1A24, "1"},             // 2.4.3.4.2
    Command{"exposure and period", 0x1A29, "44"},      // 2.4.3.4.3
    Command{"pattern table control", 0x1A31, "1111"},  // 2.4.3.4.5
    Command{"pattern table offset", 0x1A32, "1"},      // 2.4.3.4.7
    Command{"pattern table access", 0x1A33, "1"},      // 2.4.3.4.8
    Command{"pattern table", 0x1A34, "333"},           // 2.4.3.4.9
};

// DLPU018J
constexpr std::array dlpc900_commands{
    Command{"hardware status", 0x1A0A, "1"},         // 2.1.1
    Command{"main status", 0x1A0C, "1"},             // 2.1.3
    Command{"hardware type", 0x0206, "1"},           // 2.1.5
    Command{"error code", 0x0100, "1"},              // 2.1.6
    Command{"LED enable", 0x1A07, "1"},              // 2.3.7.1
    Command{"display mode", 0x1A1B, "1"},            // 2.4.1
    Command{"trigger output 1", 0x1A1D, "122"},      // 2.4.4.1.1
    Command{"trigger output 2", 0x1A1E, "122"},      // 2.4.4.1.2
    Command{"start or stop", 0x1A24, "1"},           // 2.4.4.3.1
    Command{"pattern table control", 0x1A31, "24"},  // 2.4.4.3.3
    Command{"pattern order", 0x1A32, "242"},         // 2.4.4.3.4
    Command{"pattern table", 0x1A34, "231312"},      // 2.4.4.3.5
    Command{"picture", 0x1A2A, "24"},                // 2.4.4.4.1
    Command{"right picture", 0x1A2C, "24"},          // 2.4.4.4.1
    Command{"picture data", 0x1A2B, "2"},            // 2.4.4.4.2
    Command{"right picture data", 0x1A2D, "2"},      // 2.4.4.4.2
};

/// A micromirror chip.
struct Chip {
  const char* name;
  Size size;
  bool has_halves;
  std::array<int, 8> least_exposure;  ///< for 1 to 8 bits, us
};

// The DLPC350's, then the DLPC900's by hardware type (2.1.5). Exposures: table 4-1 of the
// LightCrafter 4500's user's guide, DLPU011F; DLPU018J table 2-110.
constexpr std::array chips{
    Chip{"DLP4500", {912, 1140}, false, {235, 700, 1570, 1700, 2000, 2500, 4500, 8333}},
    Chip{"DLP6500", {1920, 1080}, false, {105, 304, 394, 823, 1215, 1487, 1998, 4046}},
    Chip{"DLP9000", {2560, 1600}, true, {105, 304, 380, 733, 1215, 1487, 1998, 4046}},
    Chip{"DLP670S", {2716, 1600}, true, {100, 343, 438, 768, 1299, 1488, 2000, 4046}},
    Chip{"DLP500YX", {2048, 1200}, true, {62, 184, 269, 458, 682, 807, 1083, 2263}},
    Chip{"DLP5500", {1024, 768}, false, {94, 275, 356, 444, 972, 1517, 1877, 3753}},
};

constexpr std::uint8_t video = 0, video_patterns = 2, loaded_patterns = 3;  // display modes
constexpr int parked = 1, running = 2, locked = 8;                          // main status
constexpr std::uint32_t white = 7;                                          // LEDs

void append(std::vector<std::uint8_t>& bytes, std::size_t value, int width) {
  for (; width > 0; --width, value >>= 8) bytes.push_back(static_cast<std::uint8_t>(value));
}

/// In enhanced run-length encoding (2.4.3.2): repeats pixels, or copies the row above.
void append_row(std::vector<std::uint8_t>& bytes, const std::vector<std::uint32_t>& row,
                const std::vector<std::uint32_t>& above) {
  // Lengths below 128 take one byte; longer ones two, the first with its high bit set.
  const auto append_length = [&](std::size_t n) {
    append(bytes, n < 128 ? n : (n & 0x7f) | 0x80 | n >> 7 << 8, n < 128 ? 1 : 2);
  };

  if (row == above) {
    append(bytes, 0x0100, 2);
    return append_length(row.size());
  }

  for (auto at = row.begin(); at != row.end();) {
    // A run of equal pixels: its length, then the 24 bits of the pixel.
    const auto end = std::find_if(at, row.end(), [&](std::uint32_t p) { return p != *at; });
    append_length(static_cast<std::size_t>(end - at));
    for (const int shift : {16, 8, 0}) append(bytes, *at >> shift, 1);
    at = end;
  }
}

/// Up to 24 patterns as bits 0 to 23 of a picture with header (2.4.2): `width` columns from `left`.
std::vector<std::uint8_t> picture_of_bits(std::span<const Image<std::uint8_t>> patterns, int left,
                                          int width) {
  std::vector<std::uint8_t> runs, picture{0x53, 0x70, 0x6C, 0x64};  // signature
  std::vector<std::uint32_t> row, above;
  const int height = patterns[0].height();

  // Encode row by row: pattern k gives bit k of each pixel, set from grey level 128 on.
  for (int y = 0; y < height; ++y, std::swap(row, above)) {
    row.assign(static_cast<std::size_t>(width), 0);
    for (std::size_t k = 0; k < patterns.size(); ++k) {
      int x = left;
      for (std::uint32_t& pixel : row) pixel |= std::uint32_t{patterns[k](x++, y)} >> 7 << k;
    }
    append_row(runs, row, above);
  }

  append(runs, 0x000100, 3);  // end of picture
  // Padded to a multiple of 4 bytes.
  runs.resize((runs.size() + 3) / 4 * 4);

  // The header has 48 bytes.
  append(picture, static_cast<std::size_t>(width), 2);
  append(picture, static_cast<std::size_t>(height), 2);
  append(picture, runs.size(), 4);
  picture.insert(picture.end(), 8, 0xff);
  append(picture, 0, 5);        // black background
  append(picture, 0x0102, 23);  // enhanced run-length encoding

  picture.insert(picture.end(), runs.begin(), runs.end());
  return picture;
}

}  // namespace

DlpSink::DlpSink(OpenedController opened, PatternSink* screen, DlpSettings settings)
    : is_dlpc350_(opened.first == Controller::dlpc350),
      port_(std::move(opened.second)),
      screen_(screen),
      settings_(std::move(settings)) {
  throw_if(screen == nullptr && is_dlpc350_, "a DLPC350 takes no patterns over USB; drop `binary`");

  // The chip, whose size the screen must have.
  const std::size_t type = is_dlpc350_ ? 0 : read("hardware type");
  if (type >= chips.size()) throw WorldError("the DLPC900 has an unknown chip");
  const Chip& chip = chips[type];
  size_ = chip.size;
  has_halves_ = chip.has_halves;
  throw_if(screen != nullptr && screen->size() != size_,
           "a {} requires a monitor of {}; change its resolution", chip.name, text_of(size_));

  // 3 % of a refresh: the black after the last pattern, and rounded refresh rates.
  const double us = (screen != nullptr ? 0.97e6 / 3 : 1e6) / settings_.rate;
  // 7 bits if the time is too short for 8.
  if (screen != nullptr) bits_ = us < chip.least_exposure[7] ? 7 : 8;
  const int least = chip.least_exposure.at(bits_ - 1);
  throw_if(!(us >= least && us < 1 << 24),
           "{:.4g} per second: {:.0f} us for a pattern of {} bits, but a {} requires {} us",
           settings_.rate, us, bits_, chip.name, least);

  us_ = static_cast<std::uint32_t>(us);
  description_ = fmt::format("{}, {} bits, {} us per pattern", chip.name, bits_, us_);

  if ((read("main status") & parked) != 0) throw WorldError("the projector is in standby");
}

/// Sends a command (1.2.1): a read command, or a write command with values and data. Returns the
/// data of the answer.
DlpSink::Bytes DlpSink::exchange(std::string_view name, bool is_read, const Values& values,
                                 const Bytes& data) {
  // 1. Look up the command; its values have `width` bytes in total.
  const Command* command = is_dlpc350_ ? dlpc350_commands.data() : dlpc900_commands.data();
  while (command->name != name) ++command;

  const auto failure = [&](std::string_view what) {
    return WorldError(fmt::format("projector: {} (0x{:04X}) {}", name, command->usb, what));
  };

  std::ptrdiff_t width = 0;
  for (const char field : command->fields) width += field - '0';

  // 2. Packet: flags (0x80: read, 0x40: answer wanted), sequence number, length, command, values.
  Bytes sent{static_cast<std::uint8_t>(is_read ? 0xC0 : 0x40), ++sequence_, 0, 0};
  append(sent, command->usb, 2);
  for (std::size_t i = 0; i < values.size(); ++i) append(sent, values[i], command->fields[i] - '0');
  sent.insert(sent.end(), data.begin(), data.end());
  sent[2] = static_cast<std::uint8_t>(sent.size() - 4);
  sent[3] = static_cast<std::uint8_t>((sent.size() - 4) >> 8);

  // 3. Send it in reports of 64 bytes, and wait for its answer. After two commands without one,
  // the rest fail at once instead of each waiting for the timeout.
  std::optional<HidPort::Report> answer;
  if (unanswered_ < 2) {
    HidPort::Report report;
    sent.resize((sent.size() + report.size() - 1) / report.size() * report.size());
    for (auto at = sent.begin(); at != sent.end(); at += std::ssize(report)) {
      std::copy_n(at, report.size(), report.begin());
      port_->write(report);
    }

    int stale = 0;  // answers to earlier commands
    do answer = port_->read(settings_.timeout);
    while (answer && (*answer)[1] != sequence_ && ++stale < 16);
  }

  // 4. Judge the answer.
  unanswered_ = answer && (*answer)[1] == sequence_ ? 0 : unanswered_ + 1;
  if (unanswered_ > 0) throw failure("is not answered");

  // Bit 5: the controller reports an error.
  if (((*answer)[0] & 0x20) != 0) {
    if (is_dlpc350_ || name == "error code") throw failure("is refused");
    throw failure(fmt::format("is refused: error {}, see DLPU018 2.1.6", read("error code")));
  }

  if (is_read && (*answer)[2] + 256 * (*answer)[3] < width) throw failure("has a short answer");

  return {answer->begin() + 4, answer->begin() + 4 + width};
}

void DlpSink::change(const char* setting, const Values& values) {
  found_.emplace_back(setting, exchange(setting, true, {}, {}));
  write(setting, values);
}

void DlpSink::await(const char* command, int mask, int wanted, const char* failure) {
  // 150 polls: 3 s at the default interval of 20 ms.
  for (int polls = 0; polls < 150; ++polls) {
    if ((read(command) & mask) == wanted) return;
    std::this_thread::sleep_for(settings_.poll);
  }

  throw WorldError(
      fmt::format("the projector {}; hardware status 0x{:02X}", failure, read("hardware status")));
}

void DlpSink::enter(std::uint8_t mode) {
  // Remember the mode and stop a running sequence.
  const std::uint8_t found = read("display mode") & 3;
  found_.emplace_back("display mode", Bytes{found});
  if (found != video) {
    write("start or stop", {0});
    await("main status", running, 0, "does not stop");
  }

  if (mode == video_patterns) {  // 2.4.1: only from video with a locked source
    if (found != video) write("display mode", {video});
    await("main status", locked, locked, "receives no picture");
  }

  write("display mode", {mode});
  await("display mode", 3, mode, "does not change its mode");
  change("LED enable", {8});  // by the sequence
}

void DlpSink::define_on_dlpc350() {
  constexpr std::uint32_t no_delay = 0xBB, waits = 1, goes_on = 3;

  change("pattern source", {0});
  change("pattern table control", {2, 1, 2, 0});  // 3 entries, repeated; trigger output 2 every 3
  change("trigger mode", {0});
  change("exposure and period", {us_, us_});
  change("trigger output 1", {0, no_delay, 0});  // falls 20 us before the pattern ends
  change("trigger output 2", {0, no_delay});

  // Tables 2-69, 2-70: red is pattern 1, green 0, blue 2. The first waits for a refresh and swaps
  // buffers; black follows the last.
  const auto entry = [&](std::uint32_t trigger, std::uint32_t pattern, std::uint32_t flags) {
    return trigger | pattern << 2 | bits_ << 8 | white << 12 | flags << 16;
  };

  // Open the table, write it, close it.
  write("pattern table access", {2});
  write("pattern table offset", {0});
  write("pattern table", {entry(waits, 1, 4), entry(goes_on, 0, 0), entry(goes_on, 2, 2)});
  write("pattern table access", {0});

  // The controller checks the timing: bit 7 is set meanwhile, bits 0 and 1 report errors.
  write("validation", {0});
  await("validation", 0x80, 0, "does not finish validation");
  await("validation", 3, 0, "rejects the exposure or the patterns");
}

void DlpSink::define_on_dlpc900(std::size_t count) {
  constexpr std::array<std::uint32_t, 3> first_bits{8, 0, 16};  // red, green, blue in video

  change("trigger output 1", {0, 0, 0});
  change("trigger output 2", {0, 0, 20});  // 20 us at the start of each pattern

  for (std::uint32_t n = 0; n < count; ++n) {
    // A pattern on the screen is a channel of a picture, else a bit of a loaded one, 24 in each.
    const bool in_video = screen_ != nullptr;
    const std::uint32_t waits = in_video && n == 0 ? 0x80 : 0;
    const std::uint32_t bit = in_video ? first_bits[n] + 8 - bits_ : n % 24;
    const std::uint32_t picture = in_video ? 0 : n / 24;

    write("pattern table",
          {n, us_, (bits_ - 1) << 1 | white << 4 | waits, 0, 0, picture | bit << 11});
  }

  write("pattern table control", {static_cast<std::uint32_t>(count), 0});
}

void DlpSink::load_picture(std::span<const Image<std::uint8_t>> patterns, std::size_t n,
                           bool right) {
  // Two controllers drive one half each.
  const int width = size_.width / (has_halves_ ? 2 : 1);
  const Bytes picture = picture_of_bits(patterns, right ? width : 0, width);
  const auto length = static_cast<std::uint32_t>(picture.size());

  write(right ? "right picture" : "picture", {static_cast<std::uint32_t>(n), length});

  for (auto at = picture.begin(); at != picture.end();) {
    throw_if(settings_.ends(), "stopped before the patterns were loaded");
    // 504 bytes of data fit into a command.
    const auto end = at + std::min<std::ptrdiff_t>(504, picture.end() - at);
    write(right ? "right picture data" : "picture data", {static_cast<std::uint32_t>(end - at)},
          {at, end});
    at = end;
  }
}

void DlpSink::load(std::vector<Image<std::uint8_t>> patterns) {
  if (screen_ != nullptr) return screen_->load(std::move(patterns));

  require_patterns(patterns, size_, description_);
  throw_if(patterns.size() > 400, "{} patterns; a DLPC900 stores 400", patterns.size());

  give_back();
  enter(loaded_patterns);
  define_on_dlpc900(patterns.size());
  for (std::size_t n = (patterns.size() + 23) / 24; n-- > 0;) {  // 2.4.4.4.1: last first
    const auto rest = std::span(patterns).subspan(24 * n);
    const auto bits = rest.first(std::min<std::size_t>(24, rest.size()));
    load_picture(bits, n, false);
    if (has_halves_) load_picture(bits, n, true);
  }
}

void DlpSink::show(std::size_t n) {
  ++shown_;

  if (screen_ == nullptr) {
    write("start or stop", {0});
    write("pattern order", {1, 0, static_cast<std::uint32_t>(n)});
    return loop();
  }

  screen_->show(n);
  // The controller is set up at the first picture only, since it needs a source to lock on to.
  if (!found_.empty()) return;

  enter(is_dlpc350_ ? 1 : video_patterns);
  if (is_dlpc350_) {
    define_on_dlpc350();
  } else {
    define_on_dlpc900(3);
  }
  loop();
}

void DlpSink::loop() {
  write("start or stop", {2});
  await("main status", running, running, "does not start");
}

std::string DlpSink::restore() {
  std::string failure;
  // Stop first, then restore the settings, the last changed first. A second try for each.
  if (!found_.empty()) found_.emplace_back("start or stop", Bytes{0});

  for (int tries = 0; !found_.empty();) {
    try {
      write(found_.back().first, {}, found_.back().second);
    } catch (const WorldError& error) {
      if (++tries == 1) continue;
      failure = error.what();
    }

    found_.pop_back();
    tries = 0;
  }

  return failure;
}

void DlpSink::give_back() {
  const std::string failure = restore();
  if (!failure.empty()) throw WorldError("the settings are not restored: " + failure);
}

}  // namespace slipstream::dlp
