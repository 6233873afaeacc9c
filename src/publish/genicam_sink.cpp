#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <exception>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

#include <arpa/inet.h>

#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "devices/gige_sockets.h"
#include "publish/scan3d.h"
#include "publish/sink_kind.h"

namespace slipstream {
namespace {
using namespace std::chrono_literals;
using std::chrono::steady_clock;
using enum GigeRegister;
using enum GigeStatus;
using namespace scan3d;

constexpr std::uint32_t fire_test_packet = 0x80000000, is_test_whole = 0x40000000;
/// Bytes per second. A receiver's socket holds a few hundred kB, so a period spreads its block.
constexpr double slowest = 50e6, fastest = 400e6, spread = 0.5;
/// How far packets may lag behind before they are sent in a burst.
constexpr auto most_behind = 500us;
constexpr std::chrono::duration<double> longest_block = 1s;
constexpr std::chrono::nanoseconds first_pause = 5ms, shortest_sleep = 200us;
constexpr auto between_checks = 200ms;
constexpr std::uint32_t depth = 2;  // per coordinate

/// When a client may write a register: always, or only while not streaming.
struct Bounds {
  GigeRegister which;
  std::uint32_t least, most;
  bool while_sending;
};
constexpr std::array bounds{Bounds{acquisition, 0, 1, true},
                            Bounds{trigger_mode, 0, 1, true},
                            Bounds{trigger_source, 1, 1, true},
                            Bounds{frame_period, 1000, 10'000'000, true},
                            Bounds{software_trigger, 0, 1, true},
                            Bounds{component_selector, 0, 2, true},
                            Bounds{coordinate_selector, 0, 2, true},
                            Bounds{reference_selector, 0, 5, true},
                            Bounds{acquisition_mode, 1, 2, false},
                            Bounds{component_enable, 0, 1, false},
                            Bounds{at(component_enable, 1), 0, 1, false},
                            Bounds{at(component_enable, 2), 0, 1, false}};

/// A sent block, kept for resend requests.
struct SentBlock {
  GigeBlock block;
  std::atomic<std::size_t> sent_again = 0;
};

/// The camera: one thread answers requests, the publisher's thread sends clouds.
class GenicamSink final : public CloudSink {
 public:
  GenicamSink(const std::string& address, PublishedRun run)
      : run_(std::move(run)),
        settings_(run_.settings ? run_.settings() : std::vector<RunSetting>()),
        sockets_(address),
        stream_socket_(host_from(address), 0, false),
        control_(scan3d_memory(address, run_, settings_, stream_socket_.port()), scan3d_writable(),
                 [this](GigeRegister which, std::uint32_t value) { return accept(which, value); }),
        thread_([this] { serve(); }) {}

  ~GenicamSink() override { finish(); }

  bool wants(const LiveCloud& cloud) override {
    if (is_sending_) return false;

    const std::unique_lock lock(mutex_, std::try_to_lock);
    return !lock || stream_for(cloud);  // must not block the thread that makes clouds
  }

  void put(const Pooled<LiveCloud>& cloud, bool /*alone*/) override {
    // 1. Read the client's settings; this cloud uses up its trigger.
    std::unique_lock lock(mutex_);
    const auto stream = stream_for(*cloud);
    if (!stream) return;

    due_ = std::max(due_ + stream->period, steady_clock::now() + stream->period / 2);
    control_.change(software_trigger, 0);
    // Mode 2 is a single cloud.
    if (control_.read(acquisition_mode) == 2) control_.change(acquisition, 0);

    const Packing packing = this->packing();
    if (packing.parts.empty()) return;

    const auto next = next_block(packing.is_multipart);
    lock.unlock();

    // 2. Write the block without the lock, which the client's commands need.
    is_sending_ = true;

    GigeBlock& block = next->block;
    block.time = cloud->newest.host_time.time_since_epoch();
    block.region = stream->region;
    block.packet_bytes = stream->packet_bytes;

    block.parts.resize(packing.parts.size());
    for (std::size_t i = 0; i < block.parts.size(); ++i) {
      std::tie(block.parts[i].component, block.parts[i].pixels) = packing.parts[i];
      write_part(cloud->cloud, stream->region, packing, block.parts[i]);
    }

    // 3. Send it; from now on its packets can be sent again on request.
    lock.lock();
    sent_ = {next, std::move(sent_[0])};
    lock.unlock();

    send(block, *stream);
    is_sending_ = false;
  }

  void finish() override {
    is_ending_ = true;
    if (thread_.joinable()) thread_.join();
  }

