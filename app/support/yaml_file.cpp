// SPDX-License-Identifier: BSD-2-Clause
#include "app/support/yaml_file.h"

#include <fmt/ranges.h>

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "app/support/input_error.h"
#include "app/support/whole_text.h"
#include "platform/base/range_check.h"

namespace facet {
namespace {

int line_of(const YAML::Node& node, int fallback) {
    return node.IsDefined() && node.Mark().line >= 0 ? node.Mark().line + 1 : fallback;
}

/// Throws at the first alias: none of the files needs one, and a few of them are a graph without end, or a tree that no
/// memory holds. Throws at a second document, which would be ignored. Throws when there is more in the file than it has
/// characters: at a stray bracket yaml-cpp stands still and finds something empty again and again.
class StreamRefusal : public YAML::EventHandler {
public:
    StreamRefusal(const std::string& file, std::size_t most_events) : file_(file), events_left_(most_events) {}

    void OnAlias(const YAML::Mark& mark, YAML::anchor_t /*anchor*/) override {
        refuse(mark, "aliases (*name) are not accepted: write the value out");
    }
    void OnDocumentStart(const YAML::Mark& mark) override {
        count(mark);
        if (++documents_ > 1) {
            refuse(mark, "the file goes on behind the end of its document");
        }
    }
    void OnDocumentEnd() override {}
    void OnNull(const YAML::Mark& mark, YAML::anchor_t /*anchor*/) override { count(mark); }
    void OnScalar(const YAML::Mark& mark, const std::string& /*tag*/, YAML::anchor_t /*anchor*/,
                  const std::string& /*value*/) override {
        count(mark);
    }
    void OnSequenceStart(const YAML::Mark& mark, const std::string& /*tag*/, YAML::anchor_t /*anchor*/,
                         YAML::EmitterStyle::value /*style*/) override {
        count(mark);
    }
    void OnSequenceEnd() override {}
    void OnMapStart(const YAML::Mark& mark, const std::string& /*tag*/, YAML::anchor_t /*anchor*/,
                    YAML::EmitterStyle::value /*style*/) override {
        count(mark);
    }
    void OnMapEnd() override {}

private:
    [[noreturn]] void refuse(const YAML::Mark& mark, const char* why) const {
        throw InputError(fmt::format("{}:{}: {}", file_, mark.line + 1, why));
    }
    void count(const YAML::Mark& mark) {
        if (events_left_-- == 0) {
            refuse(mark, "not valid YAML: a bracket that belongs to no other");
        }
    }

