#include "devices/virtual_gige_camera.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/names.h"
#include "base/throw_if-inl.h"
#include "devices/aravis_connection-inl.h"
#include "simulate/rendered_reel.h"

namespace slipstream {
namespace {

using std::chrono::steady_clock;

/// A feature and its register of the selected line; `values` belong before or after the link to it.
std::string feature(const char* kind, const char* name, GigeRegister where, const char* before,
                    const char* after = "", const char* index = "") {
  return fmt::format(
      R"(<{0} Name="{1}">{3}<pValue>{1}Register</pValue>{4}</{0}>
<IntReg Name="{1}Register"><Address>{2}</Address>{5}<Length>4</Length><AccessMode>RW</AccessMode>
<pPort>Device</pPort><Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>
)",
      kind, name, static_cast<std::uint32_t>(where), before, after, index);
}

/// Aravis' description, with Line1 as trigger source, and lines and a timer as outputs.
std::string with_lines(std::string description) {
  using enum GigeRegister;
  constexpr const char* line = R"(<pIndex Offset="16">LineNumber</pIndex>)";
  constexpr const char* us = "<Min>0</Min><Max>1000000</Max>";

  const std::string nodes =
      R"(<Category Name="DigitalIOControl"><pFeature>LineSelector</pFeature>
<pFeature>LineMode</pFeature><pFeature>LineSource</pFeature><pFeature>LineInverter</pFeature>
<pFeature>TimerSelector</pFeature><pFeature>TimerTriggerSource</pFeature>
<pFeature>TimerDelay</pFeature><pFeature>TimerDuration</pFeature></Category>
<Enumeration Name="LineSelector"><EnumEntry Name="Line0"><Value>0</Value></EnumEntry>
<EnumEntry Name="Line1"><Value>1</Value></EnumEntry><pValue>LineNumber</pValue></Enumeration>
<Integer Name="LineNumber"><Value>0</Value></Integer>
<Enumeration Name="TimerSelector"><EnumEntry Name="Timer1"><Value>1</Value></EnumEntry>
<Value>1</Value></Enumeration>
)" +
      feature("Enumeration", "LineMode", line_mode,
              R"(<EnumEntry Name="Input"><Value>0</Value></EnumEntry>
<EnumEntry Name="Output"><Value>1</Value></EnumEntry>)",
              "", line) +
      feature("Enumeration", "LineSource", line_source,
              R"(<EnumEntry Name="Off"><Value>0</Value></EnumEntry>
<EnumEntry Name="ExposureActive"><Value>1</Value></EnumEntry>
<EnumEntry Name="Timer1Active"><Value>2</Value></EnumEntry>)",
              "", line) +
      feature("Boolean", "LineInverter", line_inverter, "",
              "<OnValue>1</OnValue><OffValue>0</OffValue>", line) +
      feature("Enumeration", "TimerTriggerSource", timer_source,
              R"(<EnumEntry Name="Off"><Value>0</Value></EnumEntry>
<EnumEntry Name="ExposureStart"><Value>1</Value></EnumEntry>)") +
      feature("Float", "TimerDelay", timer_delay, "", us) +
      feature("Float", "TimerDuration", timer_duration, "", us) +
      R"(<Enumeration Name="DeviceTemperatureSelector">
<EnumEntry Name="Sensor"><Value>0</Value></EnumEntry>
<EnumEntry Name="Mainboard"><Value>1</Value></EnumEntry><pValue>PartNumber</pValue></Enumeration>
<Integer Name="PartNumber"><Value>0</Value></Integer>
)" +
      feature("Float", "DeviceTemperature", temperature, "", "",
              R"(<pIndex Offset="4">PartNumber</pIndex>)");

  // Insert each addition before a place in Aravis' text.
  for (const auto& [place, text] :
       {std::pair{"<pFeature>TransportLayerControl", "<pFeature>DigitalIOControl</pFeature>\n"},
        std::pair{"<pValue>TriggerSourceRegister",
                  R"(<EnumEntry Name="Line1"><Value>2</Value></EnumEntry>)"},
        std::pair{"</RegisterDescription>", nodes.c_str()}}) {
    description.insert(std::min(description.find(place), description.size()), text);
  }

  return description;
}

