// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/pairing_proof.h"

#include "app/run/stamp_mapper.h"

namespace facet {
namespace {

constexpr Duration kTurn = Duration::from_seconds(0.002);  // of listening to each source

/// Takes what a source has, as monotonic stamps.
template <class Source, class Sample>
class Listener {
public:
    Listener(Source& source, const Clock& clock) : source_(source), mapper_(clock, source.clock()) {}

    void listen(std::vector<Timestamp>& stamps) {
        Sample sample;
        if (ok(source_.next(kTurn, sample)) && ok(mapper_.map(sample.stamp))) {
            stamps.push_back(sample.stamp);
        }
    }

private:
    Source& source_;
    StampMapper mapper_;
};

}  // namespace

std::optional<std::size_t> only_gap(std::span<const Timestamp> stamps, Duration period) {
    std::optional<std::size_t> after;
    for (std::size_t i = 1; i < stamps.size(); ++i) {
        if (stamps[i] - stamps[i - 1] > Duration{period.ns * 3 / 2}) {
            if (after) {
                return std::nullopt;
            }
            after = i;
        }
    }
    return after;
}

std::optional<Duration> PairingProof::lag(std::span<const Timestamp> frames, Duration period) const {
    const auto edge = only_gap(edges, period);
    const auto frame = only_gap(frames, period);
    return edge && frame ? std::optional(frames[*frame] - edges[*edge]) : std::nullopt;
}

PairingProof prove_pairing(const PairingSources& sources, Clock& clock, Duration listen,
                           const std::function<void()>& leave_out) {
    PairingProof proof;
    Listener<TriggerSource, TriggerEdge> edges(*sources.trigger, clock);
    Listener<CameraSource, CameraFrame> left(*sources.left, clock);
    std::optional<Listener<CameraSource, CameraFrame>> right;
    if (sources.right != nullptr) {
        right.emplace(*sources.right, clock);
    }
    const Timestamp begin = clock.now();
    bool is_left_out = false;
    while (clock.now() - begin < listen) {
        if (!is_left_out && clock.now() - begin > Duration{listen.ns / 2}) {
            leave_out();
            is_left_out = true;
        }
        edges.listen(proof.edges);
        left.listen(proof.left);
        if (right) {
            right->listen(proof.right);
        }
        clock.sleep(Duration{1'000});  // a source that failed does not wait
    }
    return proof;
}

}  // namespace facet
