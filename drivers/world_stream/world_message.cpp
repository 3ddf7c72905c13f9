// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/world_stream/world_message.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace facet {
namespace {

template <class T>
void put(std::vector<std::uint8_t>& out, T value) {
    for (std::size_t i = 0; i < sizeof(T); ++i) {
        out.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8 * i)));
    }
}

void put(std::vector<std::uint8_t>& out, float value) { put(out, std::bit_cast<std::uint32_t>(value)); }

void put(std::vector<std::uint8_t>& out, const std::array<float, 3>& values) {
    for (const float value : values) {
        put(out, value);
    }
}

/// Writes a number of items in front of them, once it is known.
class ItemCount {
public:
    explicit ItemCount(std::vector<std::uint8_t>& out) : out_(out), at_(out.size()) { put<std::uint16_t>(out, 0); }
    void add(std::size_t index) {
        ++count_;
        put(out_, static_cast<std::uint16_t>(index));
        out_[at_] = static_cast<std::uint8_t>(count_);
        out_[at_ + 1] = static_cast<std::uint8_t>(count_ >> 8U);
    }

private:
    std::vector<std::uint8_t>& out_;
    std::size_t at_;
    std::size_t count_ = 0;
};

/// The bits, so that a NaN equals itself.
bool same_bits(const std::array<float, 3>& a, const std::array<float, 3>& b) {
    return std::memcmp(a.data(), b.data(), sizeof(a)) == 0;
}

void put_faces(const WorldState* base, const WorldState& state, std::vector<std::uint8_t>& out) {
    ItemCount gone(out);
    for (std::size_t i = 0; i < state.faces.size(); ++i) {
        if (base != nullptr && base->faces[i].is_used && !state.faces[i].is_used) {
            gone.add(i);
        }
    }
    ItemCount changed(out);
    for (std::size_t i = 0; i < state.faces.size(); ++i) {
        const WorldFace& face = state.faces[i];
        if (!face.is_used || (base != nullptr && face == base->faces[i])) {
            continue;
        }
        changed.add(i);
        for (const std::uint16_t vertex : face.vertex) {
            put(out, vertex);
        }
        put(out, face.observations);
        put(out, face.plane);
        put(out, face.sigma_m);
        put<std::uint8_t>(out, face.is_fill ? 1 : 0);
    }
}

/// The part of a vector that belongs to one of kWorldBlocks blocks.
template <class T>
std::span<T> block_of(std::span<T> all, std::size_t block) {
    const std::size_t size = all.size() / kWorldBlocks;
    return all.subspan(block * size, size);
}

template <class T>
bool same_block(const std::vector<T>* base, const std::vector<T>& state, std::size_t block) {
    const std::span<const T> now = block_of(std::span<const T>(state), block);
    return base == nullptr ? std::all_of(now.begin(), now.end(), [](T value) { return value == 0; })
                           : std::ranges::equal(now, block_of(std::span<const T>(*base), block));
}

void put_blocks(const WorldState* base, const WorldState& state, std::vector<std::uint8_t>& out) {
    ItemCount changed(out);
    for (std::size_t i = 0; i < kWorldBlocks; ++i) {
        if (same_block(base != nullptr ? &base->cells : nullptr, state.cells, i) &&
            same_block(base != nullptr ? &base->levels : nullptr, state.levels, i) &&
            same_block(base != nullptr ? &base->confirmed : nullptr, state.confirmed, i)) {
            continue;
        }
        changed.add(i);
        for (const std::vector<std::uint8_t>* bytes : {&state.cells, &state.levels}) {
            const auto block = block_of(std::span<const std::uint8_t>(*bytes), i);
            out.insert(out.end(), block.begin(), block.end());
        }
        for (const std::uint16_t tick : block_of(std::span<const std::uint16_t>(state.confirmed), i)) {
            put(out, tick);
        }
    }
}

