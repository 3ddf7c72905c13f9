// SPDX-License-Identifier: BSD-2-Clause
// The map of surfaces of a live run, kept beside the estimator.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "mesh/mapping/keyframe_sink.h"
#include "mesh/volume/surface_map.h"
#include "platform/base/spsc_queue.h"
#include "platform/linux/linux_wakeup.h"

namespace facet {

/// Keyframes are copied on the estimator's thread (the view, 350 KB, and two images) and put into the map on another
/// one, in which all of the map's work is done as fast as there is time. When kSlots keyframes wait, because there is
/// no second core or no time on it, new ones are dropped and counted. Heap in the constructor only, but for what the
/// sink uses.
class MapThread final : public KeyframeSink {
public:
    static constexpr std::size_t kSlots = 4;

    /// @param sink  given the surface on the map's thread; borrowed
    MapThread(const MapConfig& config, const StereoRig& rig, SurfaceSink& sink);

    /// On the estimator's thread.
    void take(const KeyframeView& view, std::uint32_t resets, const ImageView& left, const ImageView& right) override;
    /// On the map's thread: until it is to stop, within 20 ms.
    void work(const std::atomic<bool>& stopping);
    /// After both have ended: whatever is left to do.
    void finish();

    /// After finish().
    const SurfaceMap& map() const { return map_; }
    /// Keyframes that came too fast. Thread-safe.
    std::uint64_t dropped() const { return dropped_.load(std::memory_order_relaxed); }

private:
    struct Keyframe {
        KeyframeView view;
        std::uint32_t resets = 0;
        ImageView left;  ///< into the pixels
        ImageView right;
        std::vector<std::uint8_t> left_pixels;
        std::vector<std::uint8_t> right_pixels;
    };
    using Slot = std::unique_ptr<Keyframe>;

    bool add_next();

    SurfaceMap map_;
    SpscQueue<Slot, kSlots> free_;     ///< to the estimator's thread
    SpscQueue<Slot, kSlots> waiting_;  ///< to the map's
    LinuxWakeup wakeup_;
    std::atomic<std::uint64_t> dropped_{0};
};

}  // namespace facet
