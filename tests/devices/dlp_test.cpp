// DLP controllers, on a stand-in for both.
#include "devices/dlp.h"

#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "devices/hid_port.h"
#include "slipstream/pattern_set.h"
#include "slipstream/strategy.h"
#include "tests/app/program.h"
#include "tests/devices/dlp_double.h"
#include "tests/view/desktop.h"

namespace slipstream::dlp {
namespace {

using Patterns = std::vector<Image<std::uint8_t>>;

/// A monitor.
class Screen : public PatternSink {
 public:
  explicit Screen(Size size) : size_(size) {}
  [[nodiscard]] std::optional<Size> size() const override { return size_; }
  void load(Patterns patterns) override { loaded = patterns.size(); }
  void show(std::size_t n) override { seen.push_back(n); }
  [[nodiscard]] std::uint64_t shown() const override { return seen.size(); }
  [[nodiscard]] std::string state() const override { return {}; }

  std::size_t loaded = 0;
  std::vector<std::size_t> seen;

 private:
  Size size_;
};

constexpr Size size_350{912, 1140}, size_6500{1920, 1080}, size_5500{1024, 768};

DlpSettings quick(double rate) {
  return {
      .rate = rate, .timeout = std::chrono::milliseconds(0), .poll = std::chrono::milliseconds(0)};
}

DlpSink sink_on(ControllerDouble& device, Controller controller, PatternSink* screen, double rate) {
  return DlpSink({controller, device.port()}, screen, quick(rate));
}

/// Patterns of chance, 0 or 255, with equal rows among them.
Patterns noise(Size size, int count, int seed) {
  std::mt19937 chance(static_cast<unsigned>(seed));
  Patterns patterns(static_cast<std::size_t>(count), Image<std::uint8_t>(size));
  for (auto& pattern : patterns) {
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        pattern(x, y) = y % 3 == 1 ? pattern(x, y - 1) : (chance() >> 9) % 4 == 0 ? 255 : 0;
      }
    }
  }
  return patterns;
}

/// As in the guide's read and write examples (1.2.2, 1.2.3): flags, sequence, length, command,
/// data.
struct Sent {
  int sequence = 0;
  std::vector<std::string> reports{};

  void add(int flags, std::string bytes, std::size_t length) {
    std::string report =
        fmt::format("{:02X} {:02X} {:02X} 00 {}", flags, ++sequence, length, bytes);
    while (report.ends_with(" 00")) report.resize(report.size() - 3);
    reports.push_back(std::move(report));
  }
  void read(const std::string& command, int times = 1) {
    for (; times > 0; --times) add(0xC0, command, 2);
  }
  void write(const std::string& bytes) { add(0x40, bytes, (bytes.size() + 1) / 3); }
};

TEST(DlpDlpc350, TakesThreePatternsFromEachPicture) {
  ControllerDouble device(Controller::dlpc350);
  const auto found = device.registers;
  Screen screen(size_350);
  {
    DlpSink sink = sink_on(device, Controller::dlpc350, &screen, 60);
    EXPECT_EQ(sink.description(), "DLP4500, 7 bits, 5388 us per pattern");
    sink.load(Patterns(2, Image<std::uint8_t>(size_350)));
    EXPECT_EQ(screen.loaded, 2U);
    EXPECT_EQ(device.registers, found);
    for (const std::size_t n : {0, 1, 0}) sink.show(n);
    EXPECT_EQ(screen.seen, (std::vector<std::size_t>{0, 1, 0}));
    EXPECT_TRUE(device.running);
    sink.give_back();
  }
  Sent sent;
  sent.read("0C 1A");  // main status: awake
  sent.read("1B 1A");  // display mode
  sent.write("1B 1A 01");
  sent.read("1B 1A", 3);
  sent.read("07 1A");  // LED enable
  sent.write("07 1A 08");
  sent.read("22 1A");  // pattern source
  sent.write("22 1A 00");
  sent.read("31 1A");  // pattern table control
  sent.write("31 1A 02 01 02 00");
  sent.read("23 1A");  // trigger mode
  sent.write("23 1A 00");
  sent.read("29 1A");  // 5388 us
  sent.write("29 1A 0C 15 00 00 0C 15 00 00");
  sent.read("1D 1A");  // trigger outputs
  sent.write("1D 1A 00 BB 00");
  sent.read("1E 1A");
  sent.write("1E 1A 00 BB");
  sent.write("33 1A 02");  // pattern table: red, green, blue; 7 bits, white
  sent.write("32 1A 00");
  sent.write("34 1A 05 77 04 03 77 00 0B 77 02");
  sent.write("33 1A 00");
  sent.write("1A 1A 00");  // validation
  sent.read("1A 1A", 5);
  sent.write("24 1A 02");
  sent.read("0C 1A");
  sent.write("24 1A 00");  // back
  sent.write("1E 1A 02 B0");
  sent.write("1D 1A 02 BB BC");
  sent.write("29 1A 10 40 00 00 1A 41 00 00");
  sent.write("23 1A 01");
  sent.write("31 1A 05 00 05 01");
  sent.write("22 1A 03");
  sent.write("07 1A 07");
  sent.write("1B 1A 00");
  EXPECT_EQ(device.reports, sent.reports);
  EXPECT_EQ(device.violations, std::vector<std::string>{});
  EXPECT_EQ(device.registers,
            (device.registers[0x1A32] = {0}, device.registers[0x1A33] = {0}, found));
}

