// live --monitor: the program's window on a virtual screen, seen by a camera on the network that
// looks at that screen's pixels.
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include <Eigen/Geometry>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/mman.h>
#include <unistd.h>

#include "base/statistics.h"
#include "slipstream/cloud_file.h"
#include "slipstream/scanner_file.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_world.h"
#include "tests/app/program.h"
#include "tests/devices/served_camera.h"
#include "tests/io/temporary_folder.h"
#include "tests/simulate/virtual_rig.h"
#include "tests/view/desktop.h"

namespace slipstream::stepped_program_test {

namespace fs = std::filesystem;

/// The pixels of an Xvfb screen, from the file in which it keeps them (X window dump).
class Screen {
 public:
  explicit Screen(const fs::path& folder) {
    const int file = ::open((folder / "Xvfb_screen0").c_str(), O_RDONLY);
    size_ = fs::file_size(folder / "Xvfb_screen0");
    data_ =
        static_cast<const unsigned char*>(::mmap(nullptr, size_, PROT_READ, MAP_SHARED, file, 0));
    ::close(file);
  }
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;
  ~Screen() { ::munmap(const_cast<unsigned char*>(data_), size_); }

  [[nodiscard]] int width() const { return word(4); }
  [[nodiscard]] int height() const { return word(5); }
  /// Grey level of a pixel.
  [[nodiscard]] int level(int column, int row) const {
    constexpr int header_size = 0, bytes_per_line = 12, colours = 19;
    constexpr std::size_t colour_bytes = 12, pixel_bytes = 4;
    const std::size_t begin = static_cast<std::size_t>(word(header_size)) +
                              colour_bytes * static_cast<std::size_t>(word(colours));
    const auto line = static_cast<std::size_t>(row);
    return data_[begin + line * static_cast<std::size_t>(word(bytes_per_line)) +
                 pixel_bytes * static_cast<std::size_t>(column) + 1];
  }

 private:
  [[nodiscard]] int word(int n) const {
    const unsigned char* const b = data_ + 4 * n;
    return b[0] << 24 | b[1] << 16 | b[2] << 8 | b[3];
  }

  const unsigned char* data_ = nullptr;
  std::size_t size_ = 0;
};

/// The screen's light along its middle row and its middle column, 0 to 1.
struct ScreenLight {
  std::vector<double> row, column;
};

/// Light at a place of a row or column, pixels.
double light_at(const std::vector<double>& light, double place) {
  const double inside = std::clamp(place, 0.0, static_cast<double>(light.size()) - 1.001);
  const auto before = static_cast<std::size_t>(inside);
  return light[before] + (inside - std::floor(inside)) * (light[before + 1] - light[before]);
}

/// A scene under whatever the screen shows, which varies along x or along y.
class LitScene {
 public:
  LitScene(const Screen& screen, const VirtualWorld& world)
      : screen_(screen),
        dark_(seen(world, 0)),
        bright_(seen(world, 255)),
        truth_(truth_along(Axis::x, world)),
        down_(truth_along(Axis::y, world).coordinate) {}

  /// The screen's light, exposed for 8 ms; taken anew if the machine was too slow.
  [[nodiscard]] ScreenLight light() const {
    using Clock = std::chrono::steady_clock;
    constexpr int samples = 4;
    constexpr std::chrono::milliseconds apart(2);
    const int width = screen_.width(), height = screen_.height();
    ScreenLight light;
    for (Clock::time_point begin{};
         light.row.empty() || Clock::now() > begin + (samples + 1) * apart;) {
      begin = Clock::now();
      light.row.assign(static_cast<std::size_t>(width), 0);
      light.column.assign(static_cast<std::size_t>(height), 0);
      for (int i = 0; i < samples; ++i) {
        for (int x = 0; x < width; ++x) {
          light.row[static_cast<std::size_t>(x)] +=
              screen_.level(x, height / 2) / (255.0 * samples);
        }
        for (int y = 0; y < height; ++y) {
          light.column[static_cast<std::size_t>(y)] +=
              screen_.level(width / 2, y) / (255.0 * samples);
        }
        std::this_thread::sleep_until(begin + (i + 1) * apart);
      }
    }
    return light;
  }
  [[nodiscard]] Image<std::uint8_t> picture() const {
    const ScreenLight light = this->light();
    const double middle = light_at(light.row, screen_.width() / 2);
    Image<std::uint8_t> picture(dark_.size());
    for (std::size_t i = 0; i < picture.pixel_count(); ++i) {
      const double x = truth_.coordinate.begin()[i] * screen_.width();
      const double y = down_.begin()[i] * screen_.height();
      const double dark = dark_.begin()[i], bright = bright_.begin()[i];
      // One of both is uniform, as bright as the middle.
      const double share = std::isfinite(x) && std::isfinite(y)
                               ? light_at(light.row, x) + light_at(light.column, y) - middle
                               : 0;
      picture.begin()[i] = static_cast<std::uint8_t>(
          std::lround(std::clamp(dark + share * (bright - dark), 0.0, 255.0)));
    }
    return picture;
  }
  [[nodiscard]] const Image<double>& depth() const { return truth_.depth; }

 private:
  static VirtualScan truth_along(Axis axis, const VirtualWorld& world) {
    return take_scan(world.scanner, world.scene, pattern_set(make_strategy("pmp", {}), axis),
                     world.photometry);
  }
  static Image<std::uint8_t> seen(const VirtualWorld& world, std::uint8_t level) {
    VirtualRig rig(world.scanner, world.scene, world.photometry);
    rig.load({Image<std::uint8_t>(world.scanner.projector.size, level)});
    rig.show(0);
    Frame frame(rig.format());
    rig.next(frame, {});
    return std::get<Image<std::uint8_t>>(frame.pixels);
  }

