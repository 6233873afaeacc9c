// Asks a made-up desktop (portal.py) for a file.
#include "view/file_dialog.h"

#include <array>
#include <cstdio>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "slipstream/error.h"
#include "tests/base/variable.h"

namespace slipstream::view::file_dialog_test {

constexpr const char* bus_variable = "DBUS_SESSION_BUS_ADDRESS";

/// The answer of a desktop whose dialog chooses that path, or is cancelled if it is empty.
std::optional<std::string> answer_of(FileQuestion question, const std::string& path) {
  const std::string command =
      std::string("/usr/bin/python3 " SLIPSTREAM_SOURCE_FOLDER "/tests/view/portal.py ") + path;
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> desktop(::popen(command.c_str(), "r"),
                                                                ::pclose);
  std::array<char, 512> line{};
  if (std::fgets(line.data(), line.size(), desktop.get()) == nullptr) {
    throw std::runtime_error("portal.py does not start");
  }

  std::string address = line.data();
  address.pop_back();  // the end of the line
  const Variable bus(bus_variable, address);
  return ask_for_file(question, false);
}

TEST(FileDialog, GivesThePathThatTheDesktopsDialogChose) {
  EXPECT_EQ(answer_of(FileQuestion::open, "'/tmp/two words.slip'"), "/tmp/two words.slip");
  EXPECT_EQ(answer_of(FileQuestion::save, "/tmp/cloud.ply"), "/tmp/cloud.ply");
  EXPECT_EQ(answer_of(FileQuestion::open, ""), std::nullopt) << "cancelled";
}

TEST(FileDialog, SaysWhatToDoWithoutOne) {
  const Variable bus(bus_variable, "unix:path=/nowhere");
  try {
    ask_for_file(FileQuestion::open, false);
    FAIL();
  } catch (const WorldError& error) {
    EXPECT_NE(std::string(error.what()).find("type a path"), std::string::npos) << error.what();
  }
}

}  // namespace slipstream::view::file_dialog_test
