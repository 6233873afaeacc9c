#pragma once

// A stand-in for DLP controllers: checks every byte against tables of the programmer's guides
// (DLPC350: DLPU010G, DLPC900: DLPU018J), answers, and refuses what the guides forbid.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "devices/hid_port.h"
#include "slipstream/error.h"

namespace slipstream::dlp {

using Bytes = std::vector<std::uint8_t>;
using Report = HidPort::Report;

/// What goes wrong at a command.
enum class Fault { none, refused, silent, unplugged, late, malformed };

struct GuideLine {
  int written;   ///< data bytes of a write command; -1: read only, -2: any number
  int answered;  ///< data bytes of the answer to a read command; -1: write only
  const char* section;
};

inline const std::map<int, GuideLine>& guide(Controller controller) {
  static const std::map<int, GuideLine> dlpu010{
      {0x1A0A, {-1, 1, "2.1.1"}},    {0x1A0C, {-1, 1, "2.1.3"}},    {0x1A07, {1, 1, "2.3.7.1"}},
      {0x1A1B, {1, 1, "2.4.1"}},     {0x1A1A, {1, 1, "2.4.3.1"}},   {0x1A23, {1, 1, "2.4.3.2.1"}},
      {0x1A1D, {3, 3, "2.4.3.2.2"}}, {0x1A1E, {2, 2, "2.4.3.2.3"}}, {0x1A22, {1, 1, "2.4.3.4.1"}},
      {0x1A24, {1, 1, "2.4.3.4.2"}}, {0x1A29, {8, 8, "2.4.3.4.3"}}, {0x1A31, {4, 4, "2.4.3.4.5"}},
      {0x1A32, {1, 1, "2.4.3.4.7"}}, {0x1A33, {1, 1, "2.4.3.4.8"}}, {0x1A34, {9, -1, "2.4.3.4.9"}}};
  static const std::map<int, GuideLine> dlpu018{
      {0x1A0A, {-1, 1, "2.1.1"}},      {0x1A0C, {-1, 1, "2.1.3"}},
      {0x0206, {-1, 32, "2.1.5"}},     {0x0100, {-1, 1, "2.1.6"}},
      {0x1A07, {1, 1, "2.3.7.1"}},     {0x1A1B, {1, 1, "2.4.1"}},
      {0x1A1D, {5, 5, "2.4.4.1.1"}},   {0x1A1E, {5, 5, "2.4.4.1.2"}},
      {0x1A24, {1, -1, "2.4.4.3.1"}},  {0x1A31, {6, 6, "2.4.4.3.3"}},
      {0x1A32, {8, -1, "2.4.4.3.4"}},  {0x1A34, {12, -1, "2.4.4.3.5"}},
      {0x1A2A, {6, -1, "2.4.4.4.1"}},  {0x1A2C, {6, -1, "2.4.4.4.1"}},
      {0x1A2B, {-2, -1, "2.4.4.4.2"}}, {0x1A2D, {-2, -1, "2.4.4.4.2"}}};
  return controller == Controller::dlpc350 ? dlpu010 : dlpu018;
}

inline std::uint32_t number_in(const Bytes& bytes, std::size_t from, std::size_t count) {
  std::uint32_t number = 0;
  for (std::size_t i = count; i-- > 0;) number = number << 8 | bytes.at(from + i);
  return number;
}

/// Decodes a picture in enhanced run-length encoding (2.4.2, 2.4.3.2) to 24-bit pixels.
inline Image<std::uint32_t> decoded(const Bytes& picture) {
  const Bytes head(picture.begin(), picture.begin() + 48), signature{0x53, 0x70, 0x6C, 0x64};
  const Size size{static_cast<int>(number_in(head, 4, 2)), static_cast<int>(number_in(head, 6, 2))};
  const Bytes reserved(head.begin() + 12, head.begin() + 20), rest(head.begin() + 20, head.end());
  Bytes usual(28);
  usual[5] = 2;  // enhanced
  usual[6] = 1;
  if (!std::equal(signature.begin(), signature.end(), head.begin()) || reserved != Bytes(8, 0xff) ||
      rest != usual || number_in(head, 8, 4) != picture.size() - 48 || picture.size() % 4 != 0) {
    throw Error("not a header of 2.4.2");
  }
  Image<std::uint32_t> image(size);
  std::size_t at = 48, pixel = 0;
  const auto length = [&] {
    const std::size_t low = picture.at(at++);
    return low < 128 ? low : (low & 0x7f) | static_cast<std::size_t>(picture.at(at++)) << 7;
  };
  const auto next = [&] {
    const std::uint32_t red = picture.at(at), green = picture.at(at + 1), blue = picture.at(at + 2);
    at += 3;
    return red << 16 | green << 8 | blue;
  };
  const auto put = [&](std::uint32_t value) {
    if (pixel >= image.pixel_count()) throw Error("too many pixels");
    image.begin()[pixel++] = value;
  };
  const auto width = static_cast<std::size_t>(size.width);
  for (;;) {
    if (picture.at(at) != 0) {
      const std::size_t n = length();
      const std::uint32_t value = next();
      for (std::size_t i = 0; i < n; ++i) put(value);
    } else if (picture.at(++at) == 1) {
      ++at;
      if (picture.at(at) == 0) break;
      for (std::size_t n = length(); n > 0; --n) put(image.begin()[pixel - width]);
    } else if (picture.at(at) == 0) {
      ++at;  // end of line
    } else {
      for (std::size_t n = length(); n > 0; --n) put(next());
    }
  }
  if (pixel != image.pixel_count()) throw Error("pixels are missing");
  return image;
}

class ControllerDouble {
 public:
  explicit ControllerDouble(Controller which, std::uint8_t chip = 1) : which_(which) {
    const bool is_350 = which == Controller::dlpc350;
    for (const auto& [usb, line] : guide(which)) {
      if (line.answered > 0) registers[usb] = Bytes(static_cast<std::size_t>(line.answered));
    }
    registers[0x1A0A] = {1};
    if (!is_350) registers[0x0206][0] = chip;
    registers[0x1A07] = {0x07};
    if (is_350) {
      registers[0x1A23] = {1};
      registers[0x1A22] = {3};
      registers[0x1A1D] = {2, 0xBB, 0xBC};
      registers[0x1A1E] = {2, 0xB0};
      registers[0x1A29] = {0x10, 0x40, 0, 0, 0x1A, 0x41, 0, 0};
      registers[0x1A31] = {5, 0, 5, 1};
    } else {
      registers[0x1A1D] = {1, 7, 0, 3, 0};
      registers[0x1A1E] = {1, 50, 0, 20, 0};
    }
    set_mode(0);
  }

