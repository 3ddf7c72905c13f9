// SPDX-License-Identifier: BSD-2-Clause
#include "app/support/yaml_section.h"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

namespace facet {

YamlSection::YamlSection(YamlNode node) : node_(std::move(node)) {
    if (!node_.raw().IsMap() && !node_.raw().IsNull()) {
        node_.fail("must be a map of keys to values");
    }
}

std::optional<YamlNode> YamlSection::find(const std::string& key) {
    known_.push_back(key);
    return node_.has(key) ? std::optional<YamlNode>(node_.at(key)) : std::nullopt;
}

YamlNode YamlSection::at(const std::string& key) {
    known_.push_back(key);
    return node_.at(key);
}

void YamlSection::read(const std::string& key, double& value, double low, double high) {
    if (const auto field = find(key)) {
        value = field->number();
        field->require_in_range(value, low, high);
    }
}

void YamlSection::read(const std::string& key, int& value, int low, int high) {
    if (const auto field = find(key)) {
        value = field->integer();
        field->require_in_range(value, low, high);
    }
}

void YamlSection::read(const std::string& key, bool& value) {
    if (const auto field = find(key)) {
        value = field->boolean();
    }
}

void YamlSection::read(const std::string& key, std::string& value) {
    if (const auto field = find(key)) {
        value = field->text();
    }
}

std::size_t YamlSection::choice(const std::string& key, std::span<const std::string_view> choices,
                                std::size_t fallback) {
    const auto field = find(key);
    if (!field) {
        return fallback;
    }
    return field->choice(choices);
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
        const std::string field = node_.field().empty() ? key : node_.field() + "." + key;
        YamlNode(item.second, node_.file(), field, item.first.Mark().line + 1).fail("unknown key; there are: " + all);
    }
}

}  // namespace facet
