// SPDX-License-Identifier: BSD-2-Clause
// YAML files whose every complaint names file, line and field.
#pragma once

#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace facet {

/// "must be within [20, 512] px, is 5".
std::string out_of_range_text(std::string_view value, double min, double max, std::string_view unit);

/// A node together with where it came from, so that errors can name it. Cheap to copy. All functions throw InputError.
class YamlNode {
public:
    /// The line of a value that is not from a file: errors name none.
    static constexpr int kNoLine = 0;

    YamlNode(const YAML::Node& node, std::string file, std::string field, int line)
        : node_(node), file_(std::move(file)), field_(std::move(field)), line_(line) {}

    /// Child of a map; throws if it is missing.
    YamlNode at(const std::string& key) const;
    bool has(const std::string& key) const { return node_.IsMap() && node_[key].IsDefined(); }

    double number() const;  ///< finite
    int integer() const;
    bool boolean() const;
    std::string text() const;
    /// Index of the node's text among these; throws with all of them if it is not one of them.
    std::size_t choice(std::span<const std::string_view> choices) const;
    /// List of finite numbers of exactly this length.
    std::vector<double> numbers(std::size_t length) const;
    /// List of finite numbers of any length; also the data of a matrix as OpenCV writes it.
    std::vector<double> numbers() const;
    /// 4x4 matrix: a list of 4 rows (Kalibr), a list of 16 numbers, or a map with rows, cols, data (EuRoC, OpenCV).
    Eigen::Matrix4d matrix4() const { return matrix(4); }
    Eigen::Matrix3d matrix3() const { return matrix(3); }  ///< likewise

    std::size_t size() const { return node_.IsSequence() ? node_.size() : 0; }  ///< of a list
    /// Part of a list; throws if it is not a list, or shorter.
    YamlNode item(std::size_t index) const;

    /// Throws with value, range and unit ("-": none) unless the node's value is within [min, max].
    void require_in_range(double value, double min, double max, std::string_view unit = "-") const;

    /// Throws InputError "file:line: field: message".
    [[noreturn]] void fail(const std::string& message) const;

    const YAML::Node& raw() const { return node_; }
    const std::string& file() const { return file_; }
    const std::string& field() const { return field_; }
    int line() const { return line_; }  ///< from 1, or kNoLine

private:
    YamlNode child(const YAML::Node& node, const std::string& name) const;
    Eigen::MatrixXd matrix(int side) const;

    YAML::Node node_;
    std::string file_;
    std::string field_;  ///< dotted path from the root
    int line_ = 1;
};

/// Reads a file (read_whole_text). A first line "%YAML:1.0", which OpenCV writes and YAML forbids, is accepted.
/// An empty file is an empty map. Throws InputError if it cannot be read, is not YAML, holds a key twice, or is no map.
YamlNode load_yaml(const std::string& path);

}  // namespace facet
