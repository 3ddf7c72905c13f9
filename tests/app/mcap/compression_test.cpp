// SPDX-License-Identifier: BSD-2-Clause
#include "app/mcap/compression.h"

#include <bzlib.h>

#include <catch2/catch.hpp>

#include "app/mcap/bytes.h"

namespace facet::compression_test {
namespace {

/// More than a step of the decoders, with repetitions and without.
std::string sample() {
    std::string text;
    std::uint32_t state = 1;
    for (int i = 0; i < 400'000; ++i) {
        state = state * 1664525U + 1013904223U;
        text += i % 1000 < 500 ? static_cast<char>(state >> 24U) : 'a';
        text += "stamp";
    }
    return text;
}

std::string packed(Compression method, const std::string& text) {
    std::string out;
    if (method != Compression::kBz2) {
        compress(method, text, out);
        return out;
    }
    auto size = static_cast<unsigned>(text.size() + 1000);
    out.resize(size);
    std::string in = text;
    REQUIRE(BZ2_bzBuffToBuffCompress(out.data(), &size, in.data(), static_cast<unsigned>(in.size()), 1, 0, 0) == BZ_OK);
    out.resize(size);
    return out;
}

}  // namespace

TEST_CASE("what is compressed is unpacked as it was") {
    const auto method = GENERATE(Compression::kNone, Compression::kLz4, Compression::kZstd, Compression::kBz2);
    for (const std::string& text : {std::string(), std::string("x"), sample()}) {
        const std::string bytes = packed(method, text);
        std::vector<std::uint8_t> out;
        REQUIRE(decompress(method, bytes_of(bytes), text.size(), out) == Status::kOk);
        CHECK(text_of(out) == text);
    }
}

TEST_CASE("another size than stated, a cut and a damaged byte are seen") {
    const auto method = GENERATE(Compression::kLz4, Compression::kZstd, Compression::kBz2);
    const std::string text = sample();
    std::string bytes = packed(method, text);
    std::vector<std::uint8_t> out;
    CHECK(decompress(method, bytes_of(bytes), text.size() - 1, out) == Status::kCorrupt);
    CHECK(decompress(method, bytes_of(bytes), text.size() + 1, out) == Status::kCorrupt);
    CHECK(decompress(method, bytes_of(bytes).first(bytes.size() - 9), text.size(), out) == Status::kCorrupt);
    CHECK(decompress(method, {}, text.size(), out) == Status::kCorrupt);
    bytes[1] = static_cast<char>(~bytes[1]);
    CHECK(decompress(method, bytes_of(bytes), text.size(), out) == Status::kCorrupt);
}

TEST_CASE("memory grows with what is there, not with what is stated") {
    std::string bytes;
    compress(Compression::kZstd, "little", bytes);
    std::vector<std::uint8_t> out;
    CHECK(decompress(Compression::kZstd, bytes_of(bytes), std::size_t{1} << 40U, out) == Status::kCorrupt);
    CHECK(out.capacity() < (std::size_t{4} << 20U));
}

TEST_CASE("names of compressions") {
    CHECK(find_compression("") == Compression::kNone);
    CHECK(find_compression("none") == Compression::kNone);
    CHECK(find_compression("lz4") == Compression::kLz4);
    CHECK(find_compression("zstd") == Compression::kZstd);
    CHECK(find_compression("bz2") == Compression::kBz2);
    CHECK(find_compression("gzip") == std::nullopt);
}

TEST_CASE("frames are unpacked without knowing their size, up to a bound") {
    const auto method = GENERATE(Compression::kLz4, Compression::kZstd);
    const std::string text = sample();
    const std::string bytes = packed(method, text);
    CHECK(compression_of(bytes_of(bytes)) == method);
    std::vector<std::uint8_t> out;
    REQUIRE(decompress_frame(bytes_of(bytes), text.size() + 1'000'000, out) == Status::kOk);
    CHECK(text_of(out) == text);
    CHECK(decompress_frame(bytes_of(bytes), text.size(), out) == Status::kOk);
    CHECK(decompress_frame(bytes_of(bytes), text.size() / 2, out) == Status::kCorrupt);
    CHECK(decompress_frame(bytes_of(bytes).first(bytes.size() - 9), text.size(), out) == Status::kCorrupt);
    CHECK(compression_of(bytes_of(text)) == Compression::kNone);
    CHECK(decompress_frame(bytes_of(text), text.size(), out) == Status::kCorrupt);
}

}  // namespace facet::compression_test
