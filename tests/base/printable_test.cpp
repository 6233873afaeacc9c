#include "base/printable.h"

#include <gtest/gtest.h>

namespace slipstream::printable_test {

TEST(Printable, ShowsControlCharactersAsHexadecimal) {
  EXPECT_EQ(printable("a\x1b[31mb\nc\td\x7f"), "a\\x1b[31mb\\x0ac\\x09d\\x7f");
  EXPECT_EQ(printable("\xc2\x9b"), "\\x9b");
  EXPECT_EQ(printable_lines("a\x1b\nb"), "a\\x1b\nb");
}

TEST(Printable, LeavesOtherLettersAsTheyAre) {
  const char* const text = "\xc3\xa4\xc2\xa0\xe2\x82\xac ~\xc2";
  EXPECT_EQ(printable(text), text);
}

}  // namespace slipstream::printable_test
