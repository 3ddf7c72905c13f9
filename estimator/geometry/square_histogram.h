// SPDX-License-Identifier: BSD-2-Clause
// Median of positive numbers that come one by one, such as squared residuals.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace facet {

/// Counts by size, eight bins an octave from 2^-24 to 2^16; what is smaller or larger falls into the outermost bins.
/// Value type, about 1.3 kB. No heap. Reentrant.
class SquareHistogram {
public:
    void clear() { *this = {}; }

    /// Takes one number; not finite or negative ones are ignored.
    void add(double square) {
        if (!(square >= 0.0) || !std::isfinite(square)) {
            return;
        }
        // The highest bits of a double: its exponent, and eighths of the octave from there.
        static_assert(kPerOctave == 8);
        constexpr int kEighths = 3;
        constexpr int kBias = std::numeric_limits<double>::max_exponent - 2;  // of 2^-1, where an octave begins
        const auto highest = static_cast<int>(std::bit_cast<std::uint64_t>(square) >> (52 - kEighths));
        const int bin = std::clamp(highest - (kBias + kLowest) * kPerOctave, 0, kBins - 1);
        ++bins_[static_cast<std::size_t>(square > 0.0 ? bin : 0)];
        ++count_;
    }

    int count() const { return static_cast<int>(count_); }

    /// To within a few percent: linear within its bin. 0 without any number.
    double median() const {
        const double half = 0.5 * count_;
        double below = 0.0;
        for (int bin = 0; bin < kBins; ++bin) {
            const double here = bins_[static_cast<std::size_t>(bin)];
            if (here > 0.0 && below + here >= half) {
                const double place = bin % kPerOctave + (half - below) / here;
                return std::ldexp(0.5 + 0.5 * place / kPerOctave, kLowest + bin / kPerOctave);
            }
            below += here;
        }
        return 0.0;
    }

private:
    static constexpr int kLowest = -24;
    static constexpr int kPerOctave = 8;
    static constexpr int kBins = 40 * kPerOctave;

    std::array<std::uint32_t, kBins> bins_{};
    std::uint32_t count_ = 0;
};

}  // namespace facet
