// SPDX-License-Identifier: BSD-2-Clause
#include "app/support/yaml_section.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

namespace facet {
namespace {

/// Of the thread; empty: nobody listens.
std::function<void(const YamlQuestion&)>& listener() {
    static thread_local std::function<void(const YamlQuestion&)> hear;
    return hear;
}

std::string in_quotes(const std::string& text) { return "\"" + text + "\""; }

}  // namespace

YamlListener::YamlListener(std::function<void(const YamlQuestion&)> hear) { listener() = std::move(hear); }

YamlListener::~YamlListener() { listener() = nullptr; }

YamlSection::YamlSection(YamlNode node) : node_(std::move(node)) {
    if (!node_.raw().IsMap() && !node_.raw().IsNull()) {
        node_.fail("must be a map of keys to values");
    }
}

std::string YamlSection::field_of(const std::string& key) const {
    return node_.field().empty() ? key : node_.field() + "." + key;
}

/// The key's node if it is there. @param question  all but the field
std::optional<YamlNode> YamlSection::take(const std::string& key, const YamlQuestion& question) {
    known_.push_back(key);
    if (listener()) {
        YamlQuestion asked = question;
        asked.field = field_of(key);
        listener()(asked);
    }
    return node_.has(key) ? std::optional<YamlNode>(node_.at(key)) : std::nullopt;
}

std::optional<YamlNode> YamlSection::find(const std::string& key) { return take(key, {}); }

YamlNode YamlSection::at(const std::string& key) {
    (void)take(key, {.field = {}, .fallback = {}, .range = {}, .is_required = true});
    return node_.at(key);
}

void YamlSection::read(const std::string& key, double& value, double low, double high) {
    if (const auto field = take(key, {{}, fmt::format("{}", value), fmt::format("[{}, {}]", low, high)})) {
        value = field->number();
        field->require_in_range(value, low, high);
    }
}

void YamlSection::read(const std::string& key, int& value, int low, int high) {
    if (const auto field = take(key, {{}, fmt::format("{}", value), fmt::format("[{}, {}]", low, high)})) {
        value = field->integer();
        field->require_in_range(value, low, high);
    }
}

void YamlSection::read(const std::string& key, bool& value) {
    if (const auto field = take(key, {{}, fmt::format("{}", value), "true or false"})) {
        value = field->boolean();
    }
}

void YamlSection::read(const std::string& key, std::string& value) {
    if (const auto field = take(key, {{}, in_quotes(value), "text"})) {
        value = field->text();
    }
}

std::size_t YamlSection::choice(const std::string& key, std::span<const std::string_view> choices,
                                std::size_t fallback) {
    const auto field =
        take(key, {{}, std::string(choices[fallback]), fmt::format("one of: {}", fmt::join(choices, ", "))});
    return field ? field->choice(choices) : fallback;
}

void YamlSection::read_one_of(const std::string& key, int& value, std::initializer_list<int> numbers) {
    const std::string all = fmt::format("one of: {}", fmt::join(numbers, ", "));
    if (const auto field = take(key, {{}, fmt::format("{}", value), all})) {
        value = field->integer();
        if (std::find(numbers.begin(), numbers.end(), value) == numbers.end()) {
            field->fail(fmt::format("is {}; {}", value, all));
        }
    }
}

void YamlSection::finish() const {
    for (const auto& item : node_.raw()) {
        const std::string key = item.first.IsScalar() ? item.first.Scalar() : "?";
        if (std::find(known_.begin(), known_.end(), key) != known_.end()) {
            continue;
        }
        std::string all;
        for (const std::string& known : known_) {
            all += (all.empty() ? "" : ", ") + known;
        }
        YamlNode(item.second, node_.file(), field_of(key), item.first.Mark().line + 1)
            .fail("unknown key; there are: " + all);
    }
}

}  // namespace facet
