// SPDX-License-Identifier: BSD-2-Clause
// What a program that begins in the middle of a flight knows of the one before it.
#pragma once

#include <optional>
#include <string>

#include "app/calibration/calibration.h"
#include "estimator/api/kept_state.h"
#include "platform/base/timestamp.h"

namespace facet {

/// Keeps attitude, place, biases and calibration in the file `last_state` of a folder, so that a program that is
/// started again after a crash or a stall goes on from there; a run that ends in order takes it away. A file that is
/// too old, of another boot (whose clock does not show the time since), or of another calibration, is not used.
/// As a service the folder is one that lasts over restarts, but not over a stop or a boot, and is in memory
/// (RuntimeDirectory with RuntimeDirectoryPreserve=restart of systemd).
/// Thread-bound. Heap.
class StateKeeper {
public:
    /// What was done longer ago says little of where the vehicle is.
    static constexpr double kOldest_s = 60.0;

    /// @param folder  empty: nothing is kept
    /// @param boot    names this boot of the computer, see boot_id()
    StateKeeper(const std::string& folder, const Calibration& calibration, std::string boot);

    struct Found {
        KeptState state;
        double elapsed_s = 0.0;
    };
    /// @param now      in the clock of keep()
    /// @param refusal  why a file that is there cannot be used, in words; empty if there is none
    std::optional<Found> load(Timestamp now, std::string& refusal) const;

    /// An earlier run has kept a state on this boot and did not end in order: the vehicle may be in the air, where a
    /// sensor's self-test takes a second that it does not have and judges masses that the flight moves. However old
    /// the state is, and of whatever calibration.
    bool is_in_flight() const;

    /// @return why it cannot be kept, in words; empty if it is, and when it is tried no more
    std::string keep(const KeptState& state, Timestamp now);
    /// After a run that ended in order: the next one begins at the origin.
    void forget() const;

private:
    std::string path_;  ///< empty: not kept
    std::string calibration_;
    std::string boot_;
};

/// The kernel's name of this boot; empty if it has none.
std::string boot_id();

}  // namespace facet
