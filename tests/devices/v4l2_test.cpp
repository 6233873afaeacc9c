#include "devices/v4l2.h"

#include <cerrno>
#include <cstring>
#include <deque>
#include <map>
#include <memory>
#include <vector>

#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include "slipstream/camera.h"
#include "slipstream/error.h"
#include "tests/io/expect_error.h"

namespace slipstream::v4l2_test {
using namespace std::chrono_literals;

/// A fake V4L2 camera: its capabilities and the settings it received.
struct MadeUpCamera {
  std::uint32_t pixel_format = V4L2_PIX_FMT_GREY;
  Size size{6, 4};
  std::uint32_t row_bytes = 8;  ///< padded
  bool plugged_in = true;
  std::uint32_t sequence = 0;           ///< of the next frame
  std::uint32_t flags = 0;              ///< of the next frame
  std::optional<std::uint32_t> used{};  ///< bytes of the next frame, if incomplete
  int frames_ready = 0;
  std::vector<std::uint8_t> jpeg{};  ///< of the next frames, if the camera compresses

  std::map<std::uint32_t, int> controls{{V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_AUTO},
                                        {V4L2_CID_EXPOSURE_ABSOLUTE, 0},
                                        {V4L2_CID_GAIN, 0}};
  double rate = 30;
  std::vector<std::vector<std::uint8_t>> buffers;
  std::deque<std::uint32_t> queued;
  bool streaming = false;
  int mapped = 0;
  std::optional<unsigned long> refused{};  ///< the request that fails

  /// Byte `at` of frame `sequence`.
  static std::uint8_t byte(std::uint32_t sequence, std::size_t at) {
    return static_cast<std::uint8_t>(17 * sequence + 3 * at);
  }
};

class MadeUpDevice : public VideoDevice {
 public:
  explicit MadeUpDevice(std::shared_ptr<MadeUpCamera> camera) : camera_(std::move(camera)) {}

  int control(unsigned long request, void* argument) override {
    if (!camera_->plugged_in) return fail(ENODEV);
    if (request == camera_->refused) return fail(EIO);
    switch (request) {
      case VIDIOC_QUERYCAP:
        static_cast<v4l2_capability*>(argument)->capabilities =
            V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
        return 0;
      case VIDIOC_S_FMT:
        return set_format(*static_cast<v4l2_format*>(argument));
      case VIDIOC_S_PARM: {
        const auto& time = static_cast<v4l2_streamparm*>(argument)->parm.capture.timeperframe;
        camera_->rate = static_cast<double>(time.denominator) / time.numerator;
        return 0;
      }
      case VIDIOC_S_CTRL: {
        const auto* control = static_cast<v4l2_control*>(argument);
        if (!camera_->controls.contains(control->id)) return fail(EINVAL);
        camera_->controls[control->id] = control->value;
        return 0;
      }
      case VIDIOC_G_CTRL: {
        auto* control = static_cast<v4l2_control*>(argument);
        if (!camera_->controls.contains(control->id)) return fail(EINVAL);
        control->value = camera_->controls[control->id];
        return 0;
      }
      case VIDIOC_QUERYCTRL: {
        auto* range = static_cast<v4l2_queryctrl*>(argument);
        if (!camera_->controls.contains(range->id)) return fail(EINVAL);
        range->minimum = 1;
        range->maximum = 500;
        return 0;
      }
      case VIDIOC_REQBUFS: {
        auto& asked = *static_cast<v4l2_requestbuffers*>(argument);
        asked.count = std::min(asked.count, 3U);  // fewer than requested
        camera_->buffers.assign(asked.count, std::vector<std::uint8_t>(length()));
        return 0;
      }
      case VIDIOC_QUERYBUF: {
        auto& buffer = *static_cast<v4l2_buffer*>(argument);
        buffer.length = static_cast<std::uint32_t>(length());
        buffer.m.offset = buffer.index;
        return 0;
      }
      case VIDIOC_QBUF:
        camera_->queued.push_back(static_cast<v4l2_buffer*>(argument)->index);
        return 0;
      case VIDIOC_DQBUF:
        return fetch(*static_cast<v4l2_buffer*>(argument));
      case VIDIOC_STREAMON:
        camera_->sequence = 0;
        camera_->streaming = true;
        return 0;
      case VIDIOC_STREAMOFF:
        camera_->streaming = false;
        camera_->queued.clear();
        return 0;
      default:
        return fail(ENOTTY);
    }
  }