/// Takes numbers from a message; past its end all are zero, and it is not ok().
class Bytes {
public:
    explicit Bytes(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

    template <class T>
    T take() {
        const std::span<const std::uint8_t> raw = take_raw(sizeof(T));
        std::uint64_t value = 0;
        for (std::size_t i = 0; i < raw.size(); ++i) {
            value |= static_cast<std::uint64_t>(raw[i]) << (8 * i);
        }
        return static_cast<T>(value);
    }
    float take_float() { return std::bit_cast<float>(take<std::uint32_t>()); }
    std::array<float, 3> take_vector() {
        const float x = take_float();
        const float y = take_float();
        return {x, y, take_float()};
    }
    /// A number that has to be less than `end`.
    std::size_t take_below(std::size_t end) {
        const std::size_t value = take<std::uint16_t>();
        is_ok_ = is_ok_ && value < end;
        return is_ok_ ? value : 0;
    }
    std::span<const std::uint8_t> take_raw(std::size_t size) {
        is_ok_ = is_ok_ && size <= bytes_.size();
        if (!is_ok_) {
            return {};
        }
        const std::span<const std::uint8_t> taken = bytes_.first(size);
        bytes_ = bytes_.subspan(size);
        return taken;
    }
    bool ok() const { return is_ok_; }
    bool at_end() const { return bytes_.empty(); }

private:
    std::span<const std::uint8_t> bytes_;
    bool is_ok_ = true;
};

WorldFace take_face(Bytes& in) {
    WorldFace face;
    face.is_used = true;
    for (std::uint16_t& vertex : face.vertex) {
        vertex = static_cast<std::uint16_t>(in.take_below(kWorldVertices));
    }
    face.observations = in.take<std::uint16_t>();
    face.plane = in.take<std::uint32_t>();
    face.sigma_m = in.take_float();
    face.is_fill = in.take<std::uint8_t>() != 0;
    return face;
}

// What follows reads the parts of a payload. `to`: nullptr, the payload is only looked at.

void read_head(Bytes& in, WorldState* to) {
    const auto resets = in.take<std::uint32_t>();
    const auto cell_m = std::bit_cast<double>(in.take<std::uint64_t>());
    std::array<std::int32_t, 3> low{};
    for (std::int32_t& c : low) {
        c = static_cast<std::int32_t>(in.take<std::uint32_t>());
    }
    const auto tick = in.take<std::uint16_t>();
    if (to != nullptr) {
        to->resets = resets;
        to->cell_m = cell_m;
        to->low = low;
        to->tick = tick;
        to->planes.clear();
    }
    for (std::size_t n = in.take_below(kWorldPlanes + 1); n > 0 && in.ok(); --n) {
        WorldPlane plane;
        plane.id = in.take<std::uint32_t>();
        plane.normal_W = in.take_vector();
        plane.distance_m = in.take_float();
        if (to != nullptr) {
            to->planes.push_back(plane);
        }
    }
}

void read_mesh(Bytes& in, WorldState* to) {
    for (std::size_t n = in.take_below(kWorldVertices + 1); n > 0 && in.ok(); --n) {
        const std::size_t index = in.take_below(kWorldVertices);
        const std::array<float, 3> p_W = in.take_vector();
        if (to != nullptr) {
            to->vertices_W[index] = p_W;
        }
    }
    for (std::size_t n = in.take_below(kWorldFaces + 1); n > 0 && in.ok(); --n) {
        const std::size_t index = in.take_below(kWorldFaces);
        if (to != nullptr) {
            to->faces[index] = {};
        }
    }
    for (std::size_t n = in.take_below(kWorldFaces + 1); n > 0 && in.ok(); --n) {
        const std::size_t index = in.take_below(kWorldFaces);
        const WorldFace face = take_face(in);
        if (to != nullptr) {
            to->faces[index] = face;
        }
    }
}

void read_blocks(Bytes& in, WorldState* to) {
    for (std::size_t n = in.take_below(kWorldBlocks + 1); n > 0 && in.ok(); --n) {
        const std::size_t index = in.take_below(kWorldBlocks);
        const std::span<const std::uint8_t> cells = in.take_raw(kWorldBlockBytes);
        const std::span<const std::uint8_t> levels = in.take_raw(kWorldBlockBytes);
        Bytes ticks(in.take_raw(2 * kWorldBlockRuns));
        if (to != nullptr) {
            std::ranges::copy(cells, block_of(std::span(to->cells), index).begin());
            std::ranges::copy(levels, block_of(std::span(to->levels), index).begin());
            for (std::uint16_t& tick : block_of(std::span(to->confirmed), index)) {
                tick = ticks.take<std::uint16_t>();
            }
        }
    }
}

/// @return whether the payload is valid
bool read_payload(Bytes in, WorldState* to) {
    read_head(in, to);
    read_mesh(in, to);
    read_blocks(in, to);
    return in.ok() && in.at_end();
}

}  // namespace

