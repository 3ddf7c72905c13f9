// SPDX-License-Identifier: BSD-2-Clause
// Joins left images, right images and trigger edges, and releases them once inertial samples cover them.
#pragma once

#include <array>
#include <cstdint>
#include <utility>

#include "drivers/sync/count_matcher.h"
#include "platform/base/ring_buffer.h"
#include "platform/base/status.h"
#include "platform/port/camera_source.h"
#include "platform/port/trigger_source.h"

namespace facet {

enum class SyncCamera : std::uint8_t { kLeft, kRight, kNone };

/// What a synchroniser can find wrong.
enum class SyncFault : std::uint8_t {
    kEpochMismatch,     ///< stamps so far from the inertial ones that the clocks have different epochs: refused
    kDuplicate,         ///< the same stamp or count twice: refused
    kOutOfOrder,        ///< a stamp before the previous one: refused
    kGap,               ///< frames or edges missing; value: how many
    kMissingLeft,       ///< a right image without a left one: delivered alone
    kMissingRight,      ///< a left image without a right one: delivered alone
    kEdgeInterpolated,  ///< the edge was lost; its instant is interpolated between its neighbours
    kDoubtful,          ///< count and time disagree, or no assignment is accepted yet: dropped
    kPairingCorrected,  ///< frames had been assigned to the wrong edges; value: how many corrections
    kTriggerSilent,     ///< frames but no edges: the cameras' own stamps count meanwhile; value: for how long (ns)
    kUnsynchronised,    ///< without edges, the cameras expose at different times: delivered alone; value: skew (ns)
    kUncovered,         ///< dropped because no inertial samples arrived
    kOrderDoubtful,     ///< the first frame does not follow the first edge at once; value: periods between them
    kLargeOffset,       ///< images are about half a period or more from where they belong; value: offset (ns)
    kCount
};
const char* to_string(SyncFault fault);

/// One finding. Repeated findings of one kind are reported once, until the fault has cleared.
struct SyncReport {
    SyncFault fault = SyncFault::kCount;
    SyncCamera camera = SyncCamera::kNone;
    Timestamp stamp;
    std::int64_t value = 0;
};

struct SynchroniserOptions {
    Duration period = Duration::from_seconds(0.05);  ///< of the cameras
    bool has_trigger = true;                         ///< else the left camera is the reference
    bool use_sequence = true;                        ///< the cameras number their frames
    Duration left_delay;                             ///< nominal, from the exposure midpoint to the left frame's stamp
    Duration right_delay;                            ///< the same for the right one
    Duration trigger_delay;                          ///< from the edge to the start of exposure
    bool has_right = true;                           ///< else there is one camera, the left one
    Duration pair_wait = Duration::from_seconds(0.1);    ///< longest wait for the other image, in inertial time
    Duration silence = Duration::from_seconds(0.5);      ///< a camera without an image for this long is not waited for
    Duration epoch_limit = Duration::from_seconds(5.0);  ///< a larger difference means different epochs
    Duration trigger_silence = Duration::from_seconds(0.5);  ///< without an edge for this long: the cameras' stamps
    Duration skew_limit = Duration::from_seconds(0.003);     ///< of pairs by stamps alone; beyond, they are none
    int votes = 5;                                           ///< see CountMatcher
    /// The cameras expose at the edges only, and all edges are known from the first one on: if the first frame lies
    /// where the first edge wants it, the assignment needs no votes.
    bool first_is_first = false;
};

/// A pair, or the view that there is, ready for the estimator.
struct SyncedFrame {
    Timestamp stamp;   ///< exposure midpoint: edge + trigger delay + exposure / 2, or the left frame's own
    CameraFrame left;  ///< the image of one of them is empty if it is missing
    CameraFrame right;
    std::uint32_t event = 0;
    bool is_by_stamps = false;  ///< the trigger is silent: stamped and paired by the cameras' own stamps
};

/// All stamps are on one clock (ClockMap). A CountMatcher assigns each camera's frames to events (edges, or the left
/// camera's frames); images of one event are a pair. An image whose partner does not come is delivered alone; without a
/// trigger, the right camera is the reference while the left one is silent. When the trigger falls silent, the cameras'
/// own stamps take its place, less the lag behind the edges that was seen until then; exposures that lie further apart
/// than skew_limit are not paired, here and without a trigger. When a camera's count falls back (its node
/// was reopened), it is continued by the time that has passed; so is a count of edges that misses the lost ones.
/// Add everything as it arrives, in any interleaving of the streams, then:
///   while (ok(sync.pop(pair))) { ... }
///   while (ok(sync.pop_report(report))) { ... }
/// A pair is delivered once an inertial stamp at or after its own has been added; stamps strictly increase. When
/// kPending images of a camera wait, the oldest is dropped. A dropped image's slot is free at once. Thread-bound. No
/// heap.
class Synchroniser {
public:
    static constexpr std::size_t kPending = 4;   ///< images that wait, of each camera
    static constexpr std::size_t kReports = 32;  ///< that wait; when full, the oldest is lost

