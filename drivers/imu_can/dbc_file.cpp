// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/imu_can/dbc_file.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>

#include "drivers/imu_can/dbc_lexer.h"

namespace facet {
namespace {

constexpr std::uint32_t kExtendedFlag = 0x80000000U;
constexpr std::uint64_t kOrphans = 0xC0000000U;  // "VECTOR__INDEPENDENT_SIG_MSG", which holds signals of no message
constexpr int kMaxBytes = 64;                    // of a CAN FD frame

/// Statements that carry nothing we need and end at a semicolon.
constexpr std::string_view kSkipped[] = {"CM_",
                                         "BA_DEF_",
                                         "BA_",
                                         "VAL_",
                                         "CAT_DEF_",
                                         "CAT_",
                                         "FILTER",
                                         "BA_DEF_DEF_",
                                         "EV_DATA_",
                                         "ENVVAR_DATA_",
                                         "SGTYPE_",
                                         "SGTYPE_VAL_",
                                         "BA_DEF_SGTYPE_",
                                         "BA_SGTYPE_",
                                         "SIG_TYPE_REF_",
                                         "VAL_TABLE_",
                                         "SIG_GROUP_",
                                         "SIGTYPE_VALTYPE_",
                                         "BO_TX_BU_",
                                         "BA_DEF_REL_",
                                         "BA_REL_",
                                         "BA_DEF_DEF_REL_",
                                         "BU_SG_REL_",
                                         "BU_EV_REL_",
                                         "BU_BO_REL_",
                                         "EV_",
                                         "NS_DESC_"};

/// Position of the next less significant bit of a Motorola signal.
int motorola_next(int bit) { return bit % 8 == 0 ? bit + 15 : bit - 1; }

std::int64_t sign_extend(std::uint64_t raw, int length) {
    const int unused = 64 - length;
    return static_cast<std::int64_t>(raw << unused) >> unused;
}

/// Recursive-descent reader of one file.
class DbcParser {
public:
    DbcParser(std::string_view text, std::vector<DbcMessage>& messages) : lexer_(text), messages_(messages) {}

    bool run() {
        while (!lexer_.at_end()) {
            if (!statement()) {
                return false;
            }
        }
        return true;
    }
    std::string failure(std::string_view name) const {
        return std::string(name) + ":" + std::to_string(line_) + ": " + problem_;
    }

private:
    bool fail(std::string problem) {
        line_ = lexer_.line();
        problem_ = std::move(problem);
        return false;
    }

    bool statement() {
        std::string word;
        if (!lexer_.word(word)) {
            return fail("expected a statement");
        }
        if (word == "BO_") {
            return message();
        }
        if (word == "SG_") {
            return signal();
        }
        if (word == "SIG_VALTYPE_") {
            return value_type();
        }
        if (word == "VERSION") {
            std::string ignored;
            return lexer_.text(ignored) || fail("expected \"...\" after VERSION");
        }
        if (word == "NS_") {
            lexer_.skip_line();
            lexer_.skip_indented_lines();
            return true;
        }
        if (word == "BS_" || word == "BU_") {
            lexer_.skip_line();
            return true;
        }
        if (std::find(std::begin(kSkipped), std::end(kSkipped), word) != std::end(kSkipped) || word == "SG_MUL_VAL_") {
            if (word == "SG_MUL_VAL_") {
                return fail("extended multiplexing (SG_MUL_VAL_) is not supported");
            }
            return lexer_.skip_past_semicolon() || fail("no ';' at the end of " + word);
        }
        return fail("unknown statement '" + word + "'");
    }