 private:
  void serve() {
    auto looked = steady_clock::now() - between_checks;

    // The first answer already needs the registers that depend on others.
    std::unique_lock at_the_start(mutex_);
    refresh();
    at_the_start.unlock();

    while (!is_ending_) {
      if (run_.settings && steady_clock::now() - looked >= between_checks) {
        look_at_settings();
        looked = steady_clock::now();
      }

      sockets_.answer(50ms, [this](auto packet, const sockaddr_in& from) {
        // The lock is held for the command alone, not while packets are sent again.
        std::unique_lock lock(mutex_);
        auto answer = control_.answer(packet, from, steady_clock::now());
        refresh();
        const auto resend = control_.take_resend();
        lock.unlock();

        if (resend) send_again(*resend);
        return answer;
      });

      end_recording();
    }
  }

  /// Ends a recording that a client has started, once its control has ended.
  void end_recording() {
    std::unique_lock lock(mutex_);
    control_.listen(steady_clock::now());
    if (!recorded_by_ || control_.ended_controls(steady_clock::now()) == *recorded_by_) return;
    recorded_by_.reset();
    lock.unlock();

    (void)try_to_change("record", "off");  // the recording reports a failure
  }

  /// Call it without the lock: a change may take long.
  [[nodiscard]] bool try_to_change(const std::string& name, const std::string& value) const try {
    run_.change(name, value);
    return true;
  } catch (const std::exception&) {
    return false;
  }

  /// Settings that change a block's layout are locked while streaming.
  GigeStatus accept(GigeRegister which, std::uint32_t value) {
    if (which >= setting) {
      return change_setting(
          (static_cast<std::uint32_t>(which) - static_cast<std::uint32_t>(setting)) / 4, value);
    }

    // Side effects: a trigger counts from now on, and blocks are numbered from 1 for a new port.
    if (which == software_trigger) triggered_ = steady_clock::now();
    if (which == stream_port) number_ = 0;

    // Registers without an entry in `bounds`: those of the standard can be written at any time, the
    // rest only while not streaming, and have rules of their own.
    const auto bound = std::ranges::find(bounds, which, &Bounds::which);
    const bool is_of_every_camera = which >= heartbeat_timeout && which < component_selector &&
                                    which != packet_size && which != stream_configuration;
    const bool is_free = bound == bounds.end() ? is_of_every_camera : bound->while_sending;
    if (!is_free && control_.read(acquisition) != 0) return access_denied;

    const auto within = [&](std::uint32_t least, std::uint32_t most) {
      return value >= least && value <= most ? success : invalid_parameter;
    };
    if (bound != bounds.end()) return within(bound->least, bound->most);
    if (is_of_every_camera) return success;

    // Region: position and size together stay within the sensor.
    const auto room = [&](GigeRegister all, GigeRegister other) {
      return control_.read(all) - control_.read(other);
    };
    if (which == width) return within(1, room(sensor_width, left));
    if (which == height) return within(1, room(sensor_height, top));
    if (which == left) return within(0, room(sensor_width, width));
    if (which == top) return within(0, room(sensor_height, height));

    // Stream.
    if (which == packet_size) {
      value &= ~(fire_test_packet | is_test_whole);
      return within(smallest_gige_packet, largest_gige_packet);
    }
    if (which == stream_configuration) {
      return (value & ~gige_multipart) == 0 ? success : invalid_parameter;
    }

    // Points: output mode and pixel format depend on each other. Other components have one format.
    if (which == output_mode) {
      return choose(value == projected_c           ? GigePixels::coord3d_c32f
                    : value == calibrated_abc_grid ? GigePixels::coord3d_abc32f
                                                   : GigePixels::mono8);
    }
    if (which == pixel_format) return choose(static_cast<GigePixels>(value));

    if (which == at(pixel_format, 1) || which == at(pixel_format, 2)) {
      return value == control_.read(which) ? success : invalid_parameter;
    }

    return accept_steps(which, std::bit_cast<float>(value));
  }

  /// Pixel formats of points, with their scale.
  GigeStatus choose(GigePixels pixels) {
    const bool has_steps = pixels == GigePixels::coord3d_c16;
    const bool has_axes = pixels == GigePixels::coord3d_abc32f;
    if (!has_steps && !has_axes && pixels != GigePixels::coord3d_c32f) return invalid_parameter;

    control_.change(pixel_format, static_cast<std::uint32_t>(pixels));
    control_.change(output_mode, has_axes ? calibrated_abc_grid : projected_c);
    control_.change(at(coordinate_scale, depth), bits_of(has_steps ? DepthScale().scale : 1));
    control_.change(at(coordinate_offset, depth), bits_of(0));
    control_.change(at(invalid_value, depth),
                    bits_of(has_steps ? 0 : std::numeric_limits<float>::quiet_NaN()));
    return success;
  }