TEST(DlpDlpc900, TakesThreePatternsFromEachPicture) {
  ControllerDouble device(Controller::dlpc900);
  device.set_mode(1);  // pictures from its flash memory
  Screen screen(size_6500);
  {
    DlpSink sink = sink_on(device, Controller::dlpc900, &screen, 60);
    EXPECT_EQ(sink.description(), "DLP6500, 8 bits, 5388 us per pattern");
    sink.show(0);
    sink.show(1);
  }
  Sent sent;
  sent.read("06 02");  // hardware type
  sent.read("0C 1A");
  sent.read("1B 1A");
  sent.write("24 1A 00");
  sent.read("0C 1A");
  sent.write("1B 1A 00");  // to video, until the source is locked
  sent.read("0C 1A");
  sent.write("1B 1A 02");
  sent.read("1B 1A", 6);
  sent.read("07 1A");
  sent.write("07 1A 08");
  sent.read("1D 1A");
  sent.write("1D 1A 00 00 00 00 00");
  sent.read("1E 1A");
  sent.write("1E 1A 00 00 00 14 00");
  // Index, exposure, 8 bits and white (first: waits for the refresh), dark time, trigger, place
  sent.write("34 1A 00 00 0C 15 00 FE 00 00 00 00 00 40");
  sent.write("34 1A 01 00 0C 15 00 7E 00 00 00 00 00 00");
  sent.write("34 1A 02 00 0C 15 00 7E 00 00 00 00 00 80");
  sent.write("31 1A 03 00 00 00 00 00");
  sent.write("24 1A 02");
  sent.read("0C 1A");
  sent.write("24 1A 00");  // back
  sent.write("1E 1A 01 32 00 14 00");
  sent.write("1D 1A 01 07 00 03 00");
  sent.write("07 1A 07");
  sent.write("1B 1A 01");
  EXPECT_EQ(device.reports, sent.reports);
  EXPECT_EQ(device.violations, std::vector<std::string>{});
}

