// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/replay_asl/pgm_decoder.h"

#include <array>

namespace facet {
namespace {

/// Takes the next number of the header, behind blanks and comments. @return false if there is none
bool take_number(std::span<const std::uint8_t>& rest, unsigned& number) {
    const auto is_blank = [](std::uint8_t c) { return c == ' ' || (c >= 9 && c <= 13); };
    while (!rest.empty() && (is_blank(rest.front()) || rest.front() == '#')) {
        if (rest.front() == '#') {
            while (!rest.empty() && rest.front() != 10) {
                rest = rest.subspan(1);
            }
        } else {
            rest = rest.subspan(1);
        }
    }
    constexpr unsigned kMost = 1'000'000;
    std::size_t digits = 0;
    number = 0;
    while (!rest.empty() && rest.front() >= '0' && rest.front() <= '9' && number < kMost) {
        number = 10 * number + (rest.front() - '0');
        rest = rest.subspan(1);
        ++digits;
    }
    return digits > 0;
}

}  // namespace

Status read_pgm(std::span<const std::uint8_t> bytes, const WantedSize& wanted, GreyImage& grey, std::string& error) {
    error.clear();
    if (bytes.size() < 2 || bytes[0] != 'P' || (bytes[1] != '5' && bytes[1] != '6')) {
        error = "damaged PGM: no binary one";
        return Status::kCorrupt;
    }
    const std::size_t channels = bytes[1] == '6' ? 3 : 1;
    std::span<const std::uint8_t> rest = bytes.subspan(2);
    unsigned width = 0;
    unsigned height = 0;
    unsigned most = 0;
    if (!take_number(rest, width) || !take_number(rest, height) || !take_number(rest, most) || rest.empty() ||
        width == 0 || height == 0 || most == 0 || most > 0xFFFFU) {
        error = "damaged PGM: its header is wrong";
        return Status::kCorrupt;
    }
    FACET_TRY(take_size(width, height, wanted, grey, error));
    rest = rest.subspan(1);  // one blank
    const std::size_t bytes_a_sample = most > 0xFFU ? 2 : 1;
    const std::size_t pixel = channels * bytes_a_sample;
    if (rest.size() / pixel / width < height) {
        error = "damaged PGM: file ends too early";
        return Status::kCorrupt;
    }
    for (std::size_t i = 0; i < grey.pixels.size(); ++i) {
        std::array<unsigned, 3> sample{};
        for (std::size_t c = 0; c < channels; ++c) {
            const std::uint8_t* const at = rest.data() + i * pixel + c * bytes_a_sample;
            sample[c] = scaled_to_8_bits(bytes_a_sample == 2 ? at[0] << 8U | at[1] : at[0], most);
        }
        grey.pixels[i] = channels == 1 ? static_cast<std::uint8_t>(sample[0]) : luma(sample[0], sample[1], sample[2]);
    }
    return Status::kOk;
}

}  // namespace facet
