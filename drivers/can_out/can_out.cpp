// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/can_out/can_out.h"

#include <linux/can/error.h>

#include <algorithm>
#include <utility>

#include "drivers/can_out/node_status.h"

namespace facet {
namespace {

constexpr int kErrorFramesAtATime = 16;

}  // namespace

CanOut::CanOut(KernelIo& io, const Clock& clock, CanOutOptions options)
    : clock_(clock), options_(std::move(options)), socket_(io), retry_(options_.retry_period) {}

Status CanOut::open(std::string& problem) {
    CanSocketOptions socket;
    socket.interface = options_.interface;
    socket.fd = options_.format == CanOutFormat::kFd;
    socket.fd_if_there = options_.format == CanOutFormat::kAuto;
    socket.receives = false;
    FACET_TRY(socket_.open(socket, {}, problem));
    is_bus_off_ = false;
    if (begin_ == Timestamp{}) {
        begin_ = next_health_ = next_status_ = clock_.now();
    }
    return Status::kOk;
}

std::string CanOut::name() const { return options_.interface + (socket_.is_fd() ? ", CAN FD" : ", classic CAN"); }

/// An interface that failed is opened anew now and then; a controller that left the bus is not written to until it is
/// back, or now and then, in case the news of its return was lost.
bool CanOut::is_usable() {
    if (socket_.is_open() && !is_bus_off_) {
        return true;
    }
    if (!retry_.pass(clock_.now())) {
        return false;
    }
    is_bus_off_ = false;
    std::string unused;
    return socket_.is_open() || ok(open(unused));
}

Status CanOut::send_frame(const CanFrame& frame) {
    const Status status = socket_.send(frame);
    counters_.frames += ok(status) ? 1 : 0;
    counters_.queue_full += status == Status::kFull ? 1 : 0;
    if (status == Status::kIo) {
        ++counters_.failures;
        socket_.close();
        retry_.close(clock_.now());
    }
    return status;
}

Status CanOut::send_estimate(const Odometry& odometry) {
    const CanFrameInfo info{options_.first_id, count_, clock_.now() - odometry.stamp, options_.bit_rate_switch};
    if (socket_.is_fd()) {
        FACET_TRY(encode_fd(odometry, info, frames_[0]));
        return send_frame(frames_[0]);
    }
    FACET_TRY(encode_classic(odometry, info, frames_));
    for (const CanFrame& frame : frames_) {
        FACET_TRY(send_frame(frame));
    }
    return Status::kOk;
}

Status CanOut::send(const Odometry& odometry) {
    health_.state = odometry.state;
    health_.reasons = odometry.reasons;
    health_.quality = odometry.quality;
    if (odometry.quality < 0 && !options_.send_lost) {
        ++counters_.lost_poses;
        return Status::kOk;
    }
    if (++skipped_ < options_.every) {
        return Status::kOk;
    }
    skipped_ = 0;
    if (!is_usable()) {
        ++counters_.estimates_dropped;
        return Status::kFull;
    }
    Odometry sent = odometry;
    sent.reset_counter = static_cast<std::uint8_t>(odometry.reset_counter + first_reset_);
    const Status status = send_estimate(sent);
    if (status == Status::kInvalidArgument) {
        return status;
    }
    ++count_;
    counters_.estimates += ok(status) ? 1 : 0;
    counters_.estimates_dropped += ok(status) ? 0 : 1;
    health_.resets = sent.reset_counter;
    sent_resets_.store(sent.reset_counter, std::memory_order_relaxed);
    newest_ = odometry.stamp;
    any_ = true;
    return status;
}

void CanOut::report(const StateChange& change) {
    health_.state = change.state;
    health_.reasons = change.reasons;
    next_health_ = clock_.now();
}

void CanOut::read_errors() {
    CanFrame frame;
    for (int i = 0; i < kErrorFramesAtATime && socket_.is_open(); ++i) {
        const Status status = socket_.receive({}, frame);
        if (status == Status::kIo) {  // the interface went down
            ++counters_.failures;
            socket_.close();
            retry_.close(clock_.now());
        }
        if (!ok(status)) {
            return;
        }
        if (frame.error && (frame.id & CAN_ERR_BUSOFF) != 0) {
            counters_.bus_off += is_bus_off_ ? 0 : 1;
            is_bus_off_ = true;
            retry_.close(clock_.now());
        } else if (frame.error && (frame.id & CAN_ERR_RESTARTED) != 0) {
            is_bus_off_ = false;
        }
    }
}

void CanOut::send_health() {
    health_.age = any_ ? clock_.now() - newest_ : CanHealth{}.age;
    health_.alive = static_cast<std::uint8_t>(health_.alive + 1);
    (void)send_frame(encode_health(health_, options_.first_id));
}

void CanOut::service() {
    read_errors();
    const Timestamp now = clock_.now();
    const bool is_status_due = options_.node_id != 0 && now >= next_status_;
    if ((now < next_health_ && !is_status_due) || !is_usable()) {
        return;
    }
    if (now >= next_health_) {
        next_health_ = now + options_.health_period;
        send_health();
    }
    if (is_status_due) {
        next_status_ = now + options_.status_period;
        const auto uptime_s = static_cast<std::uint32_t>(std::max<std::int64_t>((now - begin_).ns / 1'000'000'000, 0));
        (void)send_frame(encode_node_status({options_.node_id, uptime_s, health_.state, health_.reasons, transfer_++}));
    }
}

}  // namespace facet