  /// Updates settings changed by any sink or the viewer. A removed setting keeps its value.
  void look_at_settings() try {
    // Before the lock, since the run may wait for its camera.
    const std::vector<RunSetting> all = run_.settings();
    const std::lock_guard lock(mutex_);

    for (std::uint32_t i = 0; i < settings_.size(); ++i) {
      const auto now = std::ranges::find(all, settings_[i].name, &RunSetting::name);
      if (now == all.end()) continue;

      const auto choice = std::ranges::find(now->choices, now->value);
      control_.write(at(setting, i),
                     now->choices.empty()
                         ? bits_of(number_in<double>(now->value).value_or(0) * feature_scale(*now))
                         : static_cast<std::uint32_t>(choice - now->choices.begin()));
    }
  } catch (const std::exception&) {  // the camera is shutting down
  }

  /// Called with the lock, but releases it for the change, so that clouds are sent meanwhile.
  GigeStatus change_setting(std::uint32_t i, std::uint32_t value) {
    if (i >= settings_.size()) return invalid_address;
    const RunSetting& setting = settings_[i];
    const std::optional<std::string> wanted = value_in_register(setting, value);
    if (!wanted) return invalid_parameter;

    mutex_.unlock();
    const bool is_changed = try_to_change(setting.name, *wanted);
    mutex_.lock();
    if (!is_changed) return invalid_parameter;

    // Remember who switched recording on, to end it when that client leaves.
    if (setting.name == "record") {
      const bool starts = value == 1 && control_.read(at(scan3d::setting, i)) == 0;
      if (starts) recorded_by_ = control_.ended_controls(steady_clock::now());
      if (value == 0) recorded_by_.reset();
    }
    return success;
  }

  /// Scale of 16-bit depths; floats are millimetres.
  [[nodiscard]] GigeStatus accept_steps(GigeRegister which, float number) const {
    const bool has_steps =
        control_.read(pixel_format) == static_cast<std::uint32_t>(GigePixels::coord3d_c16);

    const bool is_scale = which == at(coordinate_scale, depth);
    if (!has_steps || (!is_scale && which != at(coordinate_offset, depth))) return access_denied;

    return std::isfinite(number) && (number > 0 || !is_scale) ? success : invalid_parameter;
  }

  [[nodiscard]] Packing packing() const {
    const auto number = [&](GigeRegister which) {
      return std::bit_cast<float>(control_.read(at(which, depth)));
    };

    Packing packing{.parts = {},
                    .depth = {number(coordinate_scale), number(coordinate_offset)},
                    .is_multipart = (control_.read(stream_configuration) & gige_multipart) != 0};

    // Without multi-part blocks only the first enabled component is sent.
    for (std::uint32_t i = 0; i < scan3d_components.size(); ++i) {
      if (control_.read(at(component_enable, i)) == 0) continue;
      packing.parts.emplace_back(scan3d_components[i],
                                 static_cast<GigePixels>(control_.read(at(pixel_format, i))));
      if (!packing.is_multipart) break;
    }

    return packing;
  }

  /// Updates registers that depend on the written one.
  void refresh() {
    // Size of a block, bytes.
    std::size_t bytes = 0;
    for (const auto& [component, pixels] : packing().parts) bytes += bytes_per_pixel(pixels);
    control_.change(payload_size, static_cast<std::uint32_t>(bytes) * control_.read(width) *
                                      control_.read(height));

    // The principal point moves with the region.
    control_.change(principal_u, bits_of(run_.camera.intrinsic(0, 2) - control_.read(left)));
    control_.change(principal_v, bits_of(run_.camera.intrinsic(1, 2) - control_.read(top)));

    // The client wants a test packet, to find the largest size that the network passes.
    const std::uint32_t size = control_.read(packet_size);
    if ((size & fire_test_packet) == 0) return;
    control_.change(packet_size, size & ~fire_test_packet);

    // IPv4 and UDP headers.
    constexpr std::size_t outer_heads = 28;
    if (const auto to = control_.stream_target()) {
      stream_socket_.send_whole(std::vector<std::uint8_t>((size & 0xffff) - outer_heads), *to);
    }
  }

