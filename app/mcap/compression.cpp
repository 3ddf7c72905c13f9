// SPDX-License-Identifier: BSD-2-Clause
#include "app/mcap/compression.h"

#include <bzlib.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <memory>
#include <stdexcept>

namespace facet {
namespace {

constexpr std::size_t kStep = std::size_t{1} << 20U;
constexpr int kZstdLevel = 1;  // level 3 makes logs of images 0.2 % smaller and takes half as long again

/// Makes room for what comes behind `done` bytes, of `size` in all.
void grow(std::vector<std::uint8_t>& out, std::size_t done, std::size_t size) {
    if (done == out.size()) {
        out.resize(std::min(size, out.size() + std::max(kStep, out.size() / 2)));
    }
}

/// Reads up to `size` bytes. @return how many there are; none if the frame is damaged, cut off or longer
std::optional<std::size_t> read_zstd(std::span<const std::uint8_t> in, std::size_t size,
                                     std::vector<std::uint8_t>& out) {
    const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(), &ZSTD_freeDCtx);
    ZSTD_inBuffer source{in.data(), in.size(), 0};
    std::size_t done = 0;
    std::size_t hint = 1;
    while (hint != 0 || source.pos < source.size) {
        grow(out, done, size);
        ZSTD_outBuffer target{out.data() + done, out.size() - done, 0};
        const std::size_t before = source.pos;
        hint = ZSTD_decompressStream(context.get(), &target, &source);
        done += target.pos;
        if (ZSTD_isError(hint) != 0 || (target.pos == 0 && source.pos == before)) {
            return std::nullopt;
        }
    }
    return done;
}

/// Likewise.
std::optional<std::size_t> read_lz4(std::span<const std::uint8_t> in, std::size_t size,
                                    std::vector<std::uint8_t>& out) {
    LZ4F_dctx* raw = nullptr;
    if (LZ4F_isError(LZ4F_createDecompressionContext(&raw, LZ4F_VERSION)) != 0) {
        return std::nullopt;
    }
    const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context(raw,
                                                                                       &LZ4F_freeDecompressionContext);
    std::size_t done = 0;
    std::size_t hint = 1;
    while (hint != 0 || !in.empty()) {
        grow(out, done, size);
        std::size_t taken = in.size();
        std::size_t given = out.size() - done;
        hint = LZ4F_decompress(raw, out.data() + done, &given, in.data(), &taken, nullptr);
        if (LZ4F_isError(hint) != 0 || (taken == 0 && given == 0)) {
            return std::nullopt;
        }
        in = in.subspan(taken);
        done += given;
    }
    return done;
}

bool read_bz2(std::span<const std::uint8_t> in, std::size_t size, std::vector<std::uint8_t>& out) {
    bz_stream stream{};
    if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) {
        return false;
    }
    const std::unique_ptr<bz_stream, decltype(&BZ2_bzDecompressEnd)> end(&stream, &BZ2_bzDecompressEnd);
    std::size_t done = 0;
    int status = BZ_OK;
    while (status == BZ_OK) {
        grow(out, done, size);
        const std::size_t room = std::min<std::size_t>(out.size() - done, 1U << 30U);
        const std::size_t feed = std::min<std::size_t>(in.size(), 1U << 30U);
        stream.next_in = const_cast<char*>(reinterpret_cast<const char*>(in.data()));  // bzlib does not write there
        stream.avail_in = static_cast<unsigned>(feed);
        stream.next_out = reinterpret_cast<char*>(out.data() + done);
        stream.avail_out = static_cast<unsigned>(room);
        status = BZ2_bzDecompress(&stream);
        const std::size_t taken = feed - stream.avail_in;
        const std::size_t given = room - stream.avail_out;
        if (status == BZ_OK && taken == 0 && given == 0) {
            return false;
        }
        in = in.subspan(taken);
        done += given;
    }
    return status == BZ_STREAM_END && done == size && out.size() == size;
}

void write_zstd(std::string_view in, std::string& out) {
    const std::size_t begin = out.size();
    out.resize(begin + ZSTD_compressBound(in.size()));
    const std::size_t size = ZSTD_compress(out.data() + begin, out.size() - begin, in.data(), in.size(), kZstdLevel);
    if (ZSTD_isError(size) != 0) {
        throw std::runtime_error(std::string("zstd: ") + ZSTD_getErrorName(size));
    }
    out.resize(begin + size);
}

void write_lz4(std::string_view in, std::string& out) {
    const std::size_t begin = out.size();
    out.resize(begin + LZ4F_compressFrameBound(in.size(), nullptr));
    const std::size_t size = LZ4F_compressFrame(out.data() + begin, out.size() - begin, in.data(), in.size(), nullptr);
    if (LZ4F_isError(size) != 0) {
        throw std::runtime_error(std::string("lz4: ") + LZ4F_getErrorName(size));
    }
    out.resize(begin + size);
}

}  // namespace

std::optional<Compression> find_compression(std::string_view name) {
    if (name.empty() || name == "none") {
        return Compression::kNone;
    }
    if (name == "lz4") {
        return Compression::kLz4;
    }
    if (name == "zstd") {
        return Compression::kZstd;
    }
    return name == "bz2" ? std::optional(Compression::kBz2) : std::nullopt;
}

void compress(Compression method, std::string_view in, std::string& out) {
    switch (method) {
        case Compression::kLz4: write_lz4(in, out); return;
        case Compression::kZstd: write_zstd(in, out); return;
        case Compression::kNone: out += in; return;
        case Compression::kBz2: break;
    }
    throw std::runtime_error("bz2 is only read");
}

Status decompress(Compression method, std::span<const std::uint8_t> in, std::size_t size,
                  std::vector<std::uint8_t>& out) {
    out.clear();
    bool whole = false;
    switch (method) {
        case Compression::kNone:
            whole = in.size() == size;
            if (whole) {
                out.assign(in.begin(), in.end());
            }
            break;
        case Compression::kLz4: whole = read_lz4(in, size, out) == size && out.size() == size; break;
        case Compression::kZstd: whole = read_zstd(in, size, out) == size && out.size() == size; break;
        case Compression::kBz2: whole = read_bz2(in, size, out); break;
    }
    return whole ? Status::kOk : Status::kCorrupt;
}

Compression compression_of(std::span<const std::uint8_t> begin) {
    constexpr std::array<std::uint8_t, 4> kZstdMagic{0x28, 0xB5, 0x2F, 0xFD};
    constexpr std::array<std::uint8_t, 4> kLz4Magic{0x04, 0x22, 0x4D, 0x18};
    const auto starts_with = [&](const std::array<std::uint8_t, 4>& magic) {
        return begin.size() >= magic.size() && std::equal(magic.begin(), magic.end(), begin.begin());
    };
    return starts_with(kZstdMagic) ? Compression::kZstd
                                   : (starts_with(kLz4Magic) ? Compression::kLz4 : Compression::kNone);
}

Status decompress_frame(std::span<const std::uint8_t> in, std::size_t most_bytes, std::vector<std::uint8_t>& out) {
    out.clear();
    std::optional<std::size_t> size;
    switch (compression_of(in)) {
        case Compression::kZstd: size = read_zstd(in, most_bytes, out); break;
        case Compression::kLz4: size = read_lz4(in, most_bytes, out); break;
        default: break;
    }
    out.resize(size.value_or(0));
    return size.has_value() ? Status::kOk : Status::kCorrupt;
}

}  // namespace facet