  /// Starts in this display mode, with a running sequence.
  void set_mode(std::uint8_t mode) {
    registers[0x1A1B] = {mode};
    running = true;
  }

  std::unique_ptr<HidPort> port() {
    struct Port : HidPort {
      explicit Port(ControllerDouble& of) : device(of) {}
      void write(const Report& report) override { device.receive(report); }
      std::optional<Report> read(std::chrono::milliseconds) override { return device.send(); }
      ControllerDouble& device;
    };
    return std::make_unique<Port>(*this);
  }

  // State of the controller
  std::map<int, Bytes> registers;
  bool running = true, has_video = true, is_parked = false;
  std::vector<Bytes> lut;                                    ///< definitions
  std::map<std::pair<bool, std::uint32_t>, Bytes> pictures;  ///< by half (right) and index
  std::uint8_t verdict = 0;                                  ///< of the validation
  bool starts = true;

  // What goes wrong
  int fault_at = -1;  ///< command, from 0
  Fault fault = Fault::none;
  std::function<std::optional<Report>(const Report&)> answers{};  ///< replaces answers

  // What was received
  std::vector<std::string> reports;     ///< every report, hexadecimal, without the zeros at its end
  std::vector<std::string> violations;  ///< of the guides
  int commands = 0, reads = 0;

 private:
  void object(const std::string& what) { violations.push_back(what); }

