#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

#include "io/file.h"
#include "io/image_file.h"
#include "tests/io/expect_error.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::height_file_test {

Image<HeightCurve> some_curves() {
  Image<HeightCurve> curves({4, 3});
  curves(1, 2) = {.reference = 0.25F, .slope = 1e-3F, .bend = -2e-4F, .lowest = 0, .highest = 0.5F};
  return curves;
}

TEST(HeightFile, KeepsAllNumbers) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "heights.npy";
  const Image<HeightCurve> curves = some_curves();
  write_height_curves(path, curves);
  const Image<HeightCurve> read = read_height_curves(path);
  ASSERT_EQ(read.size(), curves.size());
  EXPECT_TRUE(std::isnan(read(0, 0).reference));
  EXPECT_EQ(std::memcmp(&read(1, 2), &curves(1, 2), sizeof(HeightCurve)), 0);
  EXPECT_EQ(read_map(path)(5, 2), 0.25);
}

TEST(HeightFile, RefusesOtherFiles) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "heights.npy";
  const auto refused = [&](const std::string& why) {
    expect_error([&] { (void)read_height_curves(path); }, {"heights.npy", why});
  };
  write_height_curves(path, some_curves());
  std::vector<std::uint8_t> bytes = read_file(path);
  bytes.resize(bytes.size() - 1);
  write_file(path, bytes);
  refused("its shape requires");
  write_map(path, Image<float>({12, 3}));
  refused("five numbers");
  write_map(path, Image<float>({15, 3}));
  refused("row 0, column 0");
  write_height_curves(path, Image<HeightCurve>({4, 3}));
  refused("no pixel");
  expect_error([&] { write_height_curves(folder.path() / "heights.tiff", some_curves()); },
               {"heights.tiff"});
}

}  // namespace slipstream::height_file_test
