// SPDX-License-Identifier: BSD-2-Clause
// The map's work, in steps.
#include <algorithm>
#include <cmath>
#include <limits>

#include "mesh/volume/surface_map.h"

namespace facet {
namespace {

// What a step does, each of about 5 us.
constexpr int kPlaces = 50;    // compared along an epipolar line
constexpr int kCompared = 4;   // samples with another view
constexpr int kFitted = 8;     // squares
constexpr int kLookedAt = 64;  // squares, for bare regions
constexpr int kLaid = 32;      // patches about which there are blocks
constexpr int kUpdated = 1;    // blocks in view
constexpr int kPassedBy = 64;  // slots whose surface has not changed
constexpr int kExtract = 4;    // steps that a block's surface takes
constexpr std::int64_t kAll = std::numeric_limits<std::int64_t>::max() / kPassedBy;
constexpr std::uint64_t kRoundEvery = 4;  // views integrated: neighbouring ones change the same blocks
constexpr int kSurfaceShare = 8;          // of a slice: one of so many parts is for the surface, whatever waits

}  // namespace

void SurfaceMap::finish() {
    is_at_end_ = true;
    while (step() > 0) {
    }
    is_at_end_ = false;
    for (std::size_t i = 0; i < count_; ++i) {
        if (view(i).fate == Fate::kIntegrated) {
            settle(view(i));
        }
    }
    extract_all();
}

bool SurfaceMap::advance() {
    const std::int64_t for_surface = config_.steps_per_frame / kSurfaceShare;
    (void)extract(for_surface);
    std::int64_t left = config_.steps_per_frame - for_surface;
    while (left > 0) {
        const std::int64_t cost = step();
        if (cost == 0) {
            return extract(left);
        }
        left -= cost;
    }
    return true;
}

/// A little work. @return steps; 0: there is nothing to do
std::int64_t SurfaceMap::step() {
    switch (stage_) {
        case Stage::kIdle: return begin_due();
        case Stage::kMeasure: return measure();
        case Stage::kChoose: return choose();
        case Stage::kCompare: return compare();
        case Stage::kFit: return fit();
        case Stage::kBare:
            if (!bare_->advance(kLookedAt)) {
                begin_volume();
            }
            return 1;
        case Stage::kAdd: stage_ = volume_->add_blocks(kLaid) ? stage_ : Stage::kUpdate; return 1;
        case Stage::kUpdate:
            if (!volume_->update_blocks(kUpdated)) {
                end_view();
            }
            return 1;
    }
    return 0;
}

/// The oldest view that waits, if it has waited long enough.
std::int64_t SurfaceMap::begin_due() {
    constexpr std::int64_t kSteps = 100;
    std::size_t i = 0;
    while (i < count_ && view(i).fate != Fate::kWaits) {
        ++i;
    }
    if (i == count_ || !(is_at_end_ || !view(i).is_in_window || i + kSettle < count_)) {
        return 0;
    }
    own_ = (oldest_ + i) % kViews;
    View& own = views_[own_];
    own_left_.build({own.left.data(), left_size_.x(), left_size_.y(), left_size_.x()});
    right_.build({own.right.data(), right_size_.x(), right_size_.y(), right_size_.x()});
    sampler_->correct(own.cameras);
    std::ranges::fill(samples_, DepthSample{});
    growth_->begin({own.seeds.data(), own.seeds.size()});
    stage_ = Stage::kMeasure;
    return kSteps;
}

/// A few squares, or one that is searched for long.
std::int64_t SurfaceMap::measure() {
    constexpr int kBesides = 10;  // places that take as long as all else about a square
    int places = 0;
    while (places < kPlaces) {
        const int compared = growth_->advance(own_left_, right_, samples_);
        if (compared < 0) {
            stage_ = Stage::kChoose;
            break;
        }
        places += compared + kBesides;
    }
    return std::max(1, places / kPlaces);
}

/// How far away half of what a view shows is, or nearer.
double SurfaceMap::median_depth() {
    depths_.clear();
    for (const DepthSample& s : samples_) {
        if (s.inverse_depth > 0.0F) {
            depths_.push_back(s.inverse_depth);
        }
    }
    if (depths_.empty()) {
        return 0.0;
    }
    auto* const half = depths_.data() + depths_.size() / 2;
    std::nth_element(depths_.data(), half, depths_.data() + depths_.size());
    return 1.0 / static_cast<double>(*half);
}

/// Of the views on either side in time the farthest that may be compared with.
std::int64_t SurfaceMap::choose() {
    constexpr std::int64_t kSteps = 40;
    const Se3 T_own_W = views_[own_].T_W_C0.inverse();
    const double depth = median_depth();
    const std::size_t before = (own_ + kViews - oldest_) % kViews;
    partners_.clear();
    for (const bool is_later : {false, true}) {
        const std::size_t others = is_later ? count_ - 1 - before : before;
        FixedVector<Se3, kViews> T_own_others;
        const auto slot = [&](std::size_t k) { return (own_ + (is_later ? 1 + k : kViews - 1 - k)) % kViews; };
        for (std::size_t k = 0; k < others; ++k) {
            T_own_others.push_back(T_own_W * views_[slot(k)].T_W_C0);
        }
        const auto chosen = choose_partners({T_own_others.data(), T_own_others.size()}, depth);
        if (!chosen.empty()) {
            partners_.push_back({slot(chosen.back()), T_own_others[chosen.back()]});
        }
    }
    partner_ = 0;
    begin_partner();
    return kSteps;
}

/// The next one, or what comes after the last.
void SurfaceMap::begin_partner() {
    next_ = 0;
    if (partner_ == partners_.size()) {
        stage_ = Stage::kFit;
        return;
    }
    const Partner& partner = partners_[partner_];
    other_left_.build({views_[partner.slot].left.data(), left_size_.x(), left_size_.y(), left_size_.x()});
    sampler_->face(partner.T_own_other, views_[own_].cameras);
    stage_ = Stage::kCompare;
}

/// A few samples, where there are any.
std::int64_t SurfaceMap::compare() {
    const int last = std::min(layout_.count(), next_ + kLookedAt);
    for (int done = 0; next_ < last && done < kCompared; ++next_) {
        DepthSample& sample = samples_[static_cast<std::size_t>(next_)];
        if (sample.inverse_depth > 0.0F) {
            sampler_->compare(own_left_, other_left_, sample);
            ++done;
        }
    }
    if (next_ == layout_.count()) {
        ++partner_;
        begin_partner();
    }
    return 1;
}

std::int64_t SurfaceMap::fit() {
    if (next_ == 0) {
        for (DepthSample& sample : samples_) {
            sample.inverse_depth = sample.contradicted > sample.confirmed ? 0.0F : sample.inverse_depth;
        }
    }
    const int last = std::min(layout_.count(), next_ + kFitted);
    for (; next_ < last; ++next_) {
        patches_[static_cast<std::size_t>(next_)] = fit_patch(samples_, layout_, next_);
    }
    if (next_ == layout_.count()) {
        bare_->begin(own_left_.level(0), patches_);
        stage_ = Stage::kBare;
    }
    return 1;
}

void SurfaceMap::begin_volume() {
    constexpr std::size_t kShare = 16;  // of the blocks: room that a view is given
    View& own = views_[own_];
    volume_->make_room(own.T_W_C0.p, volume_->options().max_blocks / kShare);
    volume_->begin(*raster_, patches_, own.T_W_C0, static_cast<std::uint16_t>(counters_.integrated + 1));
    own.T_integrated = own.T_W_C0;
    stage_ = Stage::kAdd;
}

void SurfaceMap::end_view() {
    View& own = views_[own_];
    own.fate = Fate::kIntegrated;
    ++counters_.integrated;
    if (counters_.integrated % kRoundEvery == 0) {
        round_left_ = volume_->slot_end();
    }
    stage_ = Stage::kIdle;
    if (!own.is_in_window) {
        settle(own);
    }
}

/// Gives away the surface of the next blocks that have changed, of the round that is due. @return whether there may be
/// more
bool SurfaceMap::extract(std::int64_t steps) {
    if (sink_ == nullptr) {
        return false;
    }
    for (std::int64_t done = 0; round_left_ > 0 && done < steps * kPassedBy; ++done, --round_left_) {
        next_piece_ = next_piece_ + 1 < volume_->slot_end() ? next_piece_ + 1 : 0;
        const TsdfVolume::Block& block = volume_->block(next_piece_);
        if (block.is_used && block.is_stale) {
            volume_->clear_stale(next_piece_);
            nets_.extract(*volume_, next_piece_, *piece_);
            sink_->take(*piece_, static_cast<std::uint32_t>(counters_.restarts));
            done += kExtract * kPassedBy;
        }
    }
    return round_left_ > 0;
}

void SurfaceMap::extract_all() {
    round_left_ = volume_->slot_end();
    (void)extract(kAll);
}

}  // namespace facet
