// SPDX-License-Identifier: BSD-2-Clause
// Prints the value of every signal of random frames of a database, for comparison with another implementation.
#include <cstdio>
#include <fstream>
#include <iterator>
#include <random>

#include "drivers/imu_can/dbc_file.h"

/// Usage: dbc_values FILE. Lines: message, data in hexadecimal, signal, value with 17 digits or "-" if it is not there.
int main(int argc, char** argv) {
    if (argc != 2) {
        std::fputs("usage: dbc_values FILE\n", stderr);
        return 2;
    }
    std::ifstream stream(argv[1], std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
    facet::DbcFile file;
    std::string error;
    if (!stream || !facet::ok(file.parse(text, argv[1], error))) {
        std::fprintf(stderr, "%s\n", error.c_str());
        return 2;
    }
    std::mt19937 random(11);  // NOLINT(cert-msc51-cpp): fixed on purpose
    for (const facet::DbcMessage& message : file.messages()) {
        for (int i = 0; i < 200; ++i) {
            std::vector<std::uint8_t> data(static_cast<std::size_t>(message.length));
            std::string hex;
            for (std::uint8_t& byte : data) {
                byte = static_cast<std::uint8_t>(random() % (i < 100 ? 256 : 3));
                char digits[3];
                std::snprintf(digits, sizeof digits, "%02x", byte);
                hex += digits;
            }
            for (const facet::DbcSignal& signal : message.signals) {
                const facet::Result<double> value = message.value(signal, data);
                if (value.ok()) {
                    std::printf("%s %s %s %.17g\n", message.name.c_str(), hex.c_str(), signal.name.c_str(),
                                value.value());
                } else if (value.status() == facet::Status::kNotFound) {
                    std::printf("%s %s %s -\n", message.name.c_str(), hex.c_str(), signal.name.c_str());
                }
            }
        }
    }
    return 0;
}
