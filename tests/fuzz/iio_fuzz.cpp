// SPDX-License-Identifier: BSD-2-Clause
// Types of scan elements, and scans read with what they say. The first 128 bytes are the scan, the rest lines of types.
#include <array>
#include <string>

#include "drivers/imu_iio/scan_format.h"
#include "tests/fuzz/fuzz_input.h"

using namespace facet;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    test::FuzzInput input(data, size);
    std::array<std::uint8_t, kMaxScanBytes> scan{};
    const auto bytes = input.take_bytes(scan.size());
    std::copy(bytes.begin(), bytes.end(), scan.begin());
    std::array<ScanElement, 8> elements;
    std::size_t count = 0;
    std::string_view text = input.rest_as_text();
    while (count < elements.size() && !text.empty()) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        ScanElement& element = elements[count];
        if (ok(parse_scan_type(text.substr(0, end), element.type))) {
            element.index = static_cast<int>((count * 5) % elements.size());
            ++count;
        }
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    std::size_t scan_bytes = 0;
    if (!ok(lay_out_scan(std::span(elements).first(count), scan_bytes))) {
        return 0;
    }
    test::require(scan_bytes <= scan.size());
    std::size_t begin = 0;
    for (const ScanElement& element : std::span(elements).first(count)) {
        // In order, apart from each other, and inside.
        test::require(element.offset >= begin);
        begin = element.offset + element.type.bytes();
        test::require(begin <= scan_bytes);
        const std::int64_t value = read_scan_value(std::span(scan).subspan(element.offset), element.type);
        const int bits = element.type.bits;
        const std::int64_t most = bits == 64 || (bits == 63 && !element.type.is_signed)
                                      ? INT64_MAX
                                      : (std::int64_t{1} << (bits - (element.type.is_signed ? 1 : 0))) - 1;
        test::require(value <= most && value >= (element.type.is_signed ? -most - 1 : 0));
    }
    return 0;
}
