// SPDX-License-Identifier: BSD-2-Clause
// Our side of imu_mavlink_flight_test.py: the samples that ImuMavlink makes of a flight controller's readings.
//
// imu_mavlink_listener PORT MESSAGE RATE   prints a row for each sample (ns, rad/s, m/s^2) until none has come for a
//                                          second and a half, or for ten from the start, then what was counted
#include <cstdio>
#include <cstdlib>
#include <string>

#include "drivers/mavlink/imu_mavlink.h"
#include "platform/linux/linux_clock.h"
#include "platform/linux/linux_kernel_io.h"

namespace facet {
namespace {

constexpr Duration kWait = Duration::from_seconds(0.05);

void print_sample(const ImuSample& s) {
    std::printf("%lld,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n", static_cast<long long>(s.stamp.ns), s.w_B.x(), s.w_B.y(),
                s.w_B.z(), s.a_B.x(), s.a_B.y(), s.a_B.z());
}

int listen(int port, const std::string& message, double rate_hz) {
    LinuxClock clock;
    LinuxKernelIo io;
    MavlinkOptions link_options;
    link_options.channel.udp_port = static_cast<std::uint16_t>(port);
    MavlinkLink link(io, clock, link_options);
    ImuMavlinkOptions options;
    options.message = message == "raw_imu" ? MavlinkImuMessage::kRawImu : MavlinkImuMessage::kHighresImu;
    options.rate_hz = rate_hz;
    ImuMavlink imu(link, clock, options);
    if (!ok(imu.start())) {
        std::fprintf(stderr, "%s\n", std::string(imu.problem()).c_str());
        return 1;
    }
    Timestamp end = clock.now() + Duration::from_seconds(10.0);
    while (clock.now() < end) {
        ImuSample sample;
        if (ok(imu.next(kWait, sample))) {
            print_sample(sample);
            end = clock.now() + Duration::from_seconds(1.5);
        }
    }
    const SourceCounters c = imu.counters();
    const ImuMavlinkCounters& m = imu.imu_counters();
    std::printf("# {\"delivered\": %llu, \"lost\": %llu, \"late\": %llu, \"refused\": %llu, \"requests\": %llu}\n",
                static_cast<unsigned long long>(c.delivered), static_cast<unsigned long long>(c.lost),
                static_cast<unsigned long long>(m.duplicates), static_cast<unsigned long long>(m.stamps_refused),
                static_cast<unsigned long long>(m.requests));
    imu.stop();
    return 0;
}

}  // namespace
}  // namespace facet

int main(int argc, char** argv) {
    if (argc != 4) {
        std::fprintf(stderr, "usage: imu_mavlink_listener PORT MESSAGE RATE\n");
        return 2;
    }
    return facet::listen(std::atoi(argv[1]), argv[2], std::atof(argv[3]));
}