  void* map(std::size_t, std::size_t offset) override {
    ++camera_->mapped;
    return camera_->buffers[offset].data();
  }
  void unmap(void*, std::size_t) override { --camera_->mapped; }
  bool wait(std::chrono::milliseconds) override {
    return !camera_->plugged_in || (camera_->streaming && camera_->frames_ready > 0);
  }

 private:
  static int fail(int reason) {
    errno = reason;
    return -1;
  }
  [[nodiscard]] std::size_t length() const {
    return std::size_t{camera_->row_bytes} * static_cast<std::size_t>(camera_->size.height);
  }

  int set_format(v4l2_format& format) const {
    format.fmt.pix.pixelformat = camera_->pixel_format;
    format.fmt.pix.width = static_cast<std::uint32_t>(camera_->size.width);
    format.fmt.pix.height = static_cast<std::uint32_t>(camera_->size.height);
    format.fmt.pix.bytesperline = camera_->row_bytes;
    return 0;
  }

  int fetch(v4l2_buffer& buffer) {
    if (camera_->frames_ready == 0 || camera_->queued.empty()) return fail(EAGAIN);
    --camera_->frames_ready;
    buffer.index = camera_->queued.front();
    camera_->queued.pop_front();
    std::vector<std::uint8_t>& bytes = camera_->buffers[buffer.index];
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      bytes[i] = MadeUpCamera::byte(camera_->sequence, i);
    }
    std::ranges::copy(camera_->jpeg, bytes.begin());
    buffer.bytesused = camera_->used.value_or(static_cast<std::uint32_t>(bytes.size()));
    buffer.flags = camera_->flags;
    buffer.sequence = camera_->sequence++;
    buffer.timestamp = {12, 345678};
    return 0;
  }

  std::shared_ptr<MadeUpCamera> camera_;
};

std::function<std::unique_ptr<VideoDevice>()> opener(const std::shared_ptr<MadeUpCamera>& camera) {
  return [camera]() -> std::unique_ptr<VideoDevice> {
    if (!camera->plugged_in) throw WorldError("not there");
    return std::make_unique<MadeUpDevice>(camera);
  };
}

CameraSettings small_frames(PixelFormat format = PixelFormat::mono8) {
  return {.region = Rectangle{.size = {6, 4}}, .pixel_format = format, .cycle = 4};
}

TEST(V4l2Source, GivesTheGreyFramesOfTheDriver) {
  const auto camera = std::make_shared<MadeUpCamera>();
  {
    const auto source = open_v4l2_camera("made up", opener(camera), small_frames());
    source->start();
    EXPECT_EQ(camera->mapped, 3);
    Frame frame(source->format());
    EXPECT_EQ(source->next(frame, 0ms), Arrival::nothing);
    for (std::uint32_t i = 0; i < 20; ++i) {
      camera->frames_ready = 1;
      ASSERT_EQ(source->next(frame, 0ms), Arrival::frame);
      EXPECT_EQ(frame.stamp.sequence, i);
      EXPECT_EQ(frame.stamp.device_time, 12s + 345678us);
      const auto& pixels = std::get<0>(frame.pixels);
      for (int row = 0; row < 4; ++row) {
        for (int column = 0; column < 6; ++column) {
          EXPECT_EQ(pixels(column, row),
                    MadeUpCamera::byte(i, static_cast<std::size_t>(8 * row + column)));
        }
      }
    }
    EXPECT_EQ(source->counters().delivered, 20U);
    EXPECT_EQ(source->counters().lost, 0U);
  }
  EXPECT_EQ(camera->mapped, 0);
  EXPECT_FALSE(camera->streaming);
}

TEST(V4l2Source, TakesTheLumaOfYuyv) {
  const auto camera = std::make_shared<MadeUpCamera>();
  camera->pixel_format = V4L2_PIX_FMT_YUYV;
  camera->row_bytes = 12;
  const auto source = open_v4l2_camera("made up", opener(camera), small_frames());
  source->start();
  camera->frames_ready = 1;
  Frame frame(source->format());
  ASSERT_EQ(source->next(frame, 0ms), Arrival::frame);
  EXPECT_EQ(std::get<0>(frame.pixels)(5, 3), MadeUpCamera::byte(0, 3 * 12 + 10));
}

