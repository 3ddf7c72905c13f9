// SPDX-License-Identifier: BSD-2-Clause
// A value, or the reason why there is none.
#pragma once

#include <optional>
#include <utility>

#include "platform/base/assert.h"
#include "platform/base/status.h"

namespace facet {

/// Outcome of a function that gives a T or fails for an expected reason. Usage:
///   Result<Frame> frame = read_frame();
///   if (!frame.ok()) return frame.status();
///   use(frame.value());
/// Never both and never neither. Reentrant. No heap of its own, no exceptions.
template <class T>
class [[nodiscard]] Result {
public:
    // Implicit on purpose: `return value;` and `return Status::kNotFound;` both read well.
    constexpr Result(T value) : value_(std::move(value)) {}
    constexpr Result(Status failure) : status_(failure) { FACET_ASSERT(failure != Status::kOk); }

    constexpr bool ok() const { return status_ == Status::kOk; }
    constexpr Status status() const { return status_; }

    /// The value. Contract: ok().
    constexpr const T& value() const& {
        FACET_ASSERT(ok());
        return *value_;
    }
    constexpr T& value() & {
        FACET_ASSERT(ok());
        return *value_;
    }
    constexpr T&& value() && {
        FACET_ASSERT(ok());
        return *std::move(value_);
    }
    /// The value, or `fallback` on failure.
    constexpr T value_or(T fallback) const& { return ok() ? *value_ : std::move(fallback); }

private:
    Status status_ = Status::kOk;
    std::optional<T> value_;
};

}  // namespace facet
