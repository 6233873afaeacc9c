#pragma once

#include <string>

#include <gtest/gtest.h>

#include "slipstream/error.h"

namespace slipstream {

/// Expects `action` to throw Error with a one-line message that contains all `parts`.
template <class Action>
void expect_error(const Action& action, std::initializer_list<std::string> parts) {
  try {
    action();
    ADD_FAILURE() << "no error; expected one about " << *parts.begin();
  } catch (const Error& error) {
    const std::string message = error.what();
    for (const std::string& part : parts) {
      EXPECT_NE(message.find(part), std::string::npos) << message << "\nlacks: " << part;
    }
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

}  // namespace slipstream