void encode_world(const WorldState* base, const WorldState& state, std::vector<std::uint8_t>& message) {
    message.clear();
    put(message, kWorldMagic);
    put(message, kWorldVersion);
    put<std::uint16_t>(message, 0);
    put<std::uint32_t>(message, 0);
    put<std::uint64_t>(message, base == nullptr ? 0 : base->sequence);
    put(message, state.sequence);
    put(message, state.stamp_ns);
    put(message, state.resets);
    put(message, std::bit_cast<std::uint64_t>(state.cell_m));
    for (const std::int32_t c : state.low) {
        put(message, c);
    }
    put(message, state.tick);
    put(message, static_cast<std::uint16_t>(state.planes.size()));
    for (const WorldPlane& plane : state.planes) {
        put(message, plane.id);
        put(message, plane.normal_W);
        put(message, plane.distance_m);
    }
    ItemCount moved(message);
    for (std::size_t i = 0; i < state.vertices_W.size(); ++i) {
        if (!same_bits(state.vertices_W[i], base == nullptr ? std::array<float, 3>{} : base->vertices_W[i])) {
            moved.add(i);
            put(message, state.vertices_W[i]);
        }
    }
    put_faces(base, state, message);
    put_blocks(base, state, message);
    const std::size_t bytes = message.size() - kWorldHeaderBytes;
    for (std::size_t i = 0; i < 4; ++i) {
        message[8 + i] = static_cast<std::uint8_t>(bytes >> (8 * i));
    }
}

Status world_payload_bytes(std::span<const std::uint8_t> header, std::size_t& bytes) {
    Bytes in(header);
    const auto magic = in.take<std::uint32_t>();
    const auto version = in.take<std::uint16_t>();
    (void)in.take<std::uint16_t>();
    const auto length = in.take<std::uint32_t>();
    if (!in.ok() || magic != kWorldMagic || version != kWorldVersion || length < kMinWorldPayload ||
        length > kMaxWorldPayload) {
        return Status::kCorrupt;
    }
    bytes = length;
    return Status::kOk;
}

Status apply_world(std::span<const std::uint8_t> message, WorldState& state) {
    std::size_t bytes = 0;
    if (!ok(world_payload_bytes(message, bytes)) || message.size() != kWorldHeaderBytes + bytes) {
        return Status::kCorrupt;
    }
    Bytes in(message);
    (void)in.take_raw(12);
    const auto base = in.take<std::uint64_t>();
    const auto sequence = in.take<std::uint64_t>();
    const auto stamp_ns = static_cast<std::int64_t>(in.take<std::uint64_t>());
    if (sequence <= base || !read_payload(in, nullptr)) {
        return Status::kCorrupt;
    }
    if (sequence <= state.sequence || (base != 0 && base != state.sequence)) {
        return Status::kOutOfOrder;
    }
    if (base == 0) {
        std::fill(state.vertices_W.begin(), state.vertices_W.end(), std::array<float, 3>{});
        std::fill(state.faces.begin(), state.faces.end(), WorldFace{});
        std::fill(state.cells.begin(), state.cells.end(), std::uint8_t{0});
        std::fill(state.levels.begin(), state.levels.end(), std::uint8_t{0});
        std::fill(state.confirmed.begin(), state.confirmed.end(), std::uint16_t{0});
    }
    state.sequence = sequence;
    state.stamp_ns = stamp_ns;
    (void)read_payload(in, &state);
    return Status::kOk;
}

}  // namespace facet