    bool message() {
        DbcMessage message;
        std::uint64_t id = 0;
        std::uint64_t length = 0;
        std::string sender;
        if (!lexer_.number(id) || !lexer_.word(message.name) || !lexer_.symbol(':') || !lexer_.number(length) ||
            !lexer_.word(sender)) {
            return fail("expected BO_ id name: length sender");
        }
        orphan_ = id == kOrphans;
        in_message_ = true;
        if (orphan_) {
            return true;
        }
        message.extended = (id & kExtendedFlag) != 0;
        message.id = static_cast<std::uint32_t>(id & ~std::uint64_t{kExtendedFlag});
        if (id > 0xFFFFFFFFU || message.id > (message.extended ? 0x1FFFFFFFU : 0x7FFU)) {
            return fail("identifier " + std::to_string(id) + " of message " + message.name + " is out of range");
        }
        if (length > kMaxBytes) {
            return fail("message " + message.name + " is longer than 64 bytes");
        }
        for (const DbcMessage& other : messages_) {
            if (other.name == message.name || (other.id == message.id && other.extended == message.extended)) {
                return fail("message " + message.name + " has the name or identifier of another message");
            }
        }
        message.length = static_cast<int>(length);
        messages_.push_back(std::move(message));
        return true;
    }

    bool multiplexing(DbcSignal& signal) {
        std::string mark;
        if (!lexer_.word(mark)) {
            return true;
        }
        if (mark == "M") {
            signal.multiplex = DbcSignal::Multiplex::kSwitch;
            return true;
        }
        if (mark.back() == 'M') {
            return fail("extended multiplexing ('" + mark + "') is not supported");
        }
        signal.multiplex = DbcSignal::Multiplex::kValue;
        return (mark.front() == 'm' && parse_number(std::string_view(mark).substr(1), signal.multiplex_value)) ||
               fail("'" + mark + "' is not a multiplexer mark (M or m<number>)");
    }

    bool signal() {
        if (!in_message_) {
            return fail("SG_ before any BO_");
        }
        DbcSignal signal;
        if (!lexer_.word(signal.name)) {
            return fail("expected a signal name");
        }
        if (!multiplexing(signal)) {
            return false;
        }
        std::uint64_t start = 0;
        std::uint64_t length = 0;
        std::uint64_t order = 0;
        if (!lexer_.symbol(':') || !lexer_.number(start) || !lexer_.symbol('|') || !lexer_.number(length) ||
            !lexer_.symbol('@') || !lexer_.digit(order) || order > 1) {
            return fail("expected 'start|length@order' in signal " + signal.name);
        }
        signal.is_signed = lexer_.symbol('-');
        if (!signal.is_signed && !lexer_.symbol('+')) {
            return fail("expected + or - after the byte order of signal " + signal.name);
        }
        if (!lexer_.symbol('(') || !lexer_.real(signal.scale) || !lexer_.symbol(',') || !lexer_.real(signal.offset) ||
            !lexer_.symbol(')') || !lexer_.symbol('[') || !lexer_.real(signal.min) || !lexer_.symbol('|') ||
            !lexer_.real(signal.max) || !lexer_.symbol(']') || !lexer_.text(signal.unit)) {
            return fail("expected (scale,offset) [min|max] \"unit\" in signal " + signal.name);
        }
        lexer_.skip_line();  // receivers
        return add(signal, start, length, order == 1);
    }

    bool add(DbcSignal& signal, std::uint64_t start, std::uint64_t length, bool little_endian) {
        if (orphan_) {
            return true;
        }
        DbcMessage& message = messages_.back();
        if (length < 1 || length > 64 || start >= 8 * kMaxBytes) {
            return fail("signal " + signal.name + " has an impossible place or length");
        }
        signal.start_bit = static_cast<int>(start);
        signal.length = static_cast<int>(length);
        signal.little_endian = little_endian;
        if (signal.bytes_needed() > message.length) {
            return fail("signal " + signal.name + " does not fit into message " + message.name);
        }
        if (message.find(signal.name) != nullptr) {
            return fail("signal " + signal.name + " appears twice in message " + message.name);
        }
        if (signal.scale == 0.0) {
            return fail("signal " + signal.name + " has a scale of 0");
        }
        if (signal.multiplex == DbcSignal::Multiplex::kSwitch) {
            for (const DbcSignal& other : message.signals) {
                if (other.multiplex == DbcSignal::Multiplex::kSwitch) {
                    return fail("message " + message.name + " has two multiplexer switches");
                }
            }
        }
        message.signals.push_back(std::move(signal));
        return true;
    }

