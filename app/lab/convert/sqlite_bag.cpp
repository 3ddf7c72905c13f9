// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/convert/sqlite_bag.h"

#include <sqlite3.h>

#include <fstream>
#include <string_view>
#include <utility>

#include "app/support/input_error.h"
#include "platform/base/regular_file.h"

namespace facet {
namespace {

constexpr std::string_view kDatabaseMagic{"SQLite format 3\0", 16};

std::string column_text(sqlite3_stmt* statement, int column) {
    const auto* const text = reinterpret_cast<const char*>(sqlite3_column_text(statement, column));
    return text == nullptr ? std::string() : std::string(text);
}

}  // namespace

void SqliteBag::Closer::operator()(sqlite3* database) const { sqlite3_close_v2(database); }
void SqliteBag::Closer::operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }

bool SqliteBag::recognises(const std::string& path) {
    char begin[kDatabaseMagic.size()] = {};
    std::ifstream file;
    if (refuse_file(path).empty()) {
        file.open(path, std::ios::binary);
    }
    return file.read(begin, sizeof(begin)) && std::string_view(begin, sizeof(begin)) == kDatabaseMagic;
}

void SqliteBag::fail() const {
    throw InputError(path_ + ": is not a bag of ROS 2: " + sqlite3_errmsg(database_.get()));
}

SqliteBag::Statement SqliteBag::prepare(const char* query) const {
    sqlite3_stmt* statement = nullptr;
    if (sqlite3_prepare_v2(database_.get(), query, -1, &statement, nullptr) != SQLITE_OK) {
        fail();
    }
    return Statement(statement);
}

SqliteBag::SqliteBag(const std::string& path, Warn warn) : path_(path), warn_(std::move(warn)) {
    sqlite3* database = nullptr;
    const int status = sqlite3_open_v2(path.c_str(), &database, SQLITE_OPEN_READONLY, nullptr);
    database_.reset(database);  // there to be closed also after a failure
    if (status != SQLITE_OK) {
        fail();
    }
    sqlite3_limit(database, SQLITE_LIMIT_LENGTH, kMostBytes);
    // A view could run for ever, so only tables count.
    const Statement tables =
        prepare("SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name IN ('topics', 'messages')");
    if (sqlite3_step(tables.get()) != SQLITE_ROW || sqlite3_column_int(tables.get(), 0) != 2) {
        throw InputError(path + ": has no tables of topics and messages, as bags of ROS 2 do");
    }
    const Statement topics = prepare("SELECT id, name, type FROM topics WHERE serialization_format = 'cdr'");
    while (sqlite3_step(topics.get()) == SQLITE_ROW) {
        topics_[sqlite3_column_int64(topics.get(), 0)] = {column_text(topics.get(), 1),
                                                          short_type(column_text(topics.get(), 2)), WireFormat::kCdr};
    }
    const Statement last = prepare("SELECT max(id) FROM messages");
    last_id_ = sqlite3_step(last.get()) == SQLITE_ROW ? sqlite3_column_int64(last.get(), 0) : 0;
    messages_ = prepare("SELECT id, topic_id, timestamp, data FROM messages ORDER BY id");
}

double SqliteBag::share() const {
    return last_id_ <= 0 ? 1.0 : static_cast<double>(id_) / static_cast<double>(last_id_);
}

bool SqliteBag::next(BagMessage& message) {
    int status = SQLITE_ROW;
    while ((status = sqlite3_step(messages_.get())) == SQLITE_ROW) {
        id_ = sqlite3_column_int64(messages_.get(), 0);
        const auto topic = topics_.find(sqlite3_column_int64(messages_.get(), 1));
        if (topic == topics_.end()) {
            continue;
        }
        const auto* const data = static_cast<const std::uint8_t*>(sqlite3_column_blob(messages_.get(), 3));
        const auto size = static_cast<std::size_t>(sqlite3_column_bytes(messages_.get(), 3));
        message = {&topic->second,
                   static_cast<std::uint64_t>(sqlite3_column_int64(messages_.get(), 2)),
                   {data, data == nullptr ? 0 : size}};
        return true;
    }
    if (status != SQLITE_DONE) {
        warn_(path_ + ": cannot be read to its end: " + sqlite3_errmsg(database_.get()));
    }
    return false;
}

}  // namespace facet
