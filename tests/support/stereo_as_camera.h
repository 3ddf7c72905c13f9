// SPDX-License-Identifier: BSD-2-Clause
// A source of stereo pairs in the place of a camera whose images are side by side.
#pragma once

#include <array>
#include <cstring>
#include <utility>
#include <vector>

#include "platform/port/camera_source.h"
#include "tests/support/stereo_source.h"

namespace facet {

/// Copies each pair into a slot of its own, left and right half; a missing right view is black. When no slot is free,
/// the next pair is not asked for yet. Thread-bound. Heap in the constructor only.
/// @tparam Slots  images under way at most; 1: the next image comes when the one before is done with
template <std::size_t Slots>
class StereoAsCamera final : public CameraSource {
public:
    /// Borrowed: source. @param width, height  of one view (px); other sizes are kCorrupt
    StereoAsCamera(StereoSource& source, int width, int height) : source_(source), width_(width), height_(height) {
        for (auto& slot : pixels_) {
            slot.resize(static_cast<std::size_t>(2 * width) * static_cast<std::size_t>(height));
        }
    }

    Status start() override { return source_.start(); }
    void stop() override { source_.stop(); }
    ClockDomain clock() const override { return source_.clock(); }
    SourceCounters counters() const override { return source_.counters(); }
    std::string_view problem() const override { return source_.problem(); }

    Status next(Duration timeout, CameraFrame& frame) override {
        SlotLease slot = slots_.take();
        if (!slot.held()) {
            return Status::kNotReady;
        }
        StereoFrame pair;
        FACET_TRY(source_.next(timeout, pair));
        if (pair.left.width != width_ || pair.left.height != height_) {
            return Status::kCorrupt;
        }
        std::vector<std::uint8_t>& pixels = pixels_[static_cast<std::size_t>(slot.slot())];
        const auto width = static_cast<std::size_t>(width_);
        const bool has_right = pair.right.width == width_ && pair.right.height == height_;
        for (int v = 0; v < height_; ++v) {
            std::uint8_t* const row = pixels.data() + static_cast<std::size_t>(v) * 2 * width;
            std::memcpy(row, pair.left.row(v), width);
            if (has_right) {
                std::memcpy(row + width, pair.right.row(v), width);
            } else {
                std::memset(row + width, 0, width);
            }
        }
        frame = {pair.stamp, sequence_++, {pixels.data(), 2 * width_, height_, 2 * width_}, std::move(slot), {}};
        return Status::kOk;
    }

private:
    StereoSource& source_;
    int width_;
    int height_;
    std::uint32_t sequence_ = 0;
    std::array<std::vector<std::uint8_t>, Slots> pixels_;
    SlotLender<Slots> slots_;
};

}  // namespace facet
