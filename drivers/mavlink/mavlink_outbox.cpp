// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/mavlink/mavlink_outbox.h"

namespace facet {

void MavlinkOutbox::pass_on(MavlinkLink& link) {
    StateChange change;
    for (std::size_t left = decltype(changes_)::capacity(); left > 0 && ok(changes_.pop(change)); --left) {
        link.report(change);
    }
    Odometry odometry;
    for (std::size_t left = decltype(estimates_)::capacity(); left > 0 && ok(estimates_.pop(odometry)); --left) {
        (void)link.send(odometry);
    }
    ObstacleRanges ranges;
    for (std::size_t left = decltype(ranges_)::capacity(); left > 0 && ok(ranges_.pop(ranges)); --left) {
        (void)link.send_ranges(ranges);
    }
}

}  // namespace facet
