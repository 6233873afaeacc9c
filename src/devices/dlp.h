#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "devices/hid_port.h"
#include "slipstream/frame_source.h"

namespace slipstream::dlp {

struct DlpSettings {
  double rate = 60;  ///< pictures per second of the screen; without one, patterns per second
  std::function<bool()> ends = [] { return false; };  ///< called while patterns are loaded
  std::chrono::milliseconds timeout{1000}, poll{20};
};

/// Patterns on a DLP projector, with linear grey levels and a trigger pulse each. From each picture
/// on `screen`, its monitor input, it shows red, green and blue one after another. Without a
/// screen, a DLPC900 shows one-bit patterns loaded over USB: at most 400, dark below level 128.
/// Settings are restored at the end; a sequence that ran before does not continue.
class DlpSink : public PatternSink {
 public:
  /// Changes nothing yet. Throws Error if the screen is not of the chip's size, too fast, or
  /// missing for a DLPC350; WorldError if the controller fails or is in standby.
  DlpSink(OpenedController opened, PatternSink* screen, DlpSettings settings);
  ~DlpSink() override { restore(); }

  [[nodiscard]] std::optional<Size> size() const override { return size_; }
  void load(std::vector<Image<std::uint8_t>> patterns) override;
  void show(std::size_t n) override;
  [[nodiscard]] std::uint64_t shown() const override { return shown_; }
  [[nodiscard]] std::string state() const override { return {}; }
  /// "DLP6500, 8 bits, 5388 us per pattern"
  [[nodiscard]] const std::string& description() const { return description_; }

  /// Without a screen: loops through the patterns, timed by the controller.
  void loop();
  /// Stops and restores the settings. Throws WorldError if that fails.
  void give_back();

 private:
  using Bytes = std::vector<std::uint8_t>;
  using Values = std::vector<std::uint32_t>;
  Bytes exchange(std::string_view command, bool is_read, const Values& values, const Bytes& data);
  std::uint8_t read(const char* command) { return exchange(command, true, {}, {}).front(); }
  void write(const char* command, const Values& values, const Bytes& data = {}) {
    exchange(command, false, values, data);
  }
  void change(const char* setting, const Values& values);
  void await(const char* command, int mask, int wanted, const char* failure);
  void enter(std::uint8_t mode);
  void define_on_dlpc350();
  void define_on_dlpc900(std::size_t count);
  void load_picture(std::span<const Image<std::uint8_t>> patterns, std::size_t n, bool right);
  std::string restore();  ///< returns what failed

  bool is_dlpc350_;
  std::unique_ptr<HidPort> port_;
  PatternSink* screen_;
  DlpSettings settings_;
  std::uint8_t sequence_ = 0;
  int unanswered_ = 0;  ///< commands in succession
  Size size_;
  bool has_halves_ = false;          ///< each with its own controller
  std::uint32_t bits_ = 1, us_ = 0;  ///< of a pattern
  std::string description_{};
  std::vector<std::pair<const char*, Bytes>> found_{};  ///< settings to restore, last first
  std::uint64_t shown_ = 0;
};

}  // namespace slipstream::dlp