/// Registers and description of Aravis' fake camera, read from its own server, with lines.
std::vector<std::uint8_t> fake_camera_memory(const std::string& serial, in_addr host, Size sensor) {
  // 1. Aravis' camera with our serial number, address and sensor size.
  const GObjectPointer<ArvFakeCamera> camera(arv_fake_camera_new(serial.c_str()));
  const GObjectPointer<GInetAddress> address(
      g_inet_address_new_from_bytes(reinterpret_cast<const guint8*>(&host), G_SOCKET_FAMILY_IPV4));
  arv_fake_camera_set_inet_address(camera.get(), address.get());

  const auto [width, height] = sensor;
  for (const auto& [at, pixels] : {std::pair{ARV_FAKE_CAMERA_REGISTER_SENSOR_WIDTH, width},
                                   std::pair{ARV_FAKE_CAMERA_REGISTER_SENSOR_HEIGHT, height},
                                   std::pair{ARV_FAKE_CAMERA_REGISTER_WIDTH, width},
                                   std::pair{ARV_FAKE_CAMERA_REGISTER_HEIGHT, height}}) {
    arv_fake_camera_write_register(camera.get(), static_cast<guint32>(at),
                                   static_cast<guint32>(pixels));
  }

  // 2. Its registers with our temperatures, and its description with our lines.
  constexpr std::uint32_t last = 4;  // it refuses reads that reach its end
  std::vector<std::uint8_t> memory(ARV_FAKE_CAMERA_MEMORY_SIZE);
  arv_fake_camera_read_memory(camera.get(), 0, ARV_FAKE_CAMERA_MEMORY_SIZE - last, memory.data());

  constexpr auto temperature = static_cast<std::size_t>(GigeRegister::temperature);
  memory.at(temperature + 3) = 41;  // the last byte of a number
  memory.at(temperature + 7) = 38;

  std::size_t size = 0;
  const char* plain = arv_fake_camera_get_genicam_xml(camera.get(), &size);
  const std::string description = with_lines({plain, size});

  // 3. The register with the description's place, and the description after the registers.
  constexpr std::ptrdiff_t place_of_description = 0x200;  // defined by the standard
  const std::string place = fmt::format("Local:slipstream.xml;{:x};{:x}",
                                        ARV_FAKE_CAMERA_MEMORY_SIZE, description.size());
  std::copy_n(place.c_str(), place.size() + 1, memory.begin() + place_of_description);

  memory.insert(memory.end(), description.begin(), description.end());
  memory.resize((memory.size() + 3) / 4 * 4);  // clients read four bytes at a time

  return memory;
}

VirtualGigeCamera::Reels valid(VirtualGigeCamera::Reels reels, const std::string& serial) {
  if (reels.empty()) throw Error("a virtual camera needs at least one reel");

  for (const auto& reel : reels) {
    throw_if(reel->format() != reels.front()->format() || reel->format().bits != 8,
             "the virtual GigE camera needs 8-bit frames of one size");
  }
  throw_if(serial.empty() || serial.size() > 15,
           "serial number of {} letters, '{}'; expected 1 to 15", serial.size(), serial);

  return reels;
}

}  // namespace

VirtualGigeCamera::VirtualGigeCamera(Reels reels, const std::string& address,
                                     const std::string& serial)
    : reels_(valid(std::move(reels), serial)),
      control_sockets_(address),
      stream_socket_(host_from(address), 0, false),
      control_(fake_camera_memory(serial, host_from(address), reels_.front()->format().size)),
      thread_([this] { run(); }) {}

VirtualGigeCamera::~VirtualGigeCamera() {
  is_ending_ = true;
  thread_.join();
}

/// The pattern, counted since the client's start, that the projector shows in frame k. The caller
/// holds the mutex.
std::size_t VirtualGigeCamera::shown_in(std::size_t k) const {
  using enum GigeRegister;

  if (wiring_ == Wiring::in_step) return k;

  // A free-running camera sees whatever the projector shows now.
  if (wiring_ == Wiring::trigger) {
    const bool free = control_.read(trigger_mode) == 0;
    const auto shown = (steady_clock::now() - started_) / projector_period_;
    return free ? static_cast<std::size_t>(shown) : k;
  }
  // Inverted, the rising edge ends the exposure; before the first one the last pattern is shown.
  const std::size_t last = reels_[reel_]->order().size() - 1;
  return pulses_ + (control_.read(line_register(line_inverter, 1)) != 0 ? last : 0);
}

/// Whether there is a picture to send, or it is still being rendered.
bool VirtualGigeCamera::has_picture() const {
  try {
    return view_ || player_.frame() != nullptr;
  } catch (...) {  // rendering failed: whoever began it is told
    return false;
  }
}

/// For a new client: the next reel, once one has seen enough of this, from its first frame on.
void VirtualGigeCamera::begin_reel() {
  if (seen_whole_ && reel_ + 1 < reels_.size()) {
    ++reel_;
    seen_whole_ = false;
  }

  player_ = ReelPlayer(reels_[reel_]);
  player_shows_ = 0;
}

