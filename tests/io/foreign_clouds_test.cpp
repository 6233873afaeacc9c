// Clouds as other programs store them.
#include <bit>
#include <filesystem>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "base/numbers.h"
#include "io/file.h"
#include "slipstream/cloud_file.h"
#include "tests/io/expect_error.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::foreign_clouds_test {

/// The points (1, 2, 3) and (4, 5.5, 6) with intensities of 58.7 and 141.24, or others.
void expect_two_points(const Cloud& cloud, float first = 58.7F, float second = 141.24F) {
  ASSERT_EQ(cloud.size(), (Size{2, 1}));
  const auto expect_point = [&](int i, float x, float y, float z, float intensity) {
    EXPECT_EQ(cloud.x(i, 0), x);
    EXPECT_EQ(cloud.y(i, 0), y);
    EXPECT_EQ(cloud.z(i, 0), z);
    EXPECT_NEAR(cloud.intensity(i, 0), intensity, 1e-4);
  };
  expect_point(0, 1, 2, 3, first);
  expect_point(1, 4, 5.5F, 6, second);
}

StoredCloud stored_as(const std::string& name, const std::string& text) {
  const TemporaryFolder folder;
  write_file(folder.path() / name, text);
  return read_cloud(folder.path() / name);
}

Cloud cloud_of(const std::string& name, const std::string& text) {
  return stored_as(name, text).cloud;
}

std::string pcd(const std::string& fields, const std::string& data) {
  return "# made up\nVERSION .7\n" + fields +
         "WIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA " + data;
}

constexpr std::uint32_t green = 100U << 8, bright = 0xff000000U | 200U << 16 | 130U << 8 | 45U;

TEST(ForeignClouds, PcdHasDoubles) {
  std::string text = pcd("FIELDS z y x\nSIZE 8 8 8\nTYPE F F F\n", "binary\n");
  append_numbers(text, 3.0, 2.0, 1.0, 6.0, 5.5, 4.0);
  expect_two_points(cloud_of("cloud.pcd", text), 0, 0);
}

TEST(ForeignClouds, PcdHasFieldsOfAllTypes) {
  std::string text =
      pcd("FIELDS t x _ y ring z normal intensity\nSIZE 8 4 1 8 2 4 4 2\nTYPE U F U F I I F U\n"
          "COUNT 1 1 3 1 1 1 3 1\n",
          "binary\n");
  const std::array<std::uint8_t, 3> gap{};
  for (const auto& [x, y, z, level] : {std::tuple{1.F, 2.0, 3, 40}, {4.F, 5.5, 6, 50}}) {
    append_numbers(text, std::uint64_t{7}, x, gap[0], gap[1], gap[2], y, std::int16_t{-3}, z, 0.F,
                   0.F, 1.F, static_cast<std::uint16_t>(level));
  }
  expect_two_points(cloud_of("cloud.pcd", text), 40, 50);
  text.pop_back();
  expect_error([&] { cloud_of("cloud.pcd", text); }, {"cloud.pcd", "truncated"});
}

TEST(ForeignClouds, PcdHasPackedColours) {
  for (const std::string type : {"F", "U", "I"}) {
    std::string text =
        pcd("FIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F " + type + "\nCOUNT 1 1 1 1\n", "binary\n");
    append_numbers(text, 1.F, 2.F, 3.F, green, 4.F, 5.5F, 6.F, bright);
    expect_two_points(cloud_of("cloud.pcd", text));
  }
  const std::string fields = "FIELDS x y z rgba\nSIZE 4 4 4 4\nTYPE F F F F\n";
  expect_two_points(
      cloud_of("cloud.pcd", pcd(fields, fmt::format("ascii\n1 2 3 {}\n4 5.5 6 {}\n",
                                                    std::bit_cast<float>(green), bright))));
}

TEST(ForeignClouds, PcdOfUnknownTypesIsRefused) {
  const std::string begin = "FIELDS x y z\nSIZE 4 4 4\n";
  const auto expect_refused = [](const std::string& fields, const std::string& why) {
    expect_error([&] { cloud_of("cloud.pcd", pcd(fields, "ascii\n1 2 3\n4 5 6\n")); },
                 {"cloud.pcd", why});
  };
  expect_refused(begin + "TYPE F F X\n", "'X 4' is not a type");
  expect_refused(begin + "TYPE F F\n", "3 FIELDS, but 2 TYPE");
  expect_refused(begin + "TYPE F F F\nCOUNT 1 1 2\n", "no x, y and z");
  expect_refused(begin + "TYPE F F F\nCOUNT 1 1 x\n", "'x' is not a number");
}

TEST(ForeignClouds, XyzHasNamesCommasAndColours) {
  for (const char* const text :
       {"X,Y,Z,R,G,B\n1,2,3,0,100,0\n4,5.5,6,200,130,45\n",
        "//X Y Z nx R G B\n2\n1 2 3 0.5 0 100 0\n4 5.5 6 1 200 130 45\n\n",
        "# a comment\n1 2 3 0 100 0\r\n# another\r\n4 5.5 6 200 130 45\r\n",
        "\"z\";\"y\";\"x\";\"Intensity\"\n3;2;1;58.7\n6;5.5;4;141.24\n",
        "1\t2\t3\t58.7\n4\t5.5\t6\t141.24\n", "2\n1, 2, 3, 0, 100, 0\n4, 5.5, 6, 200, 130, 45\n"}) {
    SCOPED_TRACE(text);
    expect_two_points(cloud_of("cloud.xyz", text));
  }
  expect_two_points(cloud_of("cloud.xyz", "1 2 3 0 0 1\n4 5.5 6 1 0 0\n"), 0, 0);  // normals
  expect_two_points(cloud_of("cloud.xyz", "x y z a\n1 2 3 5\n4 5.5 6 5\n"), 0, 0);
}