  void receive(const Report& report) {
    if (gone_) throw WorldError("gone");
    auto last = report.end();
    while (last != report.begin() && *(last - 1) == 0) --last;
    reports.push_back(fmt::format("{:02X}", fmt::join(report.begin(), last, " ")));
    if (awaited_ == 0) {
      if (!queue_.empty()) object("an answer was not read");
      queue_.clear();
      if (report[0] != 0x40 && report[0] != 0xC0) object(fmt::format("flags {:02X}", report[0]));
      if (report[1] != static_cast<std::uint8_t>(sequence_ + 1)) object("sequence number");
      sequence_ = report[1];
      is_read_ = report[0] == 0xC0;
      payload_.clear();
      awaited_ = 4 + static_cast<std::size_t>(report[2] | report[3] << 8);
      if (awaited_ < 6 || awaited_ > 512) object("length");
    }
    const std::size_t part = std::min(awaited_, report.size());
    payload_.insert(payload_.end(), report.begin(),
                    report.begin() + static_cast<std::ptrdiff_t>(part));
    awaited_ -= part;
    if (std::any_of(report.begin() + static_cast<std::ptrdiff_t>(part), report.end(),
                    [](auto b) { return b != 0; })) {
      object("bytes after the command");
    }
    if (awaited_ == 0)
      execute(payload_.at(4) | payload_.at(5) << 8, Bytes(payload_.begin() + 6, payload_.end()));
  }

  std::optional<Report> send() {
    ++reads;
    if (gone_) throw WorldError("gone");
    if (answers) {
      Report usual{};
      if (!queue_.empty()) {
        usual = queue_.front();
        queue_.pop_front();
      }
      return answers(usual);
    }
    if (queue_.empty()) return std::nullopt;
    const Report report = queue_.front();
    queue_.pop_front();
    return report;
  }

  void execute(int usb, const Bytes& data) {
    const bool faulty = commands++ == fault_at;
    if (faulty && fault == Fault::unplugged) {
      gone_ = true;
      return;
    }
    bool refused = faulty && fault == Fault::refused;
    Bytes answer;
    const auto found = guide(which_).find(usb);
    if (found == guide(which_).end()) {
      object(fmt::format("unknown command {:04X}", usb));
      refused = true;
    } else if (is_read_) {
      if (!data.empty()) object("data in a read command");
      if (found->second.answered < 0) object(fmt::format("read of {:04X}", usb));
      answer = value_of(usb);
      refused |= answer.empty();
    } else {
      const int length = found->second.written;
      if (length != -2 && static_cast<int>(data.size()) != length)
        object(fmt::format("{:04X} with {} bytes", usb, data.size()));
      refused = refused || !accept(usb, data);
    }
    error_ = refused ? 6 : 0;
    if (faulty && fault == Fault::silent) return;
    Report report{};
    report[0] = static_cast<std::uint8_t>((is_read_ ? 0xC0 : 0x40) | (refused ? 0x20 : 0));
    report[1] = sequence_;
    report[2] = static_cast<std::uint8_t>(faulty && fault == Fault::malformed ? 0 : answer.size());
    std::copy(answer.begin(), answer.end(), report.begin() + 4);
    if (faulty && fault == Fault::late) {  // an answer to an earlier command comes first
      Report stale = report;
      stale[1] = static_cast<std::uint8_t>(sequence_ - 7);
      stale[4] ^= 0xff;
      queue_.push_back(stale);
    }
    queue_.push_back(report);
  }

  Bytes value_of(int usb) {
    if (usb == 0x1A0C) {
      const int flags = (is_parked ? 1 : 0) | (running ? 2 : 0) |
                        (which_ == Controller::dlpc900 && has_video && mode() == 0 ? 8 : 0);
      return {static_cast<std::uint8_t>(flags)};
    }
    if (usb == 0x0100) return {last_error_};
    if (usb == 0x1A1B && settling_ > 0) return --settling_, Bytes{before_};
    if (usb == 0x1A1A) return {static_cast<std::uint8_t>(busy_ > 0 ? (--busy_, 0x80) : verdict)};
    return registers[usb];
  }

  [[nodiscard]] std::uint8_t mode() const { return registers.at(0x1A1B).front(); }

  bool refuse(std::uint8_t code, const std::string& why) {
    last_error_ = code;
    object(why);
    return false;
  }

  bool accept(int usb, const Bytes& data) {
    return which_ == Controller::dlpc350 ? accept_350(usb, data) : accept_900(usb, data);
  }