TEST(DlpDlpc900, ShowsOneBitPatternsFromItsMemory) {
  ControllerDouble device(Controller::dlpc900, 5);
  const auto found = device.registers;
  const Patterns patterns = noise(size_5500, 27, 1);
  {
    DlpSink sink = sink_on(device, Controller::dlpc900, nullptr, 1000);
    EXPECT_EQ(sink.size(), size_5500);
    EXPECT_EQ(sink.description(), "DLP5500, 1 bits, 1000 us per pattern");
    sink.load(patterns);
    sink.loop();
    EXPECT_TRUE(device.running);
    ASSERT_EQ(device.lut.size(), 27U);
    ASSERT_EQ(device.pictures.size(), 2U);
    for (std::size_t n = 0; n < patterns.size(); ++n) {
      const Bytes& line = device.lut[n];
      EXPECT_EQ(line, (Bytes{static_cast<std::uint8_t>(n), 0, 0xE8, 0x03, 0, 0x70, 0, 0, 0, 0,
                             line[10], line[11]}));
      const std::uint32_t place = number_in(line, 10, 2), index = place & 0x7ff, bit = place >> 11;
      const Image<std::uint32_t> picture = decoded(device.pictures.at({false, index}));
      ASSERT_EQ(picture.size(), size_5500);
      for (std::size_t i = 0; i < picture.pixel_count(); ++i) {
        ASSERT_EQ((picture.begin()[i] >> bit & 1) * 255, patterns[n].begin()[i]) << n << ' ' << i;
      }
    }
    sink.show(26);
    EXPECT_EQ(device.registers[0x1A32], (Bytes{1, 0, 0, 0, 0, 0, 26, 0}));
    EXPECT_TRUE(device.running);
  }
  EXPECT_EQ(device.violations, std::vector<std::string>{});
  for (const int setting : {0x1A07, 0x1A1B, 0x1A1D, 0x1A1E}) {
    EXPECT_EQ(device.registers[setting], found.at(setting));
  }
}

TEST(DlpDlpc900, GivesEachHalfOfALargeChipToItsController) {
  ControllerDouble device(Controller::dlpc900, 2);
  const Size size{2560, 1600};
  Patterns patterns(1, Image<std::uint8_t>(size));
  for (int y = 0; y < size.height; ++y) patterns[0](y, y) = 255;
  DlpSink sink = sink_on(device, Controller::dlpc900, nullptr, 120);
  sink.load(patterns);
  sink.loop();
  for (const bool right : {false, true}) {
    const Image<std::uint32_t> half = decoded(device.pictures.at({right, 0}));
    ASSERT_EQ(half.size(), (Size{1280, 1600}));
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < 1280; ++x) {
        ASSERT_EQ(half(x, y) * 255, patterns[0](x + (right ? 1280 : 0), y));
      }
    }
  }
  EXPECT_EQ(device.violations, std::vector<std::string>{});
}

TEST(DlpDlpc900, StopsLoadingOnRequest) {
  ControllerDouble device(Controller::dlpc900, 5);
  DlpSettings settings = quick(120);
  settings.ends = [&] { return device.commands > 30; };
  const auto found = device.registers;
  {
    DlpSink sink({Controller::dlpc900, device.port()}, nullptr, settings);
    EXPECT_THROW(sink.load(noise(size_5500, 24, 2)), Error);
  }
  EXPECT_LT(device.commands, 60);
  EXPECT_EQ(device.registers[0x1A1B], found.at(0x1A1B));
}

TEST(DlpGuides, EncodedRunsAreThoseOfTheExample) {  // table 2-116, and 0x1234 as length
  const Bytes runs{0x03, 4,  5,  6,  5,    0x77, 0x77, 0x77, 0,    3, 4, 5, 6, 7, 8,
                   9,    10, 11, 12, 0x82, 0x01, 0x78, 0x9A, 0xBC, 0, 0, 1, 1, 2, 3,
                   0,    1,  9,  1,  7,    7,    7,    0x82, 0x01, 1, 1, 1, 0, 1, 0};
  Bytes picture{0x53, 0x70, 0x6C, 0x64, 141, 0, 2, 0};
  const std::size_t padded = (runs.size() + 3) / 4 * 4;
  picture.push_back(static_cast<std::uint8_t>(padded));
  picture.insert(picture.end(), 3, 0);
  picture.insert(picture.end(), 8, 0xff);
  picture.insert(picture.end(), {0, 0, 0, 0, 0, 2, 1});
  picture.insert(picture.end(), 21, 0);
  picture.insert(picture.end(), runs.begin(), runs.end());
  picture.resize(48 + padded);
  const Image<std::uint32_t> image = decoded(picture);
  EXPECT_EQ(image(0, 0), 0x040506U);
  EXPECT_EQ(image(9, 0), 0x070809U);
  EXPECT_EQ(image(140, 0), 0x789ABCU);
  EXPECT_EQ(image(0, 1), 0x010203U);
  EXPECT_EQ(image(1, 1), 0x040506U);
  EXPECT_EQ(image(10, 1), 0x070707U);
}

