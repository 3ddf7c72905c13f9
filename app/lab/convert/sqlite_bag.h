// SPDX-License-Identifier: BSD-2-Clause
// Reads ROS 2 bags in sqlite3 form (FILE.db3), as ROS 2 wrote them by default before MCAP.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "app/lab/convert/bag.h"

struct sqlite3;
struct sqlite3_stmt;

namespace facet {

/// Reads the tables `topics` and `messages` in the order in which messages were recorded. The file is not changed; what
/// is no plain table, and messages beyond kMostBytes, are not read.
class SqliteBag : public Bag {
public:
    static constexpr int kMostBytes = 96 << 20;

    static bool recognises(const std::string& path);

    /// Throws InputError if it cannot be read or has not these tables.
    SqliteBag(const std::string& path, Warn warn);

    bool next(BagMessage& message) override;
    double share() const override;

private:
    struct Closer {
        void operator()(sqlite3* database) const;
        void operator()(sqlite3_stmt* statement) const;
    };
    using Statement = std::unique_ptr<sqlite3_stmt, Closer>;

    Statement prepare(const char* query) const;
    [[noreturn]] void fail() const;

    std::string path_;
    Warn warn_;
    std::unique_ptr<sqlite3, Closer> database_;
    Statement messages_;  ///< behind the database: closed before it
    std::map<std::int64_t, BagTopic> topics_;
    std::int64_t last_id_ = 0;
    std::int64_t id_ = 0;  ///< of the message read last
};

}  // namespace facet
