// SPDX-License-Identifier: BSD-2-Clause
// YAML files whose every complaint names file, line and field.
#pragma once

#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace facet {

/// A node together with where it came from, so that errors can name it. Cheap to copy. All functions throw InputError.
class YamlNode {
public:
    YamlNode(const YAML::Node& node, std::string file, std::string field, int line)
        : node_(node), file_(std::move(file)), field_(std::move(field)), line_(line) {}

    /// Child of a map; throws if it is missing.
    YamlNode at(const std::string& key) const;
    bool has(const std::string& key) const { return node_.IsMap() && node_[key].IsDefined(); }

    double number() const;           ///< finite
    double positive_number() const;  ///< finite and > 0
    int integer() const;
    std::string text() const;
    /// List of finite numbers of exactly this length.
    std::vector<double> numbers(std::size_t length) const;
    /// 4x4 matrix: a list of 4 rows (Kalibr), a list of 16 numbers, or a map with rows, cols, data (EuRoC, OpenCV).
    Eigen::Matrix4d matrix4() const;

    /// Throws InputError "file:line: field: message".
    [[noreturn]] void fail(const std::string& message) const;

    const YAML::Node& raw() const { return node_; }
    const std::string& file() const { return file_; }
    const std::string& field() const { return field_; }
    int line() const { return line_; }  ///< from 1

private:
    YamlNode child(const YAML::Node& node, const std::string& name) const;

    YAML::Node node_;
    std::string file_;
    std::string field_;  ///< dotted path from the root
    int line_ = 1;
};

/// Reads a file. A first line "%YAML:1.0", which OpenCV writes and YAML forbids, is accepted.
/// An empty file is an empty map. Throws InputError if it cannot be read, is not YAML, holds a key twice, or is no map.
YamlNode load_yaml(const std::string& path);

}  // namespace facet