TEST(DlpGuides, ExposuresAreNoShorterThanTheChipAllows) {
  struct Case {
    Controller controller;
    std::uint8_t chip;
    Size size;
    double refresh_hz;
    const char* described;  ///< empty: refused
  };
  for (const Case& each : std::vector<Case>{
           {Controller::dlpc350, 0, size_350, 30, "DLP4500, 8 bits, 10777 us per pattern"},
           {Controller::dlpc350, 0, size_350, 38, "DLP4500, 8 bits, 8508 us per pattern"},
           {Controller::dlpc350, 0, size_350, 40, "DLP4500, 7 bits, 8083 us per pattern"},
           {Controller::dlpc350, 0, size_350, 60, "DLP4500, 7 bits, 5388 us per pattern"},
           {Controller::dlpc350, 0, size_350, 120, ""},
           {Controller::dlpc900, 1, size_6500, 60, "DLP6500, 8 bits, 5388 us per pattern"},
           {Controller::dlpc900, 1, size_6500, 120, "DLP6500, 7 bits, 2694 us per pattern"},
           {Controller::dlpc900, 1, size_6500, 240, ""},
           {Controller::dlpc900, 4, {2048, 1200}, 120, "DLP500YX, 8 bits, 2694 us per pattern"}}) {
    ControllerDouble device(each.controller, each.chip);
    Screen screen(each.size);
    const std::string wanted = each.described;
    if (wanted.empty()) {
      EXPECT_THROW(sink_on(device, each.controller, &screen, each.refresh_hz), Error);
    } else {
      EXPECT_EQ(sink_on(device, each.controller, &screen, each.refresh_hz).description(), wanted);
    }
    EXPECT_EQ(device.violations, std::vector<std::string>{});
  }
  ControllerDouble device(Controller::dlpc900);
  EXPECT_NO_THROW(sink_on(device, Controller::dlpc900, nullptr, 9523));
  for (const double rate : {9524.0, 0.0, -1.0, 0.05, std::nan("")}) {
    ControllerDouble other(Controller::dlpc900);
    EXPECT_THROW(sink_on(other, Controller::dlpc900, nullptr, rate), Error) << rate;
  }
}

template <class Thrown>
std::string message_of(const std::function<void()>& act) {
  try {
    act();
  } catch (const Thrown& error) {
    return error.what();
  }
  return "nothing";
}

TEST(DlpErrors, AreOneLine) {
  const auto shown_on = [](ControllerDouble& device, Controller controller) {
    Screen screen(controller == Controller::dlpc350 ? size_350 : size_6500);
    return message_of<WorldError>([&] { sink_on(device, controller, &screen, 60).show(0); });
  };
  ControllerDouble invalid(Controller::dlpc350), parked(Controller::dlpc350),
      stopped(Controller::dlpc350);
  invalid.verdict = 0x11;
  parked.is_parked = true;
  stopped.starts = false;
  EXPECT_EQ(shown_on(invalid, Controller::dlpc350),
            "the projector rejects the exposure or the patterns; hardware status 0x01");
  EXPECT_EQ(shown_on(parked, Controller::dlpc350), "the projector is in standby");
  EXPECT_EQ(shown_on(stopped, Controller::dlpc350),
            "the projector does not start; hardware status 0x01");
  ControllerDouble dark(Controller::dlpc900), refusing(Controller::dlpc900),
      unknown(Controller::dlpc900, 9);
  dark.has_video = false;
  EXPECT_EQ(shown_on(dark, Controller::dlpc900),
            "the projector receives no picture; hardware status 0x01");
  refusing.fault_at = 9;
  refusing.fault = Fault::refused;
  EXPECT_EQ(shown_on(refusing, Controller::dlpc900).substr(0, 31),
            "projector: display mode (0x1A1B");
  EXPECT_EQ(shown_on(unknown, Controller::dlpc900), "the DLPC900 has an unknown chip");
  ControllerDouble other(Controller::dlpc350);
  Screen small({640, 480});
  EXPECT_EQ(message_of<Error>([&] { sink_on(other, Controller::dlpc350, &small, 60); }),
            "a DLP4500 requires a monitor of 912x1140; change its resolution");
  EXPECT_EQ(message_of<Error>([&] { sink_on(other, Controller::dlpc350, nullptr, 60); }),
            "a DLPC350 takes no patterns over USB; drop `binary`");
}

