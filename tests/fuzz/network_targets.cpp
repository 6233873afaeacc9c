// Packets to the served camera, and the answers of a driver and of a projector.
#include <cerrno>
#include <cstring>
#include <list>

#include <linux/videodev2.h>

#include "devices/dlp.h"
#include "devices/gige_protocol.h"
#include "devices/v4l2.h"
#include "slipstream/camera.h"
#include "slipstream/error.h"
#include "slipstream/frame_source.h"
#include "tests/devices/dlp_double.h"
#include "tests/devices/gvcp_packets.h"
#include "tests/fuzz/target.h"

namespace slipstream {
namespace {

constexpr auto at = [](GigeRegister which) { return static_cast<std::uint32_t>(which); };

/// Packets one behind another, each after its length in a byte and who sends it in another.
Bytes conversation(const std::vector<Bytes>& packets) {
  Bytes bytes;
  for (const Bytes& packet : packets) {
    bytes.push_back(static_cast<std::uint8_t>(packet.size()));
    bytes.push_back(0);
    bytes.insert(bytes.end(), packet.begin(), packet.end());
  }
  return bytes;
}

std::vector<Bytes> conversations() {
  return {conversation({command(discover, {}), command(read_memory, {0x200, 512}),
                        command(read_register, {0xfffffffc})}),
          conversation({command(write_register, {at(GigeRegister::control_privilege), 2}),
                        command(write_register, {at(GigeRegister::stream_host), loopback}),
                        command(write_register, {at(GigeRegister::acquisition), 1}),
                        command(write_memory, {at(GigeRegister::left), 3, 4}),
                        command(write_register, {at(GigeRegister::control_privilege), 0})})};
}

/// Each input is a conversation; frames that the camera would send are made.
void answer_packets(std::span<const std::uint8_t> input) {
  static const GigeControl untouched = [] {
    GigeControl control(Bytes(0x10000 + 64));
    for (const auto which : {GigeRegister::sensor_width, GigeRegister::width})
      control.write(which, 64);
    for (const auto which : {GigeRegister::sensor_height, GigeRegister::height})
      control.write(which, 48);
    return control;
  }();
  static const Image<std::uint8_t> picture({64, 48});
  GigeControl control = untouched;
  GigeControl::Time now;
  while (input.size() >= 2) {
    const auto packet = input.subspan(2, std::min<std::size_t>(input[0], input.size() - 2));
    now += std::chrono::milliseconds(100 * (input[1] >> 2));
    const auto answer =
        control.answer(packet, address_of(loopback, static_cast<std::uint16_t>(input[1] & 3)), now);
    if (answer.size() > 8 + 4 + 536) throw std::logic_error("an answer too long");
    if (const auto stream = control.stream(now)) {
      std::size_t bytes = 0;
      for_each_packet(block_of(picture, *stream, 1), [&](auto part) { bytes += part.size(); });
      if (bytes < 8U + 36 + 8 + 16) throw std::logic_error("a frame too short");
    }
    input = input.subspan(2 + packet.size());
  }
}

/// A driver whose answers are an input's bytes.
class AnyDriver : public VideoDevice {
 public:
  explicit AnyDriver(InputNumbers& answers) : answers_(answers) {}

  int control(unsigned long request, void* argument) override {
    const auto how = answers_.next<std::uint8_t>();
    if (answers_.rest().empty() || how % 32 == 31) {
      errno = how % 64 == 63 ? EINVAL : how < 128 ? EAGAIN : ENODEV;
      return -1;
    }
    if ((_IOC_DIR(request) & _IOC_READ) == 0 || how % 2 == 0) return likely(request, argument);
    const auto bytes =
        answers_.rest().first(std::min<std::size_t>(_IOC_SIZE(request), answers_.rest().size()));
    std::memcpy(argument, bytes.data(), bytes.size());
    for (std::size_t i = 0; i < bytes.size(); ++i) (void)answers_.next<std::uint8_t>();
    return 0;
  }
  void* map(std::size_t length, std::size_t) override {
    constexpr std::size_t longest = 1 << 12, most = 16;
    if (length > longest || memory_.size() == most) return nullptr;
    return memory_.emplace_back(length, std::uint8_t{0x5a}).data();
  }
  void unmap(void*, std::size_t) override {}
  bool wait(std::chrono::milliseconds) override { return !answers_.rest().empty(); }

