// SPDX-License-Identifier: BSD-2-Clause
// The streams of inertial sensors on serial lines. The first byte chooses the protocol and the size of the pieces.
#include "drivers/imu_serial/microstrain.h"
#include "drivers/imu_serial/packet_stream.h"
#include "drivers/imu_serial/vectornav.h"
#include "drivers/imu_serial/xsens.h"
#include "tests/fuzz/fuzz_input.h"

using namespace facet;

namespace {

/// Reads all packets that are there. @return how many
std::size_t read_packets(SerialProtocol& protocol, PacketStream& stream) {
    std::size_t packets = 0;
    std::span<const std::uint8_t> packet;
    for (Status status = stream.next(protocol, packet); status != Status::kNotReady;
         status = stream.next(protocol, packet)) {
        if (!ok(status)) {
            continue;
        }
        ++packets;
        test::require(!packet.empty() && packet.size() <= SerialProtocol::kLongest);
        SerialReading reading;
        protocol.read(packet, reading);
        test::require(!reading.time_ns || std::abs(*reading.time_ns) < (std::int64_t{1} << 62));
    }
    return packets;
}

std::size_t read_in_pieces(SerialProtocol& protocol, std::span<const std::uint8_t> bytes, std::size_t piece) {
    PacketStream stream;
    std::size_t packets = 0;
    while (!bytes.empty()) {
        const std::span<std::uint8_t> room = stream.room();
        test::require(!room.empty());
        const std::size_t taken = std::min({piece, room.size(), bytes.size()});
        std::copy_n(bytes.begin(), taken, room.begin());
        stream.take(taken);
        bytes = bytes.subspan(taken);
        packets += read_packets(protocol, stream);
    }
    return packets;
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) {
        return 0;
    }
    VectorNav vectornav;
    Xsens xsens;
    MicroStrain microstrain;
    const std::array<SerialProtocol*, 3> protocols{&vectornav, &xsens, &microstrain};
    SerialProtocol& protocol = *protocols[data[0] % protocols.size()];
    const std::span<const std::uint8_t> bytes(data + 1, size - 1);
    // Whatever the pieces, the same packets are found.
    const std::size_t whole = read_in_pieces(protocol, bytes, bytes.size());
    protocol.reset();
    test::require(read_in_pieces(protocol, bytes, 1 + data[0] / protocols.size()) == whole);
    return 0;
}
