// SPDX-License-Identifier: BSD-2-Clause
// Packets as the sensors' documents lay them out, and a kernel with one serial line that carries them.
#pragma once

#include <asm/ioctls.h>
#include <asm/termbits.h>

#include <Eigen/Core>
#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <deque>
#include <string>
#include <vector>

#include "drivers/imu_serial/imu_serial.h"
#include "tests/support/fake_kernel.h"
#include "tests/support/scripted_source.h"

namespace facet::test {

using SerialBytes = std::vector<std::uint8_t>;

/// From text of hexadecimal digits and blanks.
inline SerialBytes from_hex(const std::string& text) {
    std::string digits;
    std::copy_if(text.begin(), text.end(), std::back_inserter(digits), [](char c) { return c != ' '; });
    SerialBytes bytes;
    for (std::size_t i = 0; i + 1 < digits.size(); i += 2) {
        bytes.push_back(static_cast<std::uint8_t>(std::stoi(digits.substr(i, 2), nullptr, 16)));
    }
    return bytes;
}

template <class Number>
void append(SerialBytes& bytes, Number value, std::endian order) {
    SerialBytes own(sizeof value);
    std::memcpy(own.data(), &value, sizeof value);
    if (order != std::endian::native) {
        std::reverse(own.begin(), own.end());
    }
    bytes.insert(bytes.end(), own.begin(), own.end());
}

inline void append(SerialBytes& bytes, const Eigen::Vector3d& v, std::endian order) {
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
        append(bytes, static_cast<float>(v[axis]), order);
    }
}

struct SerialSample {
    std::int64_t time_ns = 0;
    Eigen::Vector3d rate = {0.1, -0.2, 0.3};
    Eigen::Vector3d force = {1.0, 2.0, -9.5};
    std::uint16_t count = 0;
};

/// TimeStartup and Imu of group 1. The CRC by the manual's own steps of bytes, other than the driver's.
inline SerialBytes vectornav_packet(const SerialSample& s) {
    SerialBytes bytes{0xFA, 0x01, 0x01, 0x02};
    append(bytes, static_cast<std::uint64_t>(s.time_ns), std::endian::little);
    append(bytes, s.force, std::endian::little);
    append(bytes, s.rate, std::endian::little);
    std::uint16_t crc = 0;
    for (std::size_t i = 1; i < bytes.size(); ++i) {
        crc = static_cast<std::uint16_t>((crc >> 8) | (crc << 8));
        crc = static_cast<std::uint16_t>(crc ^ bytes[i]);
        crc = static_cast<std::uint16_t>(crc ^ ((crc & 0xFF) >> 4));
        crc = static_cast<std::uint16_t>(crc ^ (crc << 12));
        crc = static_cast<std::uint16_t>(crc ^ ((crc & 0xFF) << 5));
    }
    append(bytes, crc, std::endian::big);
    return bytes;
}

/// A message of Xsens around its data.
inline SerialBytes xsens_message(std::uint8_t identifier, const SerialBytes& data) {
    SerialBytes bytes{0xFA, 0xFF, identifier};
    if (data.size() >= 0xFF) {
        bytes.push_back(0xFF);
        append(bytes, static_cast<std::uint16_t>(data.size()), std::endian::big);
    } else {
        bytes.push_back(static_cast<std::uint8_t>(data.size()));
    }
    bytes.insert(bytes.end(), data.begin(), data.end());
    int sum = 0;
    for (std::size_t i = 1; i < bytes.size(); ++i) {
        sum += bytes[i];
    }
    bytes.push_back(static_cast<std::uint8_t>(-sum));
    return bytes;
}

inline SerialBytes xsens_packet(const SerialSample& s) {
    SerialBytes data = from_hex("1020 02");
    append(data, s.count, std::endian::big);
    const SerialBytes time = from_hex("1060 04");
    data.insert(data.end(), time.begin(), time.end());
    append(data, static_cast<std::uint32_t>(s.time_ns / 100'000), std::endian::big);
    const SerialBytes force = from_hex("4020 0C");
    data.insert(data.end(), force.begin(), force.end());
    append(data, s.force, std::endian::big);
    const SerialBytes rate = from_hex("8020 0C");
    data.insert(data.end(), rate.begin(), rate.end());
    append(data, s.rate, std::endian::big);
    return xsens_message(0x36, data);
}

/// A packet of MIP around its fields.
inline SerialBytes mip_packet(std::uint8_t set, const SerialBytes& fields) {
    SerialBytes bytes{0x75, 0x65, set, static_cast<std::uint8_t>(fields.size())};
    bytes.insert(bytes.end(), fields.begin(), fields.end());
    unsigned first = 0;
    unsigned second = 0;
    for (const std::uint8_t byte : bytes) {
        first += byte;
        second += first;
    }
    bytes.push_back(static_cast<std::uint8_t>(first));
    bytes.push_back(static_cast<std::uint8_t>(second));
    return bytes;
}

inline SerialBytes microstrain_packet(const SerialSample& s) {
    SerialBytes fields{0x0E, 0x04};
    append(fields, (s.force / 9.80665).eval(), std::endian::big);
    fields.insert(fields.end(), {0x0E, 0x05});
    append(fields, s.rate, std::endian::big);
    fields.insert(fields.end(), {0x0A, 0xD5});
    append(fields, static_cast<std::uint64_t>(s.time_ns), std::endian::big);
    return mip_packet(0x80, fields);
}

inline SerialBytes packet_of(SerialSensor sensor, const SerialSample& s) {
    switch (sensor) {
        case SerialSensor::kXsens: return xsens_packet(s);
        case SerialSensor::kMicroStrain: return microstrain_packet(s);
        case SerialSensor::kVectorNav: break;
    }
    return vectornav_packet(s);
}

/// One line. Waiting moves the clock.
class FakeSerial final : public FakeKernel {
public:
    explicit FakeSerial(ManualClock& clock) : clock_(clock) {}

    bool present = true;
    int open_lines = 0;
    int failure = 0;             ///< of reads
    std::size_t largest = 4096;  ///< bytes that one read gives
    std::uint32_t speed = 0;

    void arrive(const SerialBytes& bytes) { waiting_.insert(waiting_.end(), bytes.begin(), bytes.end()); }

    int open(const char*, int) override {
        if (!present) {
            return -ENOENT;
        }
        ++open_lines;
        return 5;
    }
    int close(int) override {
        --open_lines;
        waiting_.clear();
        return 0;
    }
    int ioctl(int, unsigned long request, void* argument) override {
        if (request == TCGETS2) {
            *static_cast<termios2*>(argument) = {};
            return 0;
        }
        if (request == TCSETS2) {
            speed = static_cast<termios2*>(argument)->c_ispeed;
            return 0;
        }
        return -ENOTTY;  // no adapter that could be asked for haste
    }
    int wait_readable(int, Duration timeout) override {
        if (!present || failure != 0 || !waiting_.empty()) {
            return 1;
        }
        clock_.advance(timeout);
        return 0;
    }
    std::int64_t read(int, void* buffer, std::size_t size) override {
        if (!present || failure != 0) {
            return failure != 0 ? failure : -EIO;
        }
        const std::size_t taken = std::min({size, largest, waiting_.size()});
        std::copy_n(waiting_.begin(), taken, static_cast<std::uint8_t*>(buffer));
        waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(taken));
        return taken > 0 ? static_cast<std::int64_t>(taken) : -EAGAIN;
    }

private:
    ManualClock& clock_;
    std::deque<std::uint8_t> waiting_;
};

}  // namespace facet::test
