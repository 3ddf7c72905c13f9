// SPDX-License-Identifier: BSD-2-Clause
#include "app/support/console.h"

#include <catch2/catch.hpp>

namespace facet::console_test {
namespace {

TEST_CASE("names with commands for a terminal become text, others stay as they are") {
    for (const char* good : {"", "data/1403636579.png",
                             "Gr\xc3\xb6\xc3\x9f"
                             "e \xe2\x82\xac \xf0\x9f\x9a\x81 ~"}) {
        CHECK(printable(good) == good);
    }
    CHECK(printable("a\x1b]0;title\x07"
                    "b") == "a\\x1b]0;title\\x07b");
    CHECK(printable("a\nerror: \r\t\x7f") == "a\\x0aerror: \\x0d\\x09\\x7f");
    CHECK(printable("\xc2\x9b"
                    "31m") == "\\xc2\\x9b31m");  // CSI as one character
    CHECK(printable(std::string_view("\0x", 2)) == "\\x00x");
    // What is no UTF-8 a terminal may take as it likes.
    CHECK(printable("\x9b"
                    "31m \xc3 \xe2\x82") == "\\x9b31m \\xc3 \\xe2\\x82");
    CHECK(printable("\xc0\xaf\xff") == "\\xc0\\xaf\\xff");
}

}  // namespace
}  // namespace facet::console_test
