// SPDX-License-Identifier: BSD-2-Clause
#include "app/output/sample_log.h"

#include <fmt/core.h>

namespace facet {

std::array<std::string, 6> fields_of(const ImuSample& sample) {
    std::array<std::string, 6> fields;
    for (std::size_t k = 0; k < 3; ++k) {
        fields[k] = fmt::format("{}", sample.w_B[static_cast<Eigen::Index>(k)]);
        fields[3 + k] = fmt::format("{}", sample.a_B[static_cast<Eigen::Index>(k)]);
    }
    return fields;
}

std::array<std::string, 6> fields_of(const PairOrigin& origin) {
    std::array<std::string, 6> fields;
    for (std::size_t camera = 0; camera < 2; ++camera) {
        fields[camera] = fmt::format("{}", origin.camera_stamp[camera].ns);
        fields[2 + camera] = fmt::format("{}", origin.sequence[camera]);
        fields[4 + camera] = fmt::format("{}", origin.exposure[camera].ns);
    }
    return fields;
}

std::array<std::string, 2> fields_of(const TriggerEdge& edge) {
    return {fmt::format("{}", edge.sequence), edge.rising ? "1" : "0"};
}

std::array<std::string, 4> fields_of(const RangeSample& sample, Timestamp frame) {
    const Eigen::Vector3d& p = sample.p_B;
    return {fmt::format("{}", p.x()), fmt::format("{}", p.y()), fmt::format("{}", p.z()), fmt::format("{}", frame.ns)};
}

}  // namespace facet
