// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/map_thread.h"

#include <utility>

#include "platform/base/assert.h"
#include "platform/base/image_copy.h"

namespace facet {
namespace {

constexpr Duration kWait = Duration::from_seconds(0.02);

std::vector<std::uint8_t> room_for(const CameraIntrinsics& camera) {
    return std::vector<std::uint8_t>(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height));
}

}  // namespace

MapThread::MapThread(const MapConfig& config, const StereoRig& rig, SurfaceSink& sink) {
    FACET_ASSERT(ok(map_.configure(config, rig)));  // the estimator has taken both
    map_.give_to(&sink);
    for (std::size_t i = 0; i < kSlots; ++i) {
        auto slot = std::make_unique<Keyframe>();
        slot->left_pixels = room_for(rig.left.intrinsics());
        slot->right_pixels = room_for(rig.right.intrinsics());
        FACET_ASSERT(ok(free_.push(std::move(slot))));
    }
}

void MapThread::take(const KeyframeView& view, std::uint32_t resets, const ImageView& left, const ImageView& right) {
    Slot slot;
    if (!ok(free_.pop(slot))) {
        dropped_.fetch_add(1, std::memory_order_relaxed);
        return;
    }
    slot->view = view;
    slot->resets = resets;
    slot->left = copy_if_it_fits(left, slot->left_pixels);
    slot->right = copy_if_it_fits(right, slot->right_pixels);
    FACET_ASSERT(ok(waiting_.push(std::move(slot))));  // there are as many places as slots
    wakeup_.notify();
}

/// @return whether a keyframe was waiting
bool MapThread::add_next() {
    Slot slot;
    if (!ok(waiting_.pop(slot))) {
        return false;
    }
    map_.add(slot->view, slot->resets, slot->left, slot->right);
    FACET_ASSERT(ok(free_.push(std::move(slot))));
    return true;
}

void MapThread::work(const std::atomic<bool>& stopping) {
    while (!stopping.load(std::memory_order_acquire)) {
        const bool any = add_next();
        if (!map_.advance() && !any) {
            (void)wakeup_.wait(kWait);
        }
    }
}

void MapThread::finish() {
    while (add_next()) {
    }
    map_.finish();
}

}  // namespace facet
