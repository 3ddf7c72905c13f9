// SPDX-License-Identifier: BSD-2-Clause
// How the kernel's industrial I/O packs the elements of a scan.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "platform/base/status.h"

namespace facet {

/// How one element is stored: [be|le]:[s|u]BITS/STORAGE[XREPEAT][>>SHIFT], as `scan_elements/*_type` has it
/// (Documentation/ABI/testing/sysfs-bus-iio).
struct ScanType {
    bool is_big_endian = false;
    bool is_signed = false;
    int bits = 0;          ///< that count, once shifted
    int storage_bits = 0;  ///< 8, 16, 32 or 64
    int repeat = 1;        ///< values that are stored side by side; a power of two
    int shift = 0;         ///< to the right

    std::size_t bytes() const { return static_cast<std::size_t>(storage_bits / 8 * repeat); }
};

/// Reads the text of a type, with or without its end of line. Reentrant. No heap.
/// @return kInvalidArgument if it has another form, if the bits do not fit the storage, or for unsigned numbers of 64
///         bits; `type` is untouched then
Status parse_scan_type(std::string_view text, ScanType& type);

/// Value of an element, the first one if it is repeated. Reentrant. No heap.
/// @param bytes  storage_bits / 8 at least
std::int64_t read_scan_value(std::span<const std::uint8_t> bytes, const ScanType& type);

/// An element that is enabled.
struct ScanElement {
    int index = 0;  ///< elements are stored in the order of their indices
    ScanType type;
    std::size_t offset = 0;  ///< from the beginning of the scan (bytes)
};

inline constexpr std::size_t kMaxScanBytes = 128;

/// Sorts elements by index and gives them their offsets: each is aligned to its own size, and the scan to that of its
/// largest one. Reentrant. No heap.
/// @param scan_bytes  size of a scan, with the padding at its end
/// @return kInvalidArgument if there is none, if two have the same index, or if the scan exceeds kMaxScanBytes
Status lay_out_scan(std::span<ScanElement> elements, std::size_t& scan_bytes);

}  // namespace facet
