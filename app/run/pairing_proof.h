// SPDX-License-Identifier: BSD-2-Clause
// Whether frames belong to the trigger pulses that time suggests: one pulse is left out, and the gap tells.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "platform/port/camera_source.h"
#include "platform/port/clock.h"
#include "platform/port/trigger_source.h"

namespace facet {

/// Where the one gap of a stream of stamps is: the index of the stamp after it. Nothing unless exactly one interval is
/// longer than one and a half periods. Reentrant.
std::optional<std::size_t> only_gap(std::span<const Timestamp> stamps, Duration period);

/// What came of leaving a pulse out.
struct PairingProof {
    std::vector<Timestamp> edges;
    std::vector<Timestamp> left;
    std::vector<Timestamp> right;

    /// From the edge after the gap to the frame after the gap: how late a camera's stamps are, whole periods included,
    /// which stamps alone cannot tell. Nothing if edges or frames do not have exactly one gap.
    std::optional<Duration> lag(std::span<const Timestamp> frames, Duration period) const;
};

/// The devices that take part, borrowed and started.
struct PairingSources {
    TriggerSource* trigger = nullptr;
    CameraSource* left = nullptr;
    CameraSource* right = nullptr;  ///< nullptr if there is none
};

/// Listens for `listen`, and half-way has `leave_out` leave out the next pulse. Heap; thread-bound.
PairingProof prove_pairing(const PairingSources& sources, Clock& clock, Duration listen,
                           const std::function<void()>& leave_out);

}  // namespace facet
