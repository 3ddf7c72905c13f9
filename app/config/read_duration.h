// SPDX-License-Identifier: BSD-2-Clause
// Durations of a YAML file, which are in seconds.
#pragma once

#include <string>

#include "app/support/yaml_section.h"
#include "platform/base/timestamp.h"

namespace facet {

/// Leaves the value as it is if the section lacks the key. Throws InputError.
inline void read_duration(YamlSection& section, const std::string& key, Duration& value, double low_s, double high_s) {
    double seconds = value.seconds();
    section.read(key, seconds, low_s, high_s);
    if (section.node().has(key)) {  // what is not given keeps its last nanosecond
        value = Duration::from_seconds(seconds);
    }
}

}  // namespace facet