TEST(ForeignClouds, XyzHasOtherEndingsToo) {
  for (const char* const name : {"cloud.asc", "cloud.txt", "cloud.csv", "cloud.pts"}) {
    SCOPED_TRACE(name);
    expect_two_points(cloud_of(name, "1 2 3 0 100 0\n4 5.5 6 200 130 45\n"));
  }
}

TEST(ForeignClouds, PtsHasAnIntensityBeforeTheColour) {
  const std::string text = "2\n1 2 3 250 0 100 0\n4 5.5 6 4 200 130 45\n";
  expect_two_points(cloud_of("cloud.pts", text));
  expect_two_points(cloud_of("cloud.pts", "1 2 3 -900 0 100 0\n4 5.5 6 2047 200 130 45\n"));
  expect_two_points(cloud_of("cloud.pts", "2\n1 2 3 58.7\n4 5.5 6 141.24\n"));
}

TEST(ForeignClouds, XyzMayBeginWithTheMarkOfUtf8AndHavePluses) {
  const std::string mark = "\xEF\xBB\xBF";
  expect_two_points(cloud_of("cloud.csv", mark + "x,i,y,z\n+1,58.7,2,+3\n4,141.24,+5.5,6\n"));
  expect_two_points(cloud_of("cloud.csv", mark + "1,2,3,58.7\n4,5.5,6,141.24\n"));
  expect_two_points(cloud_of("cloud.asc", "+1 +2 +3 58.7\n4 5.5 6 141.24\n"));
}

TEST(ForeignClouds, XyzLeavesOutWhatIsNoNumberOf32Bits) {
  expect_two_points(cloud_of("cloud.txt",
                             "x y z r g b\n"
                             "nan nan nan nan nan nan\n"
                             "1 2 3 0 0.392156863 0\n"
                             "1e39 0 0 0 0 0\n"
                             "4 5.5 6 0.784313725 0.509803922 0.176470588\n"));
}

/// An ASCII PLY of two points: x, y, z of a type, and further properties.
std::string two_points_ply(const std::string& type, const std::string& properties,
                           const std::string& points) {
  return "ply\nformat ascii 1.0\nelement vertex 2\nproperty " + type + " x\nproperty " + type +
         " y\nproperty " + type + " z\n" + properties + "end_header\n" + points;
}

TEST(ForeignClouds, PlyNamesItsColoursInManyWays) {
  const auto of = [](const std::string& type, const std::string& names) {
    std::string text;
    std::istringstream words(names);
    for (std::string name; words >> name;) text += "property " + type + " " + name + "\n";
    return text;
  };
  for (const char* const names : {"r g b", "R G B", "Red Green Blue"}) {
    SCOPED_TRACE(names);
    expect_two_points(cloud_of("cloud.ply", two_points_ply("float", of("uchar", names),
                                                           "1 2 3 0 100 0\n4 5.5 6 200 130 45\n")));
    expect_two_points(
        cloud_of("cloud.ply", two_points_ply("float", of("float", names),
                                             "1 2 3 0 0.392156863 0\n"
                                             "4 5.5 6 0.784313725 0.509803922 0.176470588\n")));
  }
  expect_two_points(cloud_of("cloud.ply", two_points_ply("float", of("float", "scalar_Intensity"),
                                                         "1 2 3 58.7\n4 5.5 6 141.24\n")));
}

TEST(ForeignClouds, PlyTellsHowMuchDoublesAreRounded) {
  const auto rounding = [](const std::string& points) {
    return stored_as("cloud.ply", two_points_ply("double", "", points)).rounding;
  };
  EXPECT_EQ(rounding("1 2 3\n4 5.5 6\n"), 0);
  EXPECT_LT(rounding("731.123456789 2 3\n4 5.5 6\n"), 0.001);
  EXPECT_NEAR(rounding("500000.015 5300000.0225 3\n4 5.5 6\n"), 0.0225, 1e-6);
}

TEST(ForeignClouds, XyzOfUnequalLinesIsRefused) {
  const auto expect_refused = [](const std::string& text, const std::string& why) {
    expect_error([&] { cloud_of("cloud.xyz", text); }, {"cloud.xyz", why});
  };
  expect_refused("x y z\n1 2 3\n4 5\n", "line 3: expected 3 numbers");
  expect_refused("1 2 3\n4 five 6\n", "line 2: 'five' is not a number");
  expect_refused("1 2\n3 4\n5 6\n", "no x, y and z");
  expect_refused("x y z\n", "no points");
  expect_refused("", "no points");
}

TEST(ForeignClouds, XyzWithDecimalCommasIsRefused) {
  for (const char* const line : {"1,5;2,5;3,5\n", "1,5 2 3,5\n", "1\t2,5\t3\n"}) {
    expect_error([&] { cloud_of("cloud.csv", "x y z\n1 2 3\n" + std::string(line)); },
                 {"cloud.csv", "line 3", "decimal comma"});
    expect_error([&] { cloud_of("cloud.csv", line); }, {"cloud.csv", "line 1", "decimal comma"});
  }
}

}  // namespace slipstream::foreign_clouds_test