    explicit Synchroniser(const SynchroniserOptions& options = {});

    /// @return kOutOfOrder or kInvalidArgument (epoch): refused and dropped.
    Status add_left(CameraFrame frame) { return add(SyncCamera::kLeft, std::move(frame)); }
    Status add_right(CameraFrame frame) { return add(SyncCamera::kRight, std::move(frame)); }
    /// @return kOutOfOrder or kInvalidArgument: ignored.
    Status add_edge(TriggerEdge edge);
    /// The stamp of the newest inertial sample that the estimator has.
    void add_imu(Timestamp stamp);

    /// How far images are from where the calibration has them, as estimated: about half a period or more is reported,
    /// since then they may have been given to the wrong edges.
    void add_offset(Timestamp stamp, Duration offset, Duration sigma);

    /// @return kNotReady if no pair is ready.
    Status pop(SyncedFrame& frame);
    Status pop_report(SyncReport& report);

    /// By how much the right camera's exposures lie after the left one's, as far as stamps tell: mean over some 16
    /// pairs that were made by stamps alone; zero before the first.
    Duration skew() const { return {static_cast<std::int64_t>(skew_ns_)}; }

    /// Number of findings of a kind since construction, reported or not.
    std::uint64_t count(SyncFault fault) const { return counts_[static_cast<std::size_t>(fault)]; }

private:
    struct Pending {
        CameraFrame frame;
        SyncEvent event;  ///< once assigned
        bool assigned = false;
        bool by_stamp = false;  ///< assigned while the trigger is silent
    };
    struct Stream {
        CountMatcher matcher;
        RingBuffer<Pending, kPending> pending;
        SyncEvent last;  ///< newest image taken, its count as carried on
        bool any = false;
        std::uint32_t base = 0;  ///< added to the camera's own count
        double lag_ns = 0.0;     ///< from an exposure's midpoint by the edges to the image's stamp, mean of some 16
        bool any_lag = false;
        std::uint32_t corrections = 0;
        bool is_ordered = false;  ///< its first frame has been compared with the first edge
    };

    /// Whose oldest images are delivered next.
    enum class Turn : std::uint8_t { kNobodys, kLeft, kRight, kBoth };

    Stream& stream(SyncCamera camera) { return streams_[static_cast<std::size_t>(camera)]; }
    const Stream& stream(SyncCamera camera) const { return streams_[static_cast<std::size_t>(camera)]; }
    Status add(SyncCamera camera, CameraFrame frame);
    void assign_by_order(SyncCamera camera, const SyncEvent& frame);
    std::uint32_t unnoticed_before(const TriggerEdge& edge) const;
    std::uint32_t count_at(const SyncEvent& known, Timestamp stamp) const;
    std::uint32_t base_for(const Stream& stream, const CameraFrame& frame) const;
    Status check(SyncCamera camera, const CameraFrame& frame);
    void assign(SyncCamera camera);
    void assign_by_stamp(SyncCamera camera, Pending& pending);
    void follow_lag(Stream& stream, const Pending& pending) const;
    bool is_pair(const Pending& left, const Pending& right);
    static CameraFrame take_front(Stream& stream);
    void assign_without_left(Pending& right) const;
    bool is_silent(SyncCamera camera) const;
    bool is_given_up(SyncCamera camera, Timestamp event) const;
    Turn turn() const;
    void deliver(Turn turn, SyncedFrame& frame);
    void report(SyncFault fault, SyncCamera camera, Timestamp stamp, std::int64_t value = 0);
    void clear(SyncFault fault, SyncCamera camera);

    SynchroniserOptions options_;
    std::array<Stream, 2> streams_;
    bool any_imu_ = false;
    Timestamp newest_imu_;
    bool any_frame_ = false;
    Timestamp first_frame_;
    bool any_edge_ = false;
    TriggerEdge last_edge_;        ///< its count as carried on
    SyncEvent first_edge_;         ///< with the trigger delay
    std::uint32_t edge_base_ = 0;  ///< added to the source's own count: edges that left no trace
    bool by_stamps_ = false;       ///< the trigger is silent
    SyncEvent last_by_stamp_;
    double skew_ns_ = 0.0;
    int skews_ = 0;
    bool any_given_ = false;
    Timestamp last_given_;
    RingBuffer<SyncReport, kReports> reports_;
    std::array<std::uint64_t, static_cast<std::size_t>(SyncFault::kCount)> counts_{};
    std::array<std::array<bool, 3>, static_cast<std::size_t>(SyncFault::kCount)> standing_{};
};

}  // namespace facet