TEST(V4l2Source, GivesColoursSideBySide) {
  const auto camera = std::make_shared<MadeUpCamera>();
  camera->pixel_format = V4L2_PIX_FMT_RGB24;
  camera->row_bytes = 20;
  const auto source = open_v4l2_camera("made up", opener(camera), small_frames(PixelFormat::rgb8));
  EXPECT_EQ(source->format(), (FrameFormat{{18, 4}, 8}));
  source->start();
  camera->frames_ready = 1;
  Frame frame(source->format());
  ASSERT_EQ(source->next(frame, 0ms), Arrival::frame);
  EXPECT_EQ(std::get<0>(frame.pixels)(17, 3), MadeUpCamera::byte(0, 3 * 20 + 17));
  camera->pixel_format = V4L2_PIX_FMT_GREY;
  expect_error(
      [&] { (void)open_v4l2_camera("grey", opener(camera), small_frames(PixelFormat::rgb8)); },
      {"no colour frames", "RGB24"});
}

/// 6x4 pixels of grey level 77.
constexpr std::string_view grey_jpeg =
    "ffd8ffe000104a46494600010100000100010000ffdb00430003020203020203030303040303040508050504"
    "04050a070706080c0a0c0c0b0a0b0b0d0e12100d0e110e0b0b1016101113141515150c0f1718161418121415"
    "14ffc0000b080004000601011100ffc4001f0000010501010101010100000000000000000102030405060708"
    "090a0bffc400b5100002010303020403050504040000017d0102030004110512213141061351610722711432"
    "8191a1082342b1c11552d1f02433627282090a161718191a25262728292a3435363738393a43444546474849"
    "4a535455565758595a636465666768696a737475767778797a838485868788898a92939495969798999aa2a3"
    "a4a5a6a7a8a9aab2b3b4b5b6b7b8b9bac2c3c4c5c6c7c8c9cad2d3d4d5d6d7d8d9dae1e2e3e4e5e6e7e8e9ea"
    "f1f2f3f4f5f6f7f8f9faffda0008010100003f00f9debfffd9";

TEST(V4l2Source, DecodesJpegsIfAsked) {
  const auto camera = std::make_shared<MadeUpCamera>();
  camera->pixel_format = V4L2_PIX_FMT_MJPEG;
  camera->row_bytes = 400;
  for (std::size_t i = 0; i < grey_jpeg.size(); i += 2) {
    camera->jpeg.push_back(
        static_cast<std::uint8_t>(std::stoi(std::string(grey_jpeg.substr(i, 2)), nullptr, 16)));
  }
  const auto size = static_cast<std::uint32_t>(camera->jpeg.size());
  camera->used = size;
  const auto source = open_v4l2_camera("made up", opener(camera), small_frames(PixelFormat::mjpg));
  source->start();
  camera->frames_ready = 3;
  Frame frame(source->format());
  ASSERT_EQ(source->next(frame, 0ms), Arrival::frame);
  for (const std::uint8_t level : std::get<0>(frame.pixels)) EXPECT_NEAR(level, 77, 1);
  camera->used = size / 2;
  EXPECT_EQ(source->next(frame, 0ms), Arrival::damaged);
  camera->used = 0;
  EXPECT_EQ(source->next(frame, 0ms), Arrival::damaged);
}

TEST(V4l2Source, GivesMoreBitsAsTheyAre) {
  for (const auto& [code, format] : {std::pair{V4L2_PIX_FMT_Y10, PixelFormat::mono10},
                                     {V4L2_PIX_FMT_Y12, PixelFormat::mono12}}) {
    const auto camera = std::make_shared<MadeUpCamera>();
    camera->pixel_format = code;
    camera->row_bytes = 16;
    const auto source = open_v4l2_camera("made up", opener(camera), small_frames(format));
    source->start();
    camera->frames_ready = 1;
    Frame frame(source->format());
    ASSERT_EQ(source->next(frame, 0ms), Arrival::frame);
    EXPECT_EQ(frame.bits, bits_of(format));
    EXPECT_EQ(std::get<1>(frame.pixels)(2, 1), MadeUpCamera::byte(0, 20) | MadeUpCamera::byte(0, 21)
                                                                               << 8);
  }
}

TEST(V4l2Source, MakesAMosaicGrey) {
  const auto camera = std::make_shared<MadeUpCamera>();
  camera->pixel_format = V4L2_PIX_FMT_SGBRG8;
  CameraSettings settings = small_frames();
  set_pixel_format(settings, "BayerGB8");
  const auto source = open_v4l2_camera("made up", opener(camera), settings);
  source->start();
  camera->frames_ready = 1;
  Frame frame(source->format());
  ASSERT_EQ(source->next(frame, 0ms), Arrival::frame);
  // Bytes are a ramp over columns and rows, which the weights keep.
  EXPECT_EQ(std::get<0>(frame.pixels)(2, 1), MadeUpCamera::byte(0, 8 + 2));
  set_pixel_format(settings, "BayerRG8");
  expect_error([&] { (void)open_v4l2_camera("made up", opener(camera), settings); }, {"BayerRG8"});
  set_pixel_format(settings, "Mono8");
  expect_error([&] { (void)open_v4l2_camera("made up", opener(camera), settings); }, {"GREY"});
}