  const Screen& screen_;
  const Image<std::uint8_t> dark_, bright_;
  const VirtualScan truth_;
  const Image<double> down_;  ///< coordinate along y
};

/// A statue under the light of a screen, filmed by a camera that runs freely.
struct FilmedStatue {
  FilmedStatue() {
    if (camera == nullptr) return;
    camera->look_at([this] { return scene.picture(); });
    camera->set_frame_rate(60);
  }

  static VirtualWorld statue() {
    VirtualWorld world = virtual_world({.scene = "statue", .camera = {320, 240}, .world = "ideal"});
    world.photometry.bits = 8;
    return world;
  }

  const TemporaryFolder folder;
  const Desktop desktop{folder.path()};
  const Screen screen{folder.path()};
  const VirtualWorld world = statue();
  const LitScene scene{screen, world};
  const std::unique_ptr<VirtualGigeCamera> camera =
      serve(std::vector<Frame>{Frame({{320, 240}, 8})});
};

/// Flags of a run on the screen, with a scanner file.
std::vector<std::string> live_flags(const fs::path& scanner, const std::string& seconds) {
  return {"live",       "--source",   "aravis:" + std::string(served_address),
          "--monitor",  "0",          "--scanner",
          scanner,      "--strategy", "dual-frequency",
          "--steps",    "4",          "--headless",
          "--duration", seconds,      "--json"};
}

TEST(SteppedProgram, LiveOnAMonitorIsInStepWithACameraThatRunsFreely) {
  const FilmedStatue filmed;
  REQUIRE_CAMERA(filmed.camera);
  ASSERT_EQ(filmed.world.scanner.projector.size.width, filmed.screen.width());

  const fs::path folder = filmed.folder.path();
  const fs::path scanner = folder / "scanner.yaml", cloud = folder / "cloud.ply";
  write_scanner(scanner, filmed.world.scanner);

  const char* const seconds = std::getenv("SLIPSTREAM_REHEARSAL_SECONDS");

  // The screen's server may show patterns late, at times for seconds; then frames are lost, or the
  // check tells. Another run follows if more than a twentieth was lost or a tenth doubted.
  constexpr int most_runs = 4;
  nlohmann::json told;
  std::uint64_t doubted = 0;
  for (int tried = 0; tried < most_runs; ++tried) {
    std::vector<std::string> flags = live_flags(scanner, seconds != nullptr ? seconds : "12");
    flags.insert(flags.end(), {"-o", cloud, "--no-guard"});
    const ProgramRun run = run_program(flags);
    ASSERT_EQ(run.exit_code, 0) << run.err;
    told = nlohmann::json::parse(run.out);

    doubted = 0;
    for (const auto& finding : told["findings"]) {
      ASSERT_FALSE(finding["end"].is_null()) << run.err;
      doubted += finding["end"].get<std::uint64_t>() - finding["begin"].get<std::uint64_t>();
    }
    const auto captured = told["frames"]["captured"].get<std::uint64_t>();
    const auto lost = told["frames"]["lost"].get<std::uint64_t>();
    if (10 * doubted <= captured && 20 * lost <= captured) break;
    std::filesystem::remove(cloud);
  }

  EXPECT_GT(told["clouds"].get<int>(), 10);
  const int taken = told["frames"]["captured"], lost = told["frames"]["lost"];
  EXPECT_LE(20 * lost, taken);
  EXPECT_LE(10 * doubted, static_cast<std::uint64_t>(taken));
  std::printf("%.1f patterns per s, %d of %d lost, %d doubted; %d clouds\n",
              taken / told["seconds"].get<double>(), lost, taken, static_cast<int>(doubted),
              told["clouds"].get<int>());

  // The ideal scanner errs by 0.35.
  std::vector<double> errors;
  const Cloud made = read_cloud(cloud).cloud;
  for_each_pixel_in_order(made.size(), [&](int column, int row) {
    const double error = std::abs(made.z(column, row) - filmed.scene.depth()(column, row));
    if (std::isfinite(error)) errors.push_back(error);
  });
  EXPECT_GT(errors.size(), 20000U);
  EXPECT_LT(quantile(errors, 0.5), 0.6);
}

TEST(SteppedProgram, LiveOnAMonitorWarnsOfARigThatMoved) {
  const FilmedStatue filmed;
  REQUIRE_CAMERA(filmed.camera);

  const fs::path scanner = filmed.folder.path() / "scanner.yaml";
  for (const double angle : {0.0, 0.02}) {
    Scanner turned = filmed.world.scanner;
    turned.rotation = (Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitX()) * turned.rotation).eval();
    write_scanner(scanner, turned);

    // On a busy machine the delay may be measured wrongly: the run then says that it has no guard.
    ProgramRun run;
    nlohmann::json guard;
    for (int attempt = 0; attempt < 3 && guard.is_null(); ++attempt) {
      run = run_program(live_flags(scanner, "6"));
      ASSERT_EQ(run.exit_code, 0) << run.err;
      guard = nlohmann::json::parse(run.out).value("guard", nlohmann::json());
      ASSERT_TRUE(!guard.is_null() || run.err.find("no guard, as") != std::string::npos) << run.err;
    }
    ASSERT_FALSE(guard.is_null()) << run.err;

    const bool warned = run.err.find("the camera turned by 1.") != std::string::npos;
    EXPECT_EQ(warned, angle != 0) << run.err;
    EXPECT_EQ(guard["common_px"] > 1, angle != 0) << guard;
  }
}

}  // namespace slipstream::stepped_program_test
