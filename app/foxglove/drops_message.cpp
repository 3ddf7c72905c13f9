// SPDX-License-Identifier: BSD-2-Clause
#include "app/foxglove/drops_message.h"

#include "app/foxglove/json_values.h"
#include "app/foxglove/schema_parts.h"

namespace facet {

std::string drops_schema_text() {
    using schema_parts::Json;
    const Json counts{{"type", "object"},
                      {"description", "since the start: of each source, of the synchroniser, and of what follows"},
                      {"additionalProperties", schema_parts::count()}};
    return schema_parts::object(kDropsSchema, {{"timestamp", schema_parts::time()}, {"counts", counts}}).dump();
}

std::string drops_message(Timestamp stamp, std::span<const NamedCounter> counts) {
    json_values::Json values = json_values::Json::object();
    for (const NamedCounter& count : counts) {
        values[count.name] = count.value;
    }
    return json_values::Json{{"timestamp", json_values::stamp(stamp)}, {"counts", values}}.dump();
}

}  // namespace facet
