// SPDX-License-Identifier: BSD-2-Clause
// A map of a YAML file whose keys are all known: what is not asked for is a mistake of the user.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/support/yaml_file.h"

namespace facet {

/// What a reader asks of a key: as much of it as is known where it asks.
struct YamlQuestion {
    std::string field;     ///< dotted path from the root
    std::string fallback;  ///< the value without it, as it is written in a file
    std::string range;     ///< what is taken, in words; empty: not known here
    bool is_required = false;
};

/// While it lives, it is notified of every key that a YamlSection is asked for on its thread, whether it is there or
/// not. One at a time. Thread-bound.
class YamlListener {
public:
    explicit YamlListener(std::function<void(const YamlQuestion&)> hear);
    ~YamlListener();
    YamlListener(const YamlListener&) = delete;
    YamlListener& operator=(const YamlListener&) = delete;
};

/// Reads one map strictly. Every key asked for counts as known; finish() complains of the others. All functions throw
/// InputError "file:line: field: what is wrong". Thread-bound; heap.
class YamlSection {
public:
    /// Throws if the node is no map; an empty one is.
    explicit YamlSection(YamlNode node);

    /// The key's node if it is there.
    std::optional<YamlNode> find(const std::string& key);
    /// The same; throws if it is missing.
    YamlNode at(const std::string& key);

    /// Values that stay as they are if the key is missing. Numbers must be within [low, high].
    void read(const std::string& key, double& value, double low, double high);
    void read(const std::string& key, int& value, int low, int high);
    void read(const std::string& key, bool& value);
    void read(const std::string& key, std::string& value);

    /// Index of the text in `choices`; `fallback` if the key is missing.
    std::size_t choice(const std::string& key, std::span<const std::string_view> choices, std::size_t fallback);

    /// One of these numbers.
    void read_one_of(const std::string& key, int& value, std::initializer_list<int> numbers);

    /// Throws at the first key that nobody asked for, and names those that there are.
    void finish() const;

    const YamlNode& node() const { return node_; }

private:
    std::optional<YamlNode> take(const std::string& key, const YamlQuestion& question);
    std::string field_of(const std::string& key) const;

    YamlNode node_;
    std::vector<std::string> known_;
};

}  // namespace facet
