// SPDX-License-Identifier: BSD-2-Clause
#include "app/mcap/json_fields.h"

#include <catch2/catch.hpp>

#include "app/mcap/bytes.h"

namespace facet::json_fields_test {

TEST_CASE("members are found as they stand, whatever is around them") {
    const std::string_view object =
        R"( { "a" : 1.50 , "text":"x\"}," ,"in":{"list":[{"b":2},3],"b":-0.0e+1},"t":true} )";
    CHECK(json_member(object, "a") == "1.50");
    CHECK(json_member(object, "text") == R"("x\"},")");
    CHECK(json_member(object, "in", "b") == "-0.0e+1");
    CHECK(json_member(object, "in", "list") == R"([{"b":2},3])");
    CHECK(json_member(object, "t") == "true");
    CHECK(json_member(object, "b") == std::nullopt);
    CHECK(json_member(object, "a", "b") == std::nullopt);
}

TEST_CASE("what is no object has no members") {
    for (const char* text : {"", "{", "{}", "[1]", "7", R"({"a")", R"({"a":)", R"({"a":"x)", R"({"a" 1})", R"({a:1})",
                             R"({"b":1 "a":2})", R"({"b":[})", R"({"b":"\)"}) {
        CAPTURE(text);
        CHECK(json_member(text, "a") == std::nullopt);
    }
}

TEST_CASE("numbers of JSON") {
    for (const char* number : {"0", "-0", "12", "0.5", "-0.50", "1e5", "1E-05", "1.0e+10"}) {
        CAPTURE(number);
        CHECK(is_json_number(number));
    }
    for (const char* other : {"", "-", "+1", "01", ".5", "1.", "1e", "1e+", "nan", "inf", "0x1", "1 ", "1,2"}) {
        CAPTURE(other);
        CHECK_FALSE(is_json_number(other));
    }
}

TEST_CASE("base64 as RFC 4648 has it") {
    const std::pair<const char*, const char*> cases[] = {{"", ""},
                                                         {"f", "Zg=="},
                                                         {"fo", "Zm8="},
                                                         {"foo", "Zm9v"},
                                                         {"foob", "Zm9vYg=="},
                                                         {"fooba", "Zm9vYmE="},
                                                         {"foobar", "Zm9vYmFy"},
                                                         {"\xff\xfe\xfd", "//79"}};
    std::vector<std::uint8_t> bytes;
    for (const auto& [plain, coded] : cases) {
        std::string text;
        append_base64(bytes_of(plain), text);
        CHECK(text == coded);
        REQUIRE(read_base64(coded, bytes));
        CHECK(text_of(bytes) == plain);
    }
    CHECK(read_base64("Zm8", bytes));
    CHECK(text_of(bytes) == "fo");
    CHECK(read_base64("\\/\\/79", bytes));
    CHECK(text_of(bytes) == "\xff\xfe\xfd");
    for (const char* wrong : {"Z", "Zm9vY", "Zm 9", "Zm9=vA", "Zm9v\\"}) {
        CAPTURE(wrong);
        CHECK_FALSE(read_base64(wrong, bytes));
    }
}

}  // namespace facet::json_fields_test