 private:
  /// What lets the next call come.
  int likely(unsigned long request, void* argument) {
    if (request == VIDIOC_QUERYCAP) {
      static_cast<v4l2_capability*>(argument)->capabilities =
          V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
    }
    if (request == VIDIOC_QUERYBUF) {
      static_cast<v4l2_buffer*>(argument)->length = answers_.next<std::uint16_t>() % 256;
    }
    if (request == VIDIOC_DQBUF) static_cast<v4l2_buffer*>(argument)->bytesused = 256;
    return 0;
  }

  InputNumbers& answers_;
  std::list<Bytes> memory_;
};

/// Frames of a driver of any answers, with its controls looked at and set between.
void hear_driver(std::span<const std::uint8_t> input) {
  InputNumbers answers(input);
  CameraSettings settings;
  const auto how = answers.next<std::uint8_t>();
  settings.region = Rectangle{.size = {1 + how % 8, 3}};
  settings.pixel_format = how < 128 ? PixelFormat::mono8 : PixelFormat::mono12;
  if (how % 3 == 0) settings.frame_rate = 30;
  if (how % 5 == 0) settings.exposure = 0.01;
  try {
    const auto source = open_v4l2_camera(
        "any", [&] { return std::make_unique<AnyDriver>(answers); }, settings);
    source->start();
    Frame frame(source->format());
    for (int i = 0; i < 20 && !answers.rest().empty(); ++i) {
      (void)source->next(frame, {});
      (void)source->controls()->control(i % 2 == 0 ? CameraControl::exposure : CameraControl::gain);
    }
    source->stop();
  } catch (const WorldError&) {  // no such camera
  }
}

std::vector<Bytes> drivers() {
  return {Bytes(400, 0x10), Bytes(400, 0x80)};
}

/// A monitor on which nothing is to be seen.
class StillMonitor : public PatternSink {
 public:
  explicit StillMonitor(Size size) : size_(size) {}
  [[nodiscard]] std::optional<Size> size() const override { return size_; }
  void load(std::vector<Image<std::uint8_t>>) override {}
  void show(std::size_t) override { ++shown_; }
  [[nodiscard]] std::uint64_t shown() const override { return shown_; }
  [[nodiscard]] std::string state() const override { return {}; }

 private:
  Size size_;
  std::uint64_t shown_ = 0;
};

/// A controller on which an input changes answers, or leaves them out.
void hear_projector(std::span<const std::uint8_t> input) {
  InputNumbers changes(input);
  constexpr std::uint8_t smallest_chip = 5;
  const auto which =
      changes.next<std::uint8_t>() % 2 == 0 ? dlp::Controller::dlpc350 : dlp::Controller::dlpc900;
  dlp::ControllerDouble device(which, smallest_chip);

  device.answers = [&](const dlp::Report& usual) -> std::optional<dlp::Report> {
    const auto how = changes.next<std::uint8_t>();
    if (how >= 240) return std::nullopt;
    dlp::Report answer = usual;
    if (how >= 128) answer[how % answer.size()] = changes.next<std::uint8_t>();
    return answer;
  };

  // A DLPC350 shows pictures of a monitor, a DLPC900 patterns that it stores.
  StillMonitor monitor({912, 1140});
  const bool has_monitor = which == dlp::Controller::dlpc350;
  try {
    dlp::DlpSink sink(
        {which, device.port()}, has_monitor ? &monitor : nullptr,
        {.timeout = std::chrono::milliseconds(0), .poll = std::chrono::milliseconds(0)});
    sink.load({Image<std::uint8_t>({1024, 768})});
    sink.show(0);
    sink.give_back();
  } catch (const WorldError&) {  // it does not answer, or wrongly
  }
}

std::vector<Bytes> projectors() {
  return {Bytes(100, 0), Bytes(100, 1), Bytes{0, 0, 0, 0, 130, 7, 0, 250}, Bytes{1, 0, 131, 9}};
}

const bool knows_network_targets =
    add_fuzz_target({"gvcp", conversations, answer_packets}) &&
    add_fuzz_target({"v4l2", drivers, hear_driver}, 1000, std::uint64_t{4} << 30) &&
    add_fuzz_target({"dlp", projectors, hear_projector, 10});

}  // namespace
}  // namespace slipstream
