// SPDX-License-Identifier: BSD-2-Clause
// Finds packets in a stream of bytes.
#pragma once

#include <algorithm>
#include <array>
#include <span>

#include "drivers/imu_serial/serial_protocol.h"
#include "platform/base/status.h"

namespace facet {

/// Bytes come in any pieces; what is no packet is passed over. After a damaged packet the search goes on behind its
/// first byte, so that a length that was damaged costs no packet behind it. Thread-bound. No heap.
class PacketStream {
public:
    /// Where the next bytes are to be read to: never empty once next() said kNotReady.
    std::span<std::uint8_t> room() {
        if (begin_ > 0) {
            std::copy(bytes_.begin() + static_cast<std::ptrdiff_t>(begin_),
                      bytes_.begin() + static_cast<std::ptrdiff_t>(end_), bytes_.begin());
            end_ -= begin_;
            begin_ = 0;
        }
        return std::span(bytes_).subspan(end_);
    }
    /// So many have been read there.
    void take(std::size_t size) { end_ += size; }
    void clear() { begin_ = end_ = passed_over_ = 0; }
    /// Bytes since the last whole packet that belong to none.
    std::size_t passed_over() const { return passed_over_; }

    /// @param packet  whole, valid until the next call of room()
    /// @return kNotReady if more bytes are needed, kCorrupt at a damaged packet
    Status next(const SerialProtocol& protocol, std::span<const std::uint8_t>& packet) {
        for (; begin_ < end_; ++begin_, ++passed_over_) {
            const auto rest = std::span<const std::uint8_t>(bytes_).subspan(begin_, end_ - begin_);
            const SerialFrame frame = protocol.frame(rest);
            switch (frame.kind) {
                case SerialFrame::Kind::kNone: break;
                case SerialFrame::Kind::kUnfinished: return Status::kNotReady;
                case SerialFrame::Kind::kDamaged:
                    ++begin_;
                    ++passed_over_;
                    return Status::kCorrupt;
                case SerialFrame::Kind::kWhole:
                    packet = rest.first(frame.size);
                    begin_ += frame.size;
                    passed_over_ = 0;
                    return Status::kOk;
            }
        }
        return Status::kNotReady;
    }

private:
    std::array<std::uint8_t, 4 * SerialProtocol::kLongest> bytes_{};
    std::size_t begin_ = 0;
    std::size_t end_ = 0;
    std::size_t passed_over_ = 0;
};

}  // namespace facet
