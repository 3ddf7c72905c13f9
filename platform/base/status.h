// SPDX-License-Identifier: BSD-2-Clause
// The closed set of expected failures. Each value says what the caller does next.
#pragma once

#include <cstdint>

namespace facet {

/// Outcome of an operation that may fail for an expected reason. On anything but kOk the outputs are untouched.
// clang-format off
enum class [[nodiscard]] Status : std::uint8_t {
    // clang-format on
    kOk = 0,
    kInvalidArgument,  ///< the input can never work: fix the caller or the file
    kNotReady,         ///< try again after more data
    kOutOfOrder,       ///< stamp not after the previous one: drop the sample and count it
    kFull,             ///< capacity reached: drop by the container's stated policy and count it
    kNotFound,         ///< nothing there: skip it
    kDegenerate,       ///< the numbers do not determine the answer: leave this term out
    kCorrupt,          ///< the data contradicts itself (checksum, truncated): drop it and count it
    kIo,               ///< the operating system refused: report with its context, retry higher up
    kEndOfStream,      ///< no more data will come: finish
};

constexpr bool ok(Status s) { return s == Status::kOk; }

/// Name of a status for logs; never null.
constexpr const char* to_string(Status s) {
    switch (s) {
        case Status::kOk: return "ok";
        case Status::kInvalidArgument: return "invalid argument";
        case Status::kNotReady: return "not ready";
        case Status::kOutOfOrder: return "out of order";
        case Status::kFull: return "full";
        case Status::kNotFound: return "not found";
        case Status::kDegenerate: return "degenerate";
        case Status::kCorrupt: return "corrupt";
        case Status::kIo: return "input/output error";
        case Status::kEndOfStream: return "end of stream";
    }
    return "unknown";
}

}  // namespace facet

/// Returns the status of `expression` from the enclosing function unless it is kOk.
#define FACET_TRY(expression)                                                                        \
    do {                                                                                             \
        if (const ::facet::Status facet_try_status = (expression); !::facet::ok(facet_try_status)) { \
            return facet_try_status;                                                                 \
        }                                                                                            \
    } while (false)