/// The picture of a pattern counted since the client's start; nullptr if it is not rendered yet.
const Image<std::uint8_t>* VirtualGigeCamera::picture(std::size_t shown) {
  if (shown < player_shows_) {  // the client or the wiring has changed what triggers what
    player_.restart();
    player_shows_ = 0;
  }

  player_.advance(shown - player_shows_);
  player_shows_ = shown;
  seen_whole_ |= player_.has_shown_enough();

  if (!has_picture()) return nullptr;
  return &std::get<Image<std::uint8_t>>(player_.frame()->pixels);
}

/// Sends frame k since the client's start, numbered from 1. Clients enlarge their buffers at the
/// first packet, so the rest of the first frame waits until then.
void VirtualGigeCamera::send(const GigeStream& stream, std::size_t k, std::size_t shown) {
  constexpr std::size_t largest_number = 65535;
  const auto number = static_cast<std::uint16_t>(1 + k % largest_number);

  const Image<std::uint8_t> seen = view_ ? view_() : Image<std::uint8_t>();
  const Image<std::uint8_t>* const shown_picture = view_ ? &seen : picture(shown);
  if (shown_picture == nullptr) return;  // lost, as if the projector were dark

  const GigeBlock block = block_of(*shown_picture, stream, number);
  for_each_packet(block, [&, is_first = k == 0](auto packet) mutable {
    const bool lost = std::uniform_real_distribution()(random_) < packet_loss_;
    if (!lost) stream_socket_.send(packet, stream.to);
    // 5 ms for the client to enlarge its buffer.
    if (std::exchange(is_first, false)) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  });

  ++sent_;
}

void VirtualGigeCamera::run() {
  using enum GigeRegister;
  constexpr std::chrono::nanoseconds idle = std::chrono::milliseconds(50);
  constexpr std::uint32_t line_1_triggers = 2;
  constexpr std::chrono::microseconds trigger_period{40'000};  // limit for software triggers

  steady_clock::time_point due = steady_clock::now();
  for (std::size_t k = 0; !is_ending_;) {
    // 1. Decide whether a frame is due: free-running, by software or by the projector's pulse.
    std::unique_lock lock(mutex_);
    control_.listen(steady_clock::now());
    const auto stream = control_.stream(steady_clock::now());
    const bool is_pulsed = stream && wiring_ == Wiring::trigger && !stream->is_free &&
                           control_.read(trigger_source) == line_1_triggers;
    const bool is_ready = stream && (stream->is_free || stream->is_triggered || is_pulsed);
    const bool is_due = is_ready && has_picture() && steady_clock::now() >= due;

    if (is_due) control_.write(software_trigger, 0);
    if (!stream) {  // a new client sees the first frame
      k = pulses_ = 0;
      started_ = steady_clock::now();
      begin_reel();
    }

    // 2. The pattern seen in it. Its exposure sends a pulse if Line1 is an output with a source.
    const std::size_t shown = is_due ? shown_in(k) : 0;
    const auto period = is_pulsed ? projector_period_ : trigger_period;
    if (is_due && control_.read(line_register(line_mode, 1)) == 1 &&
        control_.read(line_register(line_source, 1)) != 0) {
      ++pulses_;
    }

    // 3. Send the frame without the lock, then answer the client until the next is due.
    lock.unlock();
    if (is_due) {
      send(*stream, k++, shown);
      due = std::max(due + (stream->is_free ? stream->period : period), steady_clock::now());
    }

    control_sockets_.answer(
        is_ready && has_picture() ? std::min(due - steady_clock::now(), idle) : idle,
        [this](auto packet, const sockaddr_in& from) {
          const std::lock_guard answering(mutex_);
          return control_.answer(packet, from, steady_clock::now());
        });
  }
}

void VirtualGigeCamera::set_frame_rate(double rate) {
  // The register holds the period in us, 32 bits.
  throw_if(!(rate >= 1e-3 && rate <= 1e6), "rate {} Hz is out of range; expected 0.001 to 1e6",
           rate);
  const std::lock_guard lock(mutex_);
  projector_period_ = std::chrono::microseconds(static_cast<std::int64_t>(1e6 / rate));
  control_.write(GigeRegister::frame_period, static_cast<std::uint32_t>(projector_period_.count()));
}

Wiring wiring_named(std::string_view name) {
  constexpr std::array<std::string_view, 3> names{"in-step", "trigger", "strobe"};
  const auto wiring = value_named<Wiring>(name, names);
  throw_if(!wiring, "wiring '{}' is unknown; use one of {}", name, fmt::join(names, ", "));
  return *wiring;
}

}  // namespace slipstream