TEST(V4l2Source, CountsWhatTheDriverDropped) {
  const auto camera = std::make_shared<MadeUpCamera>();
  const auto source = open_v4l2_camera("made up", opener(camera), small_frames());
  source->start();
  Frame frame(source->format());
  const auto take = [&] {
    camera->frames_ready = 1;
    return source->next(frame, 0ms);
  };
  ASSERT_EQ(take(), Arrival::frame);
  camera->sequence += 3;
  ASSERT_EQ(take(), Arrival::frame);
  EXPECT_EQ(frame.stamp.sequence, 4U);
  camera->flags = V4L2_BUF_FLAG_ERROR;
  EXPECT_EQ(take(), Arrival::damaged);
  camera->flags = 0;
  camera->used = 10;
  EXPECT_EQ(take(), Arrival::damaged);
  camera->used.reset();
  ASSERT_EQ(take(), Arrival::frame);
  EXPECT_EQ(frame.stamp.sequence, 7U);
  EXPECT_EQ(source->counters().lost, 5U);
}

TEST(V4l2Source, IsFoundAgainWhenItIsPluggedInAgain) {
  const auto camera = std::make_shared<MadeUpCamera>();
  const auto source = open_v4l2_camera("made up", opener(camera), small_frames());
  source->start();
  Frame frame(source->format());
  for (int i = 0; i < 6; ++i) {
    camera->frames_ready = 1;
    ASSERT_EQ(source->next(frame, 0ms), Arrival::frame);
  }
  camera->plugged_in = false;
  for (int i = 0; i < 3; ++i) EXPECT_EQ(source->next(frame, 1ms), Arrival::nothing);
  EXPECT_EQ(source->state(), "camera made up is lost; searching for it");
  camera->plugged_in = true;
  camera->frames_ready = 1;
  EXPECT_EQ(source->next(frame, 1ms), Arrival::nothing);
  ASSERT_EQ(source->next(frame, 1ms), Arrival::frame);
  EXPECT_EQ(source->state(), "");
  EXPECT_EQ(source->counters().reconnects, 1U);
  EXPECT_EQ(frame.stamp.sequence, 8U) << "at a multiple of the patterns, with a gap";
}

TEST(V4l2Source, StartsAgainThoughItWasGoneAtTheStop) {
  const auto camera = std::make_shared<MadeUpCamera>();
  const auto source = open_v4l2_camera("made up", opener(camera), small_frames());
  source->start();
  Frame frame(source->format());
  camera->plugged_in = false;
  EXPECT_EQ(source->next(frame, 1ms), Arrival::nothing);
  source->stop();
  EXPECT_THROW(source->start(), WorldError);
  EXPECT_NE(source->state(), "");
  camera->plugged_in = true;
  source->start();
  EXPECT_EQ(source->state(), "");
  EXPECT_EQ(source->counters().reconnects, 1U);
  camera->frames_ready = 1;
  EXPECT_EQ(source->next(frame, 1ms), Arrival::frame);
}

TEST(V4l2Source, StartsAgainAfterAStartThatFailedHalfWay) {
  const auto camera = std::make_shared<MadeUpCamera>();
  const auto source = open_v4l2_camera("made up", opener(camera), small_frames());
  for (const unsigned long request :
       {VIDIOC_REQBUFS, VIDIOC_QUERYBUF, VIDIOC_QBUF, VIDIOC_STREAMON}) {
    camera->refused = request;
    EXPECT_THROW(source->start(), WorldError);
    EXPECT_EQ(camera->mapped, 0);
    EXPECT_TRUE(camera->queued.empty());
  }
  camera->refused.reset();
  source->start();
  EXPECT_EQ(camera->mapped, 3);
  Frame frame(source->format());
  camera->frames_ready = 1;
  EXPECT_EQ(source->next(frame, 1ms), Arrival::frame);
}

TEST(V4l2Source, SaysWhyTheDriverRefusesARate) {
  const auto camera = std::make_shared<MadeUpCamera>();
  camera->refused = VIDIOC_S_PARM;
  CameraSettings settings = small_frames();
  settings.frame_rate = 120;
  errno = 0;
  expect_error([&] { (void)open_v4l2_camera("made up", opener(camera), settings); },
               {"a rate of 120 Hz", std::strerror(EIO)});
}

