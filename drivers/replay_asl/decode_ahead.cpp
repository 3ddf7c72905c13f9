// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/replay_asl/decode_ahead.h"

#include "drivers/replay_asl/image_decoder.h"
#include "platform/base/assert.h"

namespace facet {

DecodeAhead::DecodeAhead(const std::array<WantedSize, 2>& sizes) : sizes_(sizes), thread_([this] { work(); }) {}

DecodeAhead::~DecodeAhead() {
    {
        const std::scoped_lock lock(mutex_);
        ends_ = true;
    }
    changed_.notify_all();
    thread_.join();
}

void DecodeAhead::ask(const std::array<std::string, 2>& paths) {
    FACET_ASSERT(has_room());
    Frame& frame = slot(asked_);  // the thread leaves it alone until it has been asked for
    for (std::size_t camera = 0; camera < paths.size(); ++camera) {
        frame[camera].path = paths[camera];
    }
    {
        const std::scoped_lock lock(mutex_);
        ++asked_;
    }
    changed_.notify_all();
}

DecodeAhead::Frame& DecodeAhead::take() {
    FACET_ASSERT(taken_ < asked_);
    released_ = taken_;
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return decoded_ > taken_ || failure_ != nullptr; });
    if (decoded_ <= taken_) {
        std::rethrow_exception(failure_);
    }
    return slot(taken_++);
}

void DecodeAhead::decode(Frame& frame, ImageDecoder& decoder) {
    for (std::size_t camera = 0; camera < frame.size(); ++camera) {
        Image& image = frame[camera];
        if (image.path.empty()) {
            continue;
        }
        WantedSize& size = sizes_[camera];
        image.status = decoder.decode(image.path, size.width, size.height, image.grey);
        if (ok(image.status)) {
            size = {.width = image.grey.width, .height = image.grey.height};
        } else {
            image.error = decoder.error();
        }
    }
}

void DecodeAhead::work() {
    try {
        ImageDecoder decoder;
        std::unique_lock lock(mutex_);
        for (;;) {
            changed_.wait(lock, [&] { return ends_ || decoded_ < asked_; });
            if (ends_) {
                return;
            }
            Frame& frame = slot(decoded_);
            lock.unlock();
            decode(frame, decoder);
            lock.lock();
            ++decoded_;
            changed_.notify_all();
        }
    } catch (...) {
        const std::scoped_lock lock(mutex_);
        failure_ = std::current_exception();
        changed_.notify_all();
    }
}

}  // namespace facet
