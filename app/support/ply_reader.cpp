// SPDX-License-Identifier: BSD-2-Clause
#include "app/support/ply_reader.h"

#include <cmath>
#include <cstdint>
#include <fstream>
#include <map>
#include <sstream>

#include "platform/base/regular_file.h"

namespace facet {
namespace {

enum class Number : std::uint8_t { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

const std::map<std::string, Number>& number_names() {
    static const std::map<std::string, Number> kNames{
        {"char", Number::kInt8},     {"int8", Number::kInt8},     {"uchar", Number::kUint8},
        {"uint8", Number::kUint8},   {"short", Number::kInt16},   {"int16", Number::kInt16},
        {"ushort", Number::kUint16}, {"uint16", Number::kUint16}, {"int", Number::kInt32},
        {"int32", Number::kInt32},   {"uint", Number::kUint32},   {"uint32", Number::kUint32},
        {"float", Number::kFloat},   {"float32", Number::kFloat}, {"double", Number::kDouble},
        {"float64", Number::kDouble}};
    return kNames;
}

struct Property {
    std::string name;
    Number type = Number::kFloat;
    bool is_list = false;
    Number count_type = Number::kUint8;
};

struct Element {
    std::string name;
    std::size_t count = 0;
    std::vector<Property> properties;
};

class Reader {
public:
    Reader(std::istream& in, PlyTriangles& mesh) : in_(in), mesh_(mesh) {}

    /// Empty on success, else what is wrong.
    std::string read() {
        if (std::string problem = read_header(); !problem.empty()) {
            return problem;
        }
        for (const Element& element : elements_) {
            // Items without properties are nothing to read.
            const std::size_t count = element.properties.empty() ? 0 : element.count;
            for (std::size_t i = 0; i < count; ++i) {
                if (std::string problem = read_item(element); !problem.empty()) {
                    return problem;
                }
            }
        }
        const auto count = static_cast<int>(mesh_.vertices.size());
        for (const Eigen::Vector3i& t : mesh_.triangles) {
            if (t.minCoeff() < 0 || t.maxCoeff() >= count) {
                return "a face names a vertex that is not there";
            }
        }
        return "";
    }

private:
    std::string read_header() {
        std::string line;
        if (!std::getline(in_, line) || line.rfind("ply", 0) != 0) {
            return "not a PLY file";
        }
        while (std::getline(in_, line)) {
            std::istringstream words(line);
            std::string word;
            words >> word;
            if (word == "end_header") {
                return "";
            }
            if (word == "format") {
                words >> word;
                is_ascii_ = word == "ascii";
                if (!is_ascii_ && word != "binary_little_endian") {
                    return "format " + word + " is not supported";
                }
            } else if (word == "element") {
                Element element;
                std::int64_t count = -1;  // into an unsigned number a stream would read -1 as 2^64 - 1
                if (!(words >> element.name >> count) || count < 0) {
                    return "bad header line: " + line;
                }
                element.count = static_cast<std::size_t>(count);
                elements_.push_back(element);
            } else if (word == "property" && (elements_.empty() || !add_property(words))) {
                return "bad header line: " + line;
            }
        }
        return "header without end";
    }

    bool add_property(std::istringstream& words) {
        Property property;
        std::string type;
        words >> type;
        property.is_list = type == "list";
        if (property.is_list) {
            std::string count_type;
            words >> count_type >> type;
            if (number_names().count(count_type) == 0) {
                return false;
            }
            property.count_type = number_names().at(count_type);
        }
        words >> property.name;
        if (number_names().count(type) == 0 || property.name.empty()) {
            return false;
        }
        property.type = number_names().at(type);
        elements_.back().properties.push_back(property);
        return true;
    }

    template <class T>
    double raw() {
        T value{};
        in_.read(reinterpret_cast<char*>(&value), sizeof(T));
        return static_cast<double>(value);
    }

    double number(Number type) {
        if (is_ascii_) {
            double value = 0.0;
            in_ >> value;
            return value;
        }
        switch (type) {
            case Number::kInt8: return raw<std::int8_t>();
            case Number::kUint8: return raw<std::uint8_t>();
            case Number::kInt16: return raw<std::int16_t>();
            case Number::kUint16: return raw<std::uint16_t>();
            case Number::kInt32: return raw<std::int32_t>();
            case Number::kUint32: return raw<std::uint32_t>();
            case Number::kFloat: return raw<float>();
            case Number::kDouble: return raw<double>();
        }
        return 0.0;
    }

    std::string read_item(const Element& element) {
        Eigen::Vector3d point = Eigen::Vector3d::Zero();
        for (const Property& property : element.properties) {
            if (property.is_list) {
                const double count = number(property.count_type);
                if (!(count >= 0.0)) {
                    return "a list has a negative length";
                }
                const bool is_face =
                    element.name == "face" && (property.name == "vertex_indices" || property.name == "vertex_index");
                Eigen::Vector3i fan = Eigen::Vector3i::Constant(-1);
                for (int i = 0; i < count && in_; ++i) {
                    const double value = number(property.type);
                    const int index = std::abs(value) < 2147483648.0 ? static_cast<int>(value) : -1;
                    fan[i == 0 ? 0 : 2] = index;
                    if (i >= 2 && is_face) {
                        mesh_.triangles.push_back(fan);
                    }
                    fan[1] = i >= 1 ? index : fan[1];
                }
                continue;
            }
            const double value = number(property.type);
            for (int k = 0; k < 3; ++k) {
                point[k] = property.name == std::string(1, static_cast<char>('x' + k)) ? value : point[k];
            }
        }
        if (!in_) {
            return "truncated";
        }
        if (element.name == "vertex") {
            if (!point.allFinite()) {
                return "a coordinate is not finite";
            }
            mesh_.vertices.push_back(point);
        }
        return "";
    }

    std::istream& in_;
    PlyTriangles& mesh_;
    bool is_ascii_ = false;
    std::vector<Element> elements_;
};

}  // namespace

Status read_ply(const std::string& path, PlyTriangles& mesh, std::string& error) {
    if (const std::string refusal = refuse_file(path); !refusal.empty()) {
        error = path + ": " + refusal;
        return Status::kIo;
    }
    std::ifstream file(path, std::ios::binary);
    if (!file) {
        error = path + ": cannot be read";
        return Status::kIo;
    }
    PlyTriangles loaded;
    if (const std::string problem = Reader(file, loaded).read(); !problem.empty()) {
        error = path + ": " + problem;
        return Status::kCorrupt;
    }
    mesh = std::move(loaded);
    return Status::kOk;
}

}  // namespace facet
