// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/mavlink/mavlink_range.h"

namespace facet {

MavDistance decode_distance(const MavlinkPayload& payload) {
    MavDistance distance;
    MavlinkReader in({payload.data(), payload.size()});
    distance.time_ms = in.take<std::uint32_t>();
    distance.min_cm = in.take<std::uint16_t>();
    distance.max_cm = in.take<std::uint16_t>();
    distance.distance_cm = in.take<std::uint16_t>();
    (void)in.take<std::uint8_t>();  // kind of the sensor
    distance.id = in.take<std::uint8_t>();
    distance.orientation = in.take<std::uint8_t>();
    (void)in.take<std::uint8_t>();  // variance, which is rounded to square centimetres
    for (int i = 0; i < 6; ++i) {   // two fields of view, quaternion of a custom orientation
        (void)in.take_float();
    }
    distance.quality = in.take<std::uint8_t>();
    return distance;
}

}  // namespace facet
