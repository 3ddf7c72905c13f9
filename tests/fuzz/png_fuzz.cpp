// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/replay_asl/png_decoder.h"
#include "tests/fuzz/fuzz_input.h"

using namespace facet;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const test::MemoryFile file({data, size});
    static PngDecoder decoder;
    static GreyImage image;
    // A size is always known when a log is replayed: nothing larger is ever decoded.
    const Status status = decoder.decode(file.path(), 16, 8, image);
    if (ok(status)) {
        test::require(image.width == 16 && image.height == 8 && image.pixels.size() == 16U * 8U);
    } else {
        test::require(!decoder.error().empty());
    }
    return 0;
}