    bool value_type() {
        std::uint64_t id = 0;
        std::uint64_t type = 0;
        std::string name;
        if (!lexer_.number(id) || !lexer_.word(name) || !(lexer_.symbol(':'), lexer_.number(type)) ||
            !lexer_.symbol(';') || type > 2) {
            return fail("expected SIG_VALTYPE_ id signal : 0, 1 or 2;");
        }
        for (DbcMessage& message : messages_) {
            if (message.id != (id & ~std::uint64_t{kExtendedFlag}) || message.extended != ((id & kExtendedFlag) != 0)) {
                continue;
            }
            for (DbcSignal& signal : message.signals) {
                if (signal.name == name) {
                    signal.number = static_cast<DbcSignal::Number>(type);
                    return type == 0 || signal.length == (type == 1 ? 32 : 64) ||
                           fail("float signal " + name + " has a wrong length");
                }
            }
        }
        return fail("SIG_VALTYPE_ of the unknown signal " + name);
    }

    DbcLexer lexer_;
    std::vector<DbcMessage>& messages_;
    bool in_message_ = false;
    bool orphan_ = false;
    int line_ = 0;
    std::string problem_;
};

}  // namespace

int DbcSignal::bytes_needed() const {
    if (little_endian) {
        return (start_bit + length - 1) / 8 + 1;
    }
    int bit = start_bit;
    for (int i = 1; i < length; ++i) {
        bit = motorola_next(bit);
    }
    return bit / 8 + 1;
}

std::uint64_t DbcSignal::raw(std::span<const std::uint8_t> data) const {
    std::uint64_t result = 0;
    int bit = start_bit;
    for (int i = 0; i < length; ++i) {
        const std::uint64_t one = (data[static_cast<std::size_t>(bit / 8)] >> (bit % 8)) & 1U;
        if (little_endian) {
            result |= one << i;
            ++bit;
        } else {
            result = (result << 1) | one;
            bit = motorola_next(bit);
        }
    }
    return result;
}

const DbcSignal* DbcMessage::find(std::string_view signal) const {
    const auto found =
        std::find_if(signals.begin(), signals.end(), [&](const DbcSignal& s) { return s.name == signal; });
    return found == signals.end() ? nullptr : &*found;
}

Result<double> DbcMessage::value(const DbcSignal& signal, std::span<const std::uint8_t> data) const {
    const auto fits = [&](const DbcSignal& s) { return s.bytes_needed() <= static_cast<int>(data.size()); };
    if (signal.multiplex == DbcSignal::Multiplex::kValue) {
        for (const DbcSignal& other : signals) {
            if (other.multiplex != DbcSignal::Multiplex::kSwitch) {
                continue;
            }
            if (!fits(other)) {
                return Status::kCorrupt;
            }
            if (other.raw(data) != signal.multiplex_value) {
                return Status::kNotFound;
            }
        }
    }
    if (!fits(signal)) {
        return Status::kCorrupt;
    }
    const std::uint64_t raw = signal.raw(data);
    double number = signal.is_signed ? static_cast<double>(sign_extend(raw, signal.length)) : static_cast<double>(raw);
    if (signal.number == DbcSignal::Number::kFloat32) {
        number = std::bit_cast<float>(static_cast<std::uint32_t>(raw));
    } else if (signal.number == DbcSignal::Number::kFloat64) {
        number = std::bit_cast<double>(raw);
    }
    const double value = signal.scale * number + signal.offset;
    const bool outside = signal.min < signal.max && (value < signal.min || value > signal.max);
    return !std::isfinite(value) || outside ? Result<double>(Status::kCorrupt) : Result<double>(value);
}

Status DbcFile::parse(std::string_view text, std::string_view name, std::string& error) {
    std::vector<DbcMessage> messages;
    DbcParser parser(text, messages);
    if (!parser.run()) {
        error = parser.failure(name);
        return Status::kInvalidArgument;
    }
    messages_ = std::move(messages);
    return Status::kOk;
}

const DbcMessage* DbcFile::find(std::string_view message) const {
    const auto found =
        std::find_if(messages_.begin(), messages_.end(), [&](const DbcMessage& m) { return m.name == message; });
    return found == messages_.end() ? nullptr : &*found;
}

}  // namespace facet
