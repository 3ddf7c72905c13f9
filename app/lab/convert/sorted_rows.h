// SPDX-License-Identifier: BSD-2-Clause
// Puts rows in the order of their stamps that come nearly so.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>

namespace facet {

/// Holds the newest rows back, `capacity` at most, and gives the others in order. Thread-bound. Heap.
class SortedRows {
public:
    using Give = std::function<void(std::int64_t stamp_ns, const std::string& row)>;

    SortedRows(std::size_t capacity, Give give) : capacity_(capacity), give_(std::move(give)) {}

    /// @return false if the stamp has been given already, or a later one: the row is dropped
    bool add(std::int64_t stamp_ns, const std::string& row) {
        if ((last_ns_.has_value() && stamp_ns <= *last_ns_) || !rows_.try_emplace(stamp_ns, row).second) {
            return false;
        }
        if (rows_.size() > capacity_) {
            give_first();
        }
        return true;
    }
    /// Gives all that is left.
    void finish() {
        while (!rows_.empty()) {
            give_first();
        }
    }

private:
    void give_first() {
        const auto first = rows_.begin();
        last_ns_ = first->first;
        give_(first->first, first->second);
        rows_.erase(first);
    }

    std::size_t capacity_;
    Give give_;
    std::map<std::int64_t, std::string> rows_;
    std::optional<std::int64_t> last_ns_;
};

}  // namespace facet