/// A run of both ways of showing patterns: start, pictures, stop.
void run(ControllerDouble& device, Controller controller, bool on_screen) {
  Screen screen(controller == Controller::dlpc350 ? size_350 : size_5500);
  DlpSink sink = sink_on(device, controller, on_screen ? &screen : nullptr, 60);
  if (!on_screen) sink.load(Patterns(1, Image<std::uint8_t>(size_5500)));
  for (const std::size_t n : {0, 0, 0}) sink.show(n);
  sink.give_back();
}

TEST(DlpErrors, TheSettingsAreRestoredWhateverFails) {
  struct Way {
    Controller controller;
    bool on_screen;
  };
  for (const auto& [controller, on_screen] :
       {Way{Controller::dlpc350, true}, Way{Controller::dlpc900, true},
        Way{Controller::dlpc900, false}}) {
    for (const Fault fault :
         {Fault::refused, Fault::silent, Fault::unplugged, Fault::late, Fault::malformed}) {
      int failures = 0;
      for (int at = 0;; ++at) {
        ControllerDouble device(controller, 5);
        device.set_mode(1);
        const auto found = device.registers;
        device.fault_at = at;
        device.fault = fault;
        bool failed = false;
        try {
          run(device, controller, on_screen);
        } catch (const WorldError& error) {
          failed = true;
          EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
        }
        if (device.commands <= at) break;  // after the last command
        failures += failed ? 1 : 0;
        EXPECT_FALSE(failed && fault == Fault::late) << at;
        for (const int setting : {0x1A07, 0x1A1B, 0x1A1D, 0x1A1E, 0x1A22, 0x1A23, 0x1A29}) {
          if (fault == Fault::unplugged || !found.contains(setting)) continue;
          EXPECT_EQ(device.registers[setting], found.at(setting))
              << fmt::format("{:04X} {}", setting, at);
        }
      }
      EXPECT_TRUE(fault == Fault::late || failures > 10);
    }
  }
}

TEST(DlpErrors, AnswersOfChanceNeitherHangNorCrash) {
  int ended = 0;
  for (unsigned seed = 0; seed < 3000; ++seed) {
    std::mt19937 chance(seed);
    const Controller controller = seed % 3 == 0 ? Controller::dlpc350 : Controller::dlpc900;
    ControllerDouble device(controller, 5);
    const unsigned wildness = 1 + seed % 40;
    device.answers = [&](const Report& usual) -> std::optional<Report> {
      Report report = usual;
      const auto kind = chance() % (3 * wildness);
      if (kind == 0) return std::nullopt;
      if (kind == 1) {
        for (auto& byte : report) byte = static_cast<std::uint8_t>(chance());
        if (chance() % 2 == 0) report[1] = usual[1];
      }
      if (kind == 2) report[chance() % 8] ^= static_cast<std::uint8_t>(1U << chance() % 8);
      return report;
    };
    try {
      run(device, controller, seed % 3 != 2);
      ++ended;
    } catch (const Error&) {  // of another chip
    } catch (const WorldError&) {
    }
    EXPECT_LT(device.reads, 5000) << seed;
  }
  EXPECT_GT(ended, 30);
}

TEST(DlpProgram, SaysThatThereIsNoProjector) {
  const Desktop desktop;
  const ProgramRun list = run_program({"project", "--list"});
  ASSERT_EQ(list.exit_code, 0) << list.err;
  if (list.out.find("--dlp") != std::string::npos) GTEST_SKIP() << "there is a projector";
  const ProgramRun run = run_program({"project", "--dlp"});
  EXPECT_NE(run.exit_code, 0);
  EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  EXPECT_NE(run.err.find("DLP"), std::string::npos) << run.err;
  const ProgramRun held = run_program({"project", "--dlp", "--hold", "2"});
  EXPECT_EQ(held.exit_code, 2);
  EXPECT_NE(held.err.find("--hold"), std::string::npos) << held.err;
}

}  // namespace
}  // namespace slipstream::dlp