    const std::string& file_;
    std::size_t events_left_;
    int documents_ = 0;
};

void check_events(const std::string& text, const std::string& file) {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    StreamRefusal handler(file, 2 * text.size() + 8);
    while (parser.HandleNextDocument(handler)) {
    }
}

/// Throws if a map anywhere below holds a key twice: yaml-cpp would silently keep one of the two.
void reject_duplicates(const YAML::Node& node, const std::string& file) {
    if (node.IsMap()) {
        std::set<std::string> seen;
        for (const auto& item : node) {
            if (item.first.IsScalar() && !seen.insert(item.first.Scalar()).second) {
                throw InputError(
                    fmt::format("{}:{}: {}: given twice", file, line_of(item.first, 1), item.first.Scalar()));
            }
            reject_duplicates(item.second, file);
        }
    } else if (node.IsSequence()) {
        for (const YAML::Node& item : node) {
            reject_duplicates(item, file);
        }
    }
}

/// Makes a comment, which keeps the line numbers, of a line "%YAML:1.0", before which there are comments at most.
void hide_directive(std::string& text) {
    std::size_t line = 0;
    while (line < text.size() && (text[line] == '#' || text[line] == '\r' || text[line] == '\n')) {
        line = std::min(text.find('\n', line), text.size() - 1) + 1;
    }
    if (text.compare(line, 5, "%YAML") == 0) {
        text[line] = '#';
    }
}

}  // namespace

std::string out_of_range_text(std::string_view value, double min, double max, std::string_view unit) {
    return fmt::format("must be within [{}, {}]{}{}, is {}", min, max, unit == "-" ? "" : " ", unit == "-" ? "" : unit,
                       value);
}

void YamlNode::require_in_range(double value, double min, double max, std::string_view unit) const {
    if (!in_range(value, min, max)) {
        fail(out_of_range_text(fmt::format("{}", value), min, max, unit));
    }
}

void YamlNode::fail(const std::string& message) const {
    const std::string place = line_ == kNoLine ? file_ : fmt::format("{}:{}", file_, line_);
    throw InputError(field_.empty() ? fmt::format("{}: {}", place, message)
                                    : fmt::format("{}: {}: {}", place, field_, message));
}

YamlNode YamlNode::child(const YAML::Node& node, const std::string& name) const {
    return {node, file_, field_.empty() ? name : field_ + "." + name, line_of(node, line_)};
}

YamlNode YamlNode::at(const std::string& key) const {
    const std::string field = field_.empty() ? key : field_ + "." + key;
    if (has(key)) {
        for (const auto& item : node_) {  // the key's line, not that of a value that begins on the next one
            if (item.first.IsScalar() && item.first.Scalar() == key) {
                return {item.second, file_, field, line_of(item.first, line_)};
            }
        }
    }
    YamlNode(YAML::Node(), file_, field, line_).fail("missing");
}

double YamlNode::number() const {
    double value = 0.0;
    if (!node_.IsScalar() || !YAML::convert<double>::decode(node_, value)) {
        fail("must be a number");
    }
    if (!std::isfinite(value)) {
        fail("must be finite");
    }
    return value;
}

int YamlNode::integer() const {
    int value = 0;
    if (!node_.IsScalar() || !YAML::convert<int>::decode(node_, value)) {
        fail("must be an integer");
    }
    return value;
}

bool YamlNode::boolean() const {
    bool value = false;
    if (!node_.IsScalar() || !YAML::convert<bool>::decode(node_, value)) {
        fail("must be true or false");
    }
    return value;
}

std::string YamlNode::text() const {
    if (!node_.IsScalar()) {
        fail("must be text");
    }
    return node_.Scalar();
}

std::size_t YamlNode::choice(std::span<const std::string_view> choices) const {
    const std::string word = text();
    const auto at = std::find(choices.begin(), choices.end(), word);
    if (at == choices.end()) {
        fail(fmt::format("'{}' is unknown; one of: {}", word, fmt::join(choices, ", ")));
    }
    return static_cast<std::size_t>(at - choices.begin());
}

std::vector<double> YamlNode::numbers(std::size_t length) const {
    if (!node_.IsSequence() || node_.size() != length) {
        fail(fmt::format("must be a list of {} numbers", length));
    }
    std::vector<double> values;
    for (std::size_t i = 0; i < length; ++i) {
        values.push_back(child(node_[i], std::to_string(i)).number());
    }
    return values;
}

std::vector<double> YamlNode::numbers() const {
    if (has("data")) {
        return at("data").numbers();
    }
    if (!node_.IsSequence()) {
        fail("must be a list of numbers");
    }
    return numbers(node_.size());
}

YamlNode YamlNode::item(std::size_t index) const {
    if (!node_.IsSequence() || index >= node_.size()) {
        fail(fmt::format("must be a list of at least {}", index + 1));
    }
    return child(node_[index], std::to_string(index));
}

Eigen::MatrixXd YamlNode::matrix(int side) const {
    const auto count = static_cast<std::size_t>(side * side);
    const std::string complaint = fmt::format("must be a {0}x{0} matrix", side);
    const auto rows_of = [side](const std::vector<double>& values) -> Eigen::MatrixXd {
        using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
        return Eigen::Map<const RowMajor>(values.data(), side, side);
    };
    if (node_.IsMap()) {
        if (at("rows").integer() != side || at("cols").integer() != side) {
            fail(complaint);
        }
        return rows_of(at("data").numbers(count));
    }
    if (node_.IsSequence() && node_.size() == count) {
        return rows_of(numbers(count));
    }
    if (!node_.IsSequence() || node_.size() != static_cast<std::size_t>(side)) {
        fail(complaint);
    }
    Eigen::MatrixXd m(side, side);
    for (int r = 0; r < side; ++r) {
        const std::vector<double> row = item(static_cast<std::size_t>(r)).numbers(static_cast<std::size_t>(side));
        m.row(r) = Eigen::Map<const Eigen::RowVectorXd>(row.data(), side);
    }
    return m;
}

YamlNode load_yaml(const std::string& path) {
    std::string text = read_whole_text(path);
    hide_directive(text);
    try {
        check_events(text, path);
        const YAML::Node root = YAML::Load(text);
        if (!root.IsMap() && !root.IsNull()) {
            throw InputError(path + ":1: is not a map of keys to values");
        }
        reject_duplicates(root, path);
        return {root, path, "", 1};
    } catch (const YAML::ParserException& e) {
        throw InputError(fmt::format("{}:{}: not valid YAML: {}", path, e.mark.line + 1, e.msg));
    }
}

}  // namespace facet
