// SPDX-License-Identifier: BSD-2-Clause
// What comes out of the sensors' queues, on its way into the synchroniser.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <utility>

#include "app/run/run_queues.h"
#include "app/run/sample_tap.h"
#include "drivers/sync/synchroniser.h"
#include "platform/port/range_queue.h"

namespace facet {

struct IntakeOptions {
    SynchroniserOptions sync;
    Duration camera_time_shift;    ///< t_imu = t_cam + shift
    bool side_by_side = false;     ///< the left queue has images of both cameras
    RangeQueue* ranges = nullptr;  ///< borrowed; nullptr: there is no range finder
};

/// How often the synchroniser has found what; may be read from any thread.
using SharedFindings = std::array<std::atomic<std::uint64_t>, static_cast<std::size_t>(SyncFault::kCount)>;

/// Takes samples from their queues, shows them to a tap and gives them to the synchroniser, which counts those that it
/// refuses. Thread-bound. No heap.
class Intake {
public:
    /// The queues are borrowed.
    Intake(const IntakeOptions& options, RunQueues& queues) : options_(options), queues_(queues), sync_(options.sync) {}

    /// Shows the tap, which is borrowed, everything from now on.
    void show(SampleTap* tap) { tap_ = tap; }

    // Each takes all that is there.
    /// @return how many there were
    std::size_t take_edges();
    /// One image of each camera in turn, so that neither fills the synchroniser alone.
    /// @param after_each  called after each turn
    /// @return whether there were any
    template <class AfterEach>
    bool take_images(AfterEach after_each) {
        bool any = false;
        for (bool more = true; more; any = any || more) {
            more = take_left();
            more = take_right() || more;
            after_each();
        }
        return any;
    }
    /// @param before_each  called with each sample before the tap and the synchroniser have it
    /// @return how many there were
    template <class BeforeEach>
    std::size_t take_inertial(BeforeEach before_each) {
        std::size_t taken = 0;
        for (ImuSample sample; ok(queues_.imu.pop(sample)); ++taken) {
            before_each(std::as_const(sample));
            give(sample);
        }
        return taken;
    }

    /// @param frame  stamp of the frame before which each is given to @param give, and shown to the tap
    template <class Give>
    void take_ranges(Timestamp frame, Give give) {
        for (RangeSample sample; options_.ranges != nullptr && ok(options_.ranges->pop(sample));) {
            give(std::as_const(sample));
            show_range(sample, frame);
        }
    }

    /// The next images that fit together, shown to the tap. @return false if there are none
    bool pop(SyncedFrame& frame);

    Synchroniser& sync() { return sync_; }
    /// Brings the synchroniser's counts to where others can read them.
    void publish(SharedFindings& findings) const;

private:
    bool take_left();
    bool take_right();
    void add_halves(CameraFrame both);
    void give(const ImuSample& sample);
    void show_range(const RangeSample& sample, Timestamp frame);

    IntakeOptions options_;
    RunQueues& queues_;
    Synchroniser sync_;
    SampleTap* tap_ = nullptr;
};

}  // namespace facet
