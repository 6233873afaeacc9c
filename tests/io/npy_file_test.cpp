#include <cstring>

#include <gtest/gtest.h>

#include "io/file.h"
#include "io/image_file.h"
#include "tests/io/expect_error.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::npy_file_test {

TEST(NpyFile, KeepsFloatsAndDoubles) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "map.npy";
  Image<double> map({5, 3}, 0.1);
  map(4, 2) = -1e300;
  write_map(path, map);
  EXPECT_EQ(std::filesystem::file_size(path), 128 + 8 * 15U);
  const Image<double> read = read_map(path);
  EXPECT_EQ(read.size(), map.size());
  EXPECT_TRUE(std::equal(read.begin(), read.end(), map.begin()));
  write_map(path, Image<float>({300, 200}, 0.1F));
  EXPECT_EQ(read_map(path)(299, 199), 0.1F);
}

TEST(NpyFile, ReadsWhatNumPyWrites) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "map.npy";
  std::string text("\x93NUMPY\x01\x00\x76\x00", 10);
  text += "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 2), }";
  text.resize(127, ' ');
  text += '\n' + std::string("\0\0\x80\x3f\0\0\0\xc0", 8);
  write_file(path, text);
  const Image<double> map = read_map(path);
  EXPECT_EQ(map.size(), (Size{2, 1}));
  EXPECT_EQ(map(0, 0), 1);
  EXPECT_EQ(map(1, 0), -2);

  const auto refused = [&](const char* from, const std::string& to, const std::string& why) {
    std::string other = text;
    other.replace(other.find(from), std::strlen(from), to);
    write_file(path, other);
    expect_error([&] { (void)read_map(path); }, {"map.npy", why});
  };
  refused("<f4", ">f4", "little-endian");
  refused("<f4", "<i4", "little-endian");
  refused("False", "True ", "rows x columns");
  refused("(1, 2)", "(2,)  ", "rows x columns");
  refused("(1, 2)", "(1, 3)", "its shape requires 12");
  refused("(1, 2), }", "(0, 2), }", "0 pixels");
  refused("NUMPY\x01", "NUMPY\x03", "not a NumPy file");
  refused("\x76", "\x77", "its shape requires 8");
  write_file(path, text.substr(0, 60));
  expect_error([&] { (void)read_map(path); }, {"not a complete NumPy file"});
}

TEST(NpyFile, LevelsAreThoseOfPicturesAndMaps) {
  const TemporaryFolder folder;
  write_image(folder.path() / "deep.png", Image<std::uint16_t>({3, 2}, 40000));
  EXPECT_EQ(read_levels(folder.path() / "deep.png")(2, 1), 40000);
  write_map(folder.path() / "map.tiff", Image<float>({3, 2}, 0.5F));
  EXPECT_EQ(read_levels(folder.path() / "map.tiff")(2, 1), 0.5);
  write_image(folder.path() / "colour.png", Image<Colour>({3, 2}));
  expect_error([&] { (void)read_levels(folder.path() / "colour.png"); }, {"colour.png", "grey"});
}

}  // namespace slipstream::npy_file_test