  bool accept_350(int usb, const Bytes& data) {
    const bool patterns = mode() == 1;
    const bool is_setting = usb == 0x1A1D || usb == 0x1A1E || usb == 0x1A22 || usb == 0x1A23 ||
                            usb == 0x1A29 || usb == 0x1A31 || usb == 0x1A33 || usb == 0x1A34;
    if (is_setting && patterns && running) return refuse(0, fmt::format("{:04X} before stop", usb));
    if (is_setting) valid_ = false;
    if (usb == 0x1A1B) {
      if (data[0] > 1) return refuse(0, "display mode");
      if (patterns && running) return refuse(0, "mode changed before stop");
      before_ = mode();
      settling_ = 2;
      running = data[0] == 0;
    }
    if (usb == 0x1A24) {
      if (data[0] == 2 && (!patterns || !valid_)) return refuse(0, "start before validation");
      running = data[0] == 2 && starts;
      return true;
    }
    if (usb == 0x1A1A) {
      busy_ = 3;
      valid_ = (verdict & 3) == 0;
      return true;
    }
    if (usb == 0x1A34) {
      if (!patterns || registers[0x1A33] != Bytes{2} || registers[0x1A23] != Bytes{0} ||
          registers[0x1A22] != Bytes{0}) {
        return refuse(0, "pattern table before mode, source, trigger and access");  // 2.4.3.4.9
      }
      for (std::size_t i = 0; i < 9; i += 3)
        lut.emplace_back(data.begin() + static_cast<std::ptrdiff_t>(i),
                         data.begin() + static_cast<std::ptrdiff_t>(i) + 3);
      return true;
    }
    registers[usb] = data;
    return true;
  }

  bool accept_900(int usb, const Bytes& data) {
    const bool patterns = mode() != 0;
    if (usb == 0x1A1B) {
      if (data[0] > 3) return refuse(6, "display mode");
      if (patterns && running) return refuse(5, "mode changed before stop");
      if (data[0] == 2 && (mode() != 0 || !has_video)) return refuse(5, "not from video");  // 2.4.1
      before_ = mode();
      settling_ = 5;
      running = data[0] == 0;
      lut.clear();
      pictures.clear();
      registers[usb] = data;
      return true;
    }
    if (usb == 0x1A07) {
      registers[usb] = data;
      return true;
    }
    if (!patterns) return refuse(5, fmt::format("{:04X} in video mode", usb));  // table A-2
    if (usb == 0x1A24) {
      if (data[0] == 2 && registers[0x1A31][0] == 0) return refuse(5, "start without patterns");
      running = data[0] == 2 && starts;
      return true;
    }
    if (running) return refuse(5, fmt::format("{:04X} before stop", usb));
    if (usb == 0x1A34) {
      if (number_in(data, 0, 2) != lut.size() || data[9] > 1) return refuse(15, "pattern number");
      if (number_in(data, 2, 3) < 94) return refuse(14, "exposure");
      lut.push_back(data);
      return true;
    }
    if (usb == 0x1A31) {
      if (number_in(data, 0, 2) != lut.size()) return refuse(15, "number of patterns");
    } else if (usb == 0x1A32) {
      if (number_in(data, 6, 2) >= lut.size()) return refuse(15, "pattern order");
    } else if (usb == 0x1A2A || usb == 0x1A2C) {
      if (mode() != 3 || number_in(data, 0, 2) > 17) return refuse(5, "picture");
      loading_ = {usb == 0x1A2C, number_in(data, 0, 2)};
      expected_ = number_in(data, 2, 4);
      if (!pictures.empty() && pictures.begin()->first.second < loading_.second)
        return refuse(5, "picture order");
      pictures[loading_].clear();
      return true;
    } else if (usb == 0x1A2B || usb == 0x1A2D) {
      if (number_in(data, 0, 2) != data.size() - 2 || data.size() > 506 ||
          loading_.first != (usb == 0x1A2D))
        return refuse(6, "picture data");
      Bytes& picture = pictures[loading_];
      picture.insert(picture.end(), data.begin() + 2, data.end());
      if (picture.size() > expected_) return refuse(17, "more than announced");
      return true;
    }
    registers[usb] = data;
    return true;
  }

  Controller which_;
  std::deque<Report> queue_;
  Bytes payload_;
  std::size_t awaited_ = 0, expected_ = 0;
  std::pair<bool, std::uint32_t> loading_{};
  std::uint8_t sequence_ = 0, error_ = 0, last_error_ = 0, before_ = 0;
  int settling_ = 0, busy_ = 0;
  bool is_read_ = false, gone_ = false, valid_ = false;
};

}  // namespace slipstream::dlp
