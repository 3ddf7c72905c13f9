// SPDX-License-Identifier: BSD-2-Clause
// Whether a message is as its JSON schema says: the part of JSON Schema that our schemas use.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace facet::test {

inline bool has_type(const nlohmann::json& value, const std::string& type) {
    if (type == "object") {
        return value.is_object();
    }
    if (type == "array") {
        return value.is_array();
    }
    if (type == "string") {
        return value.is_string();
    }
    if (type == "boolean") {
        return value.is_boolean();
    }
    return type == "integer" ? value.is_number_integer() : value.is_number();
}

/// @return the place of the first fault, "" if there is none; members that the schema does not have are faults
inline std::string schema_fault(const nlohmann::json& value, const nlohmann::json& schema, const std::string& at = "") {
    if (schema.contains("oneOf")) {
        for (const auto& choice : schema["oneOf"]) {
            if (choice["const"] == value) {
                return "";
            }
        }
        return at + ": none of the choices";
    }
    if (!has_type(value, schema.at("type"))) {
        return at + ": not of type " + schema.at("type").get<std::string>();
    }
    if (value.is_number() && value < schema.value("minimum", value)) {
        return at + ": too small";
    }
    if (value.is_number() && value > schema.value("maximum", value)) {
        return at + ": too large";
    }
    if (value.is_array()) {
        for (std::size_t i = 0; i < value.size(); ++i) {
            if (std::string fault = schema_fault(value[i], schema.at("items"), at + "[]"); !fault.empty()) {
                return fault;
            }
        }
        return "";
    }
    for (const auto& name : schema.value("required", nlohmann::json::array())) {
        if (!value.contains(name)) {
            return at + "." + name.get<std::string>() + ": missing";
        }
    }
    if (value.is_object()) {
        for (const auto& [name, member] : value.items()) {
            if (!schema.at("properties").contains(name)) {
                return at + "." + name + ": unknown";
            }
            if (std::string fault = schema_fault(member, schema["properties"][name], at + "." + name); !fault.empty()) {
                return fault;
            }
        }
    }
    return "";
}

}  // namespace facet::test
