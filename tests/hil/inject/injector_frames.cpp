// SPDX-License-Identifier: BSD-2-Clause
#include <algorithm>

#include "tests/hil/inject/injector.h"

namespace facet::hil {
namespace {

constexpr Duration kHourAhead = Duration::from_seconds(3600.0);
constexpr Duration kRightLate = Duration::from_seconds(0.02);
constexpr double kDimming = 0.1;
constexpr std::size_t kLookAhead = 64;  // actions, more than there are in two periods

}  // namespace

void Injector::plan_frames() {
    const std::vector<RecordedFrame>& recorded = recording_.frames;
    const Duration period = recorded.size() > 1 ? recorded[1].stamp - recorded[0].stamp : Duration::from_seconds(0.05);
    for (int k = options_.lead_frames; k > 0; --k) {
        frames_.push_back({recorded.front().stamp - Duration{k * period.ns}, 0});
    }
    for (int turn = 0; turn < recording_.turns; ++turn) {
        for (std::size_t i = 0; i < recorded.size(); ++i) {
            frames_.push_back({recorded[i].stamp + Duration{turn * recording_.turn.ns}, i});
        }
    }
    const Duration half{options_.exposure.ns / 2};
    const Duration arrival = half + options_.readout;
    for (std::size_t i = 0; i < frames_.size(); ++i) {
        const Timestamp stamp = frames_[i].stamp;
        if (!active(FaultKind::kEdgesLost, stamp)) {
            actions_.push_back({stamp - half, What::kEdge, i});
        }
        if (active(FaultKind::kEdgesExtra, stamp)) {
            actions_.push_back({stamp + Duration{period.ns / 2}, What::kExtraEdge, i});
        }
        actions_.push_back({stamp + arrival, What::kLeft, i});
        const Duration late = active(FaultKind::kRightLate, stamp) ? kRightLate : Duration{};
        actions_.push_back({stamp + arrival + late + Duration::from_seconds(0.0003), What::kRight, i});
    }
}

/// At an edge, with exposure and gain as the program sets them: when this frame's images come, and the next edge.
void Injector::expose(std::size_t action) {
    light_->at_edge(0, left_.controls());
    light_->at_edge(1, right_.controls());
    const std::size_t index = actions_[action].index;
    const std::size_t alive = unplugged_ ? 1 : 0;
    const auto end = actions_.begin() + static_cast<std::ptrdiff_t>(std::min(action + kLookAhead, actions_.size()));
    const auto begin = actions_.begin() + static_cast<std::ptrdiff_t>(action) + 1;
    for (auto later = begin; later != end; ++later) {
        if (later->what == What::kLeft || later->what == What::kRight) {
            const Duration half{light_->exposure(later->what == What::kLeft ? 0 : 1).ns / 2};
            later->due = later->index == index ? frames_[index].stamp + half + options_.readout : later->due;
        } else if (later->what == What::kEdge && later->index == index + 1) {
            later->due = frames_[index + 1].stamp - Duration{light_->next_exposure(alive).ns / 2};
        }
    }
    std::stable_sort(begin, end, [](const Action& a, const Action& b) { return a.due < b.due; });
}

/// A frame's image as the camera shows it.
std::span<const std::uint8_t> Injector::shown(std::size_t camera, const PlayedFrame& played) {
    const RecordedFrame& frame = recording_.frames[played.recorded];
    const std::vector<std::uint8_t>& recorded = camera == 0 ? frame.left : frame.right;
    if (!light_) {
        return recorded;
    }
    const Duration since_start = played.stamp - recording_.frames.front().stamp;
    const double dimming = active(FaultKind::kDim, played.stamp) ? kDimming : 1.0;
    const std::span<const std::uint8_t> image = light_->image(camera, recorded, since_start, dimming);
    const auto second = static_cast<std::size_t>(std::max(since_start.seconds(), 0.0));
    report_.greys.resize(std::max(report_.greys.size(), second + 1));
    report_.greys[second][camera] = light_->grey(camera);
    return image;
}

void Injector::send_left(std::size_t index, OutgoingFrame outgoing) {
    const PlayedFrame& played = frames_[index];
    const RecordedFrame& frame = recording_.frames[played.recorded];
    if (unplugged_ || active(FaultKind::kLeftDropped, played.stamp)) {
        return;
    }
    count_from_ = count_anew_ ? index : count_from_;
    count_anew_ = false;
    outgoing.sequence = static_cast<std::uint32_t>(index - count_from_);
    outgoing.bytes = shown(0, played);
    if (active(FaultKind::kTorn, played.stamp) && played.recorded > 0) {
        torn_ = frame.left;
        const std::vector<std::uint8_t>& before = recording_.frames[played.recorded - 1].left;
        std::copy(before.begin() + static_cast<std::ptrdiff_t>(before.size() / 2), before.end(),
                  torn_.begin() + static_cast<std::ptrdiff_t>(torn_.size() / 2));
        outgoing.bytes = torn_;
    }
    if (active(FaultKind::kShort, played.stamp)) {
        outgoing.bytes = outgoing.bytes.first(outgoing.bytes.size() / 2);
    }
    outgoing.error = active(FaultKind::kFlagged, played.stamp);
    outgoing.stamp = outgoing.stamp + (active(FaultKind::kAhead, played.stamp) ? kHourAhead : Duration{});
    if (options_.pixels.format != PixelFormat::kGrey) {
        packed_ = pack(options_.pixels, outgoing.bytes);
        outgoing.bytes = packed_;
    }
    left_.send(outgoing);
    ++report_.frames_sent;
}

void Injector::send_right(std::size_t index, OutgoingFrame outgoing) {
    const PlayedFrame& played = frames_[index];
    if (active(FaultKind::kRightStalled, played.stamp)) {
        ++stalled_;
        return;
    }
    if (active(FaultKind::kRightDropped, played.stamp)) {
        return;
    }
    outgoing.stamp = outgoing.stamp + (active(FaultKind::kRightLate, played.stamp) ? kRightLate : Duration{});
    outgoing.sequence -= stalled_;
    const std::vector<std::uint8_t> packed = pack(options_.pixels, shown(1, played));
    outgoing.bytes = packed;
    right_.send(outgoing);
    ++report_.frames_sent;
}

void Injector::send_frame(std::size_t index, bool left) {
    const PlayedFrame& played = frames_[index];
    const RecordedFrame& frame = recording_.frames[played.recorded];
    if (active(FaultKind::kBothDropped, played.stamp)) {
        return;
    }
    OutgoingFrame outgoing;
    const Duration exposure = light_ ? light_->exposure(left ? 0 : 1) : options_.exposure;
    outgoing.stamp = played.stamp + report_.shift + Duration{exposure.ns / 2} + options_.readout;
    outgoing.sequence = static_cast<std::uint32_t>(index);
    if (left) {
        send_left(index, outgoing);
    } else if (!frame.right.empty()) {
        send_right(index, outgoing);
    }
}

}  // namespace facet::hil