  /// Resends at most as many packets per block as it has, so that endless requests are bounded.
  void send_again(const GigeResend& request) {
    std::unique_lock lock(mutex_);
    const auto to = control_.stream_target();
    const auto sent = sent_;
    lock.unlock();

    if (!to) return;

    std::vector<std::uint8_t> packet;
    for (const auto& each : sent) {
      if (!each || each->block.number != request.block) continue;

      const std::size_t count = packet_count(each->block);
      for (std::size_t i = request.first; i <= request.last && i < count; ++i) {
        if (each->sent_again++ >= count) return;
        write_packet(each->block, i, packet);
        stream_socket_.send(packet, *to);
      }
      return;
    }

    write_missing_packet(request, packet);
    stream_socket_.send(packet, *to);
  }

  /// The destination of a cloud, if it is to be sent. A triggered cloud has no frame from before
  /// the trigger.
  std::optional<GigeStream> stream_for(const LiveCloud& cloud) {
    const auto now = steady_clock::now();
    const auto stream = control_.stream(now);
    if (control_.silent_clients() > 0) tell("disconnected a silent client");

    if (!stream || (!stream->is_free && !stream->is_triggered)) return std::nullopt;

    const auto early = stream->period / 4;  // tolerates jitter of clouds
    const bool is_due =
        stream->is_free ? now + early >= due_ : cloud.frames.front()->stamp.host_time >= triggered_;

    return is_due ? stream : std::nullopt;
  }

  /// Reuses the memory of the block before the last, unless it is being resent.
  std::shared_ptr<SentBlock> next_block(bool is_multipart) {
    auto next = std::exchange(sent_[1], nullptr);
    if (!next || next.use_count() > 1) next = std::make_shared<SentBlock>();

    // Without parts, block numbers have 16 bits and skip 0.
    constexpr std::uint64_t most_of_16_bits = 65535;
    number_ = is_multipart ? number_ + 1 : number_ % most_of_16_bits + 1;

    next->block.number = number_;
    next->block.is_multipart = is_multipart;
    next->sent_again = 0;
    return next;
  }

  void send(const GigeBlock& block, const GigeStream& stream) const {
    // Delay between packets: evenly over half the period, at 50 to 400 MB/s, but no less than the
    // client wishes. A block takes a second at most.
    const std::size_t count = packet_count(block);
    using Seconds = std::chrono::duration<double>;
    const auto packets = static_cast<double>(count),
               bytes = static_cast<double>(block.packet_bytes);
    const Seconds even = spread * Seconds(stream.period) / packets;
    const Seconds delay(std::max<Seconds>(
        stream.packet_delay, Seconds(std::clamp(even.count(), bytes / fastest, bytes / slowest))));
    const auto step = std::chrono::duration_cast<std::chrono::nanoseconds>(
        std::min(delay, longest_block / packets));

    auto due = steady_clock::now();
    std::vector<std::uint8_t> packet;
    for (std::size_t i = 0; i < count && !is_ending_; ++i) {
      write_packet(block, i, packet);
      stream_socket_.send(packet, stream.to);

      const auto now = steady_clock::now();
      // Clients enlarge their buffers at the first packet.
      due = std::max(due, now - most_behind) + (i == 0 && block.number == 1 ? first_pause : step);
      if (due - now > shortest_sleep) std::this_thread::sleep_until(due);
    }
  }

  const PublishedRun run_;
  const std::vector<RunSetting> settings_;  ///< at the start
  const GigeControlSockets sockets_;
  const UdpSocket stream_socket_;
  std::mutex mutex_;  ///< guards the members below
  GigeControl control_;
  std::array<std::shared_ptr<SentBlock>, 2> sent_;  ///< newest first
  steady_clock::time_point triggered_{};
  /// Controls that had ended when a client switched `record` on.
  std::optional<std::uint64_t> recorded_by_{};
  std::atomic<bool> is_sending_ = false;
  std::uint64_t number_ = 0;        ///< ID of the newest block since the client opened its port
  steady_clock::time_point due_{};  ///< publisher's thread only, also below
  std::atomic<bool> is_ending_ = false;
  std::thread thread_;
};

std::string address_from(const std::string& where) {
  in_addr host{};
  if (::inet_pton(AF_INET, where.c_str(), &host) == 1) return where;
  throw Error(fmt::format(
      "`publish genicam:{}`: expected an IPv4 address of this machine, e.g. genicam:127.0.0.1",
      where));
}

}  // namespace

const SinkKind genicam_sink{
    "genicam", "genicam:ADDRESS",
    [](const std::string& where) { static_cast<void>(address_from(where)); },
    [](const std::string& where, PublishedRun run) -> std::unique_ptr<CloudSink> {
      throw_if(!run.has_points, "`publish genicam:{}`: a 3-D camera needs points; give a `scanner`",
               where);
      return std::make_unique<GenicamSink>(address_from(where), std::move(run));
    }};

}  // namespace slipstream
