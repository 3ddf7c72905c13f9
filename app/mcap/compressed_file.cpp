// SPDX-License-Identifier: BSD-2-Clause
#include "app/mcap/compressed_file.h"

#include <zstd.h>

#include <array>
#include <fstream>
#include <memory>
#include <vector>

#include "app/mcap/compression.h"
#include "platform/base/regular_file.h"

namespace facet {

bool is_zstd_file(const std::string& path) {
    std::array<char, 4> begin{};
    std::ifstream file;
    if (refuse_file(path).empty()) {
        file.open(path, std::ios::binary);
    }
    return file.read(begin.data(), begin.size()) &&
           compression_of({reinterpret_cast<const std::uint8_t*>(begin.data()), begin.size()}) == Compression::kZstd;
}

std::string decompress_file(const std::string& from, const std::string& to, std::uint64_t most_bytes,
                            const std::atomic<bool>* stop) {
    const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(), &ZSTD_freeDCtx);
    std::ifstream in(from, std::ios::binary);
    std::ofstream out(to, std::ios::binary);
    std::vector<char> source(ZSTD_DStreamInSize());
    std::vector<char> target(ZSTD_DStreamOutSize());
    std::size_t hint = 0;
    std::uint64_t bytes = 0;
    while (in && out) {
        if (stop != nullptr && stop->load()) {
            return "";
        }
        in.read(source.data(), static_cast<std::streamsize>(source.size()));
        ZSTD_inBuffer input{source.data(), static_cast<std::size_t>(in.gcount()), 0};
        while (input.pos < input.size) {
            ZSTD_outBuffer output{target.data(), target.size(), 0};
            hint = ZSTD_decompressStream(context.get(), &output, &input);
            if (ZSTD_isError(hint) != 0) {
                return from + ": cannot be decompressed: " + ZSTD_getErrorName(hint);
            }
            bytes += output.pos;
            if (bytes > most_bytes) {
                return from + ": unpacks to more than a recording does";
            }
            out.write(target.data(), static_cast<std::streamsize>(output.pos));
        }
    }
    out.close();
    if (!out) {
        return to + ": cannot be written";
    }
    return hint == 0 ? "" : from + ": ends too early";
}

}  // namespace facet