TEST(V4l2Source, SetsRateAndLight) {
  const auto camera = std::make_shared<MadeUpCamera>();
  CameraSettings settings = small_frames();
  settings.frame_rate = 120;
  settings.exposure = 0.002;
  settings.gain = 7;
  const auto source = open_v4l2_camera("made up", opener(camera), settings);
  EXPECT_EQ(camera->rate, 120);
  EXPECT_EQ(camera->controls[V4L2_CID_EXPOSURE_AUTO], V4L2_EXPOSURE_MANUAL);
  EXPECT_EQ(camera->controls[V4L2_CID_EXPOSURE_ABSOLUTE], 20);
  EXPECT_EQ(camera->controls[V4L2_CID_GAIN], 7);
}

TEST(V4l2Source, IsSetWhileFramesComeAndAgainWhenItIsBack) {
  const auto camera = std::make_shared<MadeUpCamera>();
  const auto source = open_v4l2_camera("made up", opener(camera), small_frames());
  source->start();
  CameraControls& controls = *source->controls();
  controls.set_control(CameraControl::exposure, 12.5);
  const auto exposure = controls.control(CameraControl::exposure);
  ASSERT_TRUE(exposure);
  EXPECT_DOUBLE_EQ(exposure->value, 12.5);
  EXPECT_DOUBLE_EQ(exposure->least, 0.1);
  EXPECT_DOUBLE_EQ(exposure->most, 50);
  EXPECT_FALSE(controls.control(CameraControl::frame_rate));
  EXPECT_THROW(controls.set_control(CameraControl::exposure, 0.001), Error);

  camera->plugged_in = false;
  Frame frame(source->format());
  EXPECT_EQ(source->next(frame, 1ms), Arrival::nothing);
  EXPECT_FALSE(controls.control(CameraControl::exposure)) << "it is gone";
  controls.set_control(CameraControl::gain, 9);
  camera->controls[V4L2_CID_EXPOSURE_ABSOLUTE] = 1;
  camera->plugged_in = true;
  EXPECT_EQ(source->next(frame, 1ms), Arrival::nothing);
  EXPECT_EQ(camera->controls[V4L2_CID_EXPOSURE_ABSOLUTE], 125);
  EXPECT_EQ(camera->controls[V4L2_CID_GAIN], 9);
}

TEST(V4l2Source, SaysWhatTheCameraDoesNotTake) {
  const auto camera = std::make_shared<MadeUpCamera>();
  const auto open_with = [&](const auto& change) {
    CameraSettings settings = small_frames();
    change(settings);
    (void)open_v4l2_camera("made up", opener(camera), settings);
  };
  expect_error([&] { open_with([](auto& to) {
                       to.region->size = {640, 480};
                     }); },
               {"made up", "640x480", "6x4"});
  expect_error([&] { open_with([](auto& to) { to.pixel_format = PixelFormat::mono12; }); },
               {"12 bits"});
  expect_error([&] { open_with([](auto& to) { to.exposure = 0; }); }, {"exposure of 0 s"});
  expect_error([&] { open_with([](auto& to) { to.frame_rate = -2; }); }, {"-2"});
  camera->controls.erase(V4L2_CID_GAIN);
  expect_error([&] { open_with([](auto& to) { to.gain = 3; }); }, {"gain of 3"});
  EXPECT_THROW(open_camera("v4l2:4000", {}), WorldError);
}

TEST(V4l2Source, RefusesWhatNoSuchCameraHas) {
  const auto camera = std::make_shared<MadeUpCamera>();
  const auto open_with = [&](const CameraSettings& settings) {
    (void)open_v4l2_camera("made up", opener(camera), settings);
  };
  expect_error([&] { open_with({.pixel_format = PixelFormat::mono10p}); },
               {"Mono10p", "Mono8, Mono10, Mono12, RGB8 or MJPG, or BayerRG8"});
  expect_error([&] { open_with({.region = Rectangle{8, 0, {6, 4}}}); }, {"6x4+8+0", "640x480"});
  expect_error([&] { open_with({.trigger = "Line1"}); }, {"Line1", "have no trigger"});
  expect_error([&] { open_with({.gain = 1e12}); }, {"`gain 1000000000000`"});
  expect_error([&] { open_with({.cycle = 0}); }, {"0 patterns"});
}

TEST(V4l2Cameras, AreListedWithoutFailure) {
  for (const CameraDescription& camera : list_v4l2_cameras()) {
    EXPECT_EQ(camera.protocol, "V4L2");
  }
}

}  // namespace slipstream::v4l2_test
