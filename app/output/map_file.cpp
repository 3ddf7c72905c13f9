// SPDX-License-Identifier: BSD-2-Clause
#include "app/output/map_file.h"

#include <fmt/core.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "app/mcap/bytes.h"
#include "app/support/input_error.h"
#include "app/support/text_file.h"
#include "platform/base/hash64.h"

namespace facet {
namespace {

constexpr std::string_view kMagic = "facetmap";
constexpr std::uint32_t kVersion = 2;
constexpr std::size_t kPointBytes = 4 * 4 + 1 + 2 * 32 + sizeof(UprightPatch);
constexpr std::size_t kPlaceBytes = 8 + 4 * 8 + 4 * 4 + 2 * 4 + 2 + kMaxPlacePoints * kPointBytes;
constexpr std::size_t kMaxBytes = 64 + kMaxPlaces * kPlaceBytes;
/// Positions beyond this are of no vehicle that sees its surroundings.
constexpr double kFar_m = 1e6;

void put_bytes(std::string& bytes, const void* data, std::size_t size) {
    bytes.append(static_cast<const char*>(data), size);
}

void put_place(std::string& bytes, const MappedPlace& place) {
    const PlaceView& view = place.view;
    put(bytes, view.stamp.ns);
    put(bytes, place.T_M_K.yaw);
    for (const double x : place.T_M_K.p) {
        put(bytes, x);
    }
    for (const float x : view.q_G_C.coeffs()) {
        put(bytes, x);
    }
    put(bytes, view.depth_m);
    put(bytes, view.shared_rho_sigma);
    put(bytes, static_cast<std::uint16_t>(view.points.size()));
    for (const PlacePoint& point : view.points) {
        for (const float x : point.p_G) {
            put(bytes, x);
        }
        put(bytes, point.depth_sigma);
        put(bytes, point.code.octave);
        put_bytes(bytes, point.code.fine.data(), sizeof(BinaryCode));
        put_bytes(bytes, point.code.coarse.data(), sizeof(BinaryCode));
        put_bytes(bytes, point.patch.data(), sizeof(UprightPatch));
    }
}

/// Takes values from bytes; what is wrong with them ends the reading.
class MapReader {
public:
    MapReader(const std::string& path, std::string_view content) : path_(path), bytes_(bytes_of(content)) {}

    [[noreturn]] void fail(const char* what) const { throw InputError(fmt::format("{}: {}", path_, what)); }

    template <class T>
    T take() {
        const T value = bytes_.take<T>();
        check_length();
        return value;
    }
    template <class Array>
    Array take_array() {
        const std::span<const std::uint8_t> taken = bytes_.take_bytes(sizeof(Array));
        check_length();
        Array array;
        std::memcpy(array.data(), taken.data(), sizeof(Array));
        return array;
    }
    template <class T>
    T number(double least, double most) {
        const T value = take<T>();
        if (!(value >= least && value <= most)) {  // not a number neither
            fail("has a value that no map can have");
        }
        return value;
    }
    bool is_at_end() const { return bytes_.left() == 0; }

private:
    void check_length() const {
        if (bytes_.failed()) {
            fail("ends too early");
        }
    }

    const std::string& path_;
    ByteReader bytes_;
};

void take_point(MapReader& reader, PlacePoint& point) {
    for (float& x : point.p_G) {
        x = reader.number<float>(-kFar_m, kFar_m);
    }
    point.depth_sigma = reader.number<float>(0.0, 1e3);
    point.code.octave = reader.number<std::int8_t>(PointCode::kMinOctave, PointCode::kMaxOctave);
    point.code.fine = reader.take_array<BinaryCode>();
    point.code.coarse = reader.take_array<BinaryCode>();
    point.patch = reader.take_array<UprightPatch>();
}

void take_place(MapReader& reader, MappedPlace& place) {
    constexpr double kTurn = 3.2;
    PlaceView& view = place.view;
    view.stamp.ns = reader.take<std::int64_t>();
    place.T_M_K.yaw = reader.number<double>(-kTurn, kTurn);
    for (double& x : place.T_M_K.p) {
        x = reader.number<double>(-kFar_m, kFar_m);
    }
    for (float& x : view.q_G_C.coeffs()) {
        x = reader.number<float>(-1.001, 1.001);
    }
    const float norm = view.q_G_C.norm();
    if (!(norm > 0.99F && norm < 1.01F)) {
        reader.fail("has an attitude of the wrong norm");
    }
    view.q_G_C.normalize();
    view.depth_m = reader.number<float>(0.0, kFar_m);
    view.shared_rho_sigma = reader.number<float>(0.0, 1e3);
    view.points.resize(reader.number<std::uint16_t>(0, kMaxPlacePoints));
    for (PlacePoint& point : view.points) {
        take_point(reader, point);
    }
}

std::string content_of(const std::string& path) {
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(path, error);
    if (error) {
        throw InputError(fmt::format("{}: cannot be read: {}", path, error.message()));
    }
    if (size > kMaxBytes) {
        throw InputError(fmt::format("{}: no map: {} bytes are more than {} places need", path, size, kMaxPlaces));
    }
    std::string bytes(size, '\0');
    std::ifstream file(path, std::ios::binary);
    if (!file.read(bytes.data(), static_cast<std::streamsize>(size))) {
        throw InputError(fmt::format("{}: cannot be read", path));
    }
    return bytes;
}

}  // namespace

void write_map(const std::string& path, const PlaceMemory& places) {
    std::string bytes(kMagic);
    put(bytes, kVersion);
    const std::size_t count_at = bytes.size();
    std::uint32_t count = 0;
    put(bytes, count);
    for (std::size_t i = 0; i < places.size(); ++i) {
        if (places.is_located(i)) {
            put_place(bytes, places.place(i));
            ++count;
        }
    }
    std::memcpy(bytes.data() + count_at, &count, sizeof(count));
    put(bytes, fnv1a(bytes));
    TextFile file(path);
    file.write(bytes);
    file.close();
}

std::vector<MappedPlace> read_map(const std::string& path) {
    const std::string bytes = content_of(path);
    if (!bytes.starts_with(kMagic)) {
        throw InputError(fmt::format("{}: no map of facet: it does not begin with '{}'", path, kMagic));
    }
    constexpr std::size_t kSum = sizeof(std::uint64_t);
    if (bytes.size() < kMagic.size() + kSum) {
        throw InputError(fmt::format("{}: ends too early", path));
    }
    const std::string_view content(bytes.data(), bytes.size() - kSum);
    MapReader reader(path, content.substr(kMagic.size()));
    if (const auto version = reader.take<std::uint32_t>(); version != kVersion) {
        throw InputError(fmt::format("{}: a map of version {}; this program reads {}", path, version, kVersion));
    }
    std::uint64_t sum = 0;
    std::memcpy(&sum, bytes.data() + content.size(), kSum);
    if (sum != fnv1a(content)) {
        reader.fail("is damaged: its checksum does not fit");
    }
    std::vector<MappedPlace> places(reader.number<std::uint32_t>(0, kMaxPlaces));
    for (MappedPlace& place : places) {
        take_place(reader, place);
    }
    if (!reader.is_at_end()) {
        reader.fail("goes on behind its last place");
    }
    return places;
}

}  // namespace facet
