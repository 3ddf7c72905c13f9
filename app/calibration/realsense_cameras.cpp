// SPDX-License-Identifier: BSD-2-Clause
#include "app/calibration/realsense_cameras.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include "app/calibration/calibration_fields.h"
#include "app/support/input_error.h"
#include "app/support/whole_text.h"
#include "app/support/yaml_file.h"

namespace facet {
namespace {

struct ListedLens {
    std::string stream;
    std::string formats;  ///< as they stand behind the size
    ImageExtent size;
    std::map<std::string, std::string> fields;
    YamlNode blame;
};
struct ListedTransform {
    std::string from;
    std::string to;
    std::vector<double> rotation;  ///< by rows
    std::vector<double> translation;
    YamlNode blame;
};
struct Listing {
    std::vector<ListedLens> lenses;
    std::vector<ListedTransform> transforms;
    bool corrects_imu = false;  ///< some motion intrinsics are not those of an ideal IMU
    int devices = 0;
};

std::string_view trimmed(std::string_view text) {
    constexpr std::string_view kBlanks = " \t\r";
    const std::size_t begin = text.find_first_not_of(kBlanks);
    return begin == std::string_view::npos ? std::string_view{}
                                           : text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

std::vector<double> numbers_of(std::string_view text) {
    std::istringstream stream{std::string(text)};
    stream.imbue(std::locale::classic());
    std::vector<double> numbers;
    for (double x = 0.0; stream >> x;) {
        numbers.push_back(x);
    }
    return numbers;
}

/// The text in the quotation marks number `index`.
std::string quoted(std::string_view line, int index) {
    for (; index >= 0; --index) {
        const std::size_t begin = line.find('"');
        const std::size_t end = begin == std::string_view::npos ? begin : line.find('"', begin + 1);
        if (end == std::string_view::npos) {
            return "";
        }
        if (index == 0) {
            return std::string(line.substr(begin + 1, end - begin - 1));
        }
        line.remove_prefix(end + 1);
    }
    return "";
}

/// Reads the listing line by line; what it does not know it skips.
class ListingReader {
public:
    ListingReader(const std::string& path, const std::string& text) : path_(path), lines_(text) {}

    Listing read() {
        for (std::string_view line; next(line);) {
            if (line.starts_with("Device info")) {
                if (++listing_.devices > 1) {
                    break;
                }
            } else if (line.starts_with("Intrinsic of")) {
                read_lens(line);
            } else if (line.starts_with("Extrinsic from")) {
                read_transform_of(line);
            } else if (line.starts_with("Sensitivity")) {
                read_sensitivity();
            }
        }
        return std::move(listing_);
    }

private:
    bool next(std::string_view& line) {
        if (!std::getline(lines_, line_)) {
            return false;
        }
        ++number_;
        line = trimmed(line_);
        return true;
    }
    YamlNode blame(std::string field) const { return {YAML::Node(), path_, std::move(field), number_}; }

    void read_lens(std::string_view line) {
        ListedLens lens{.stream = quoted(line, 0), .formats = {}, .size = {}, .fields = {}, .blame = blame("")};
        lens.blame = blame("Intrinsic of \"" + lens.stream + "\"");
        lens.formats = std::string(line.substr(line.rfind('"') + 1));
        for (std::string_view field; next(field) && !field.empty();) {
            if (const std::size_t colon = field.find(':'); colon != std::string_view::npos) {
                lens.fields[std::string(field.substr(0, colon))] = trimmed(field.substr(colon + 1));
            }
        }
        const std::vector<double> width = numbers_of(lens.fields["Width"]);
        const std::vector<double> height = numbers_of(lens.fields["Height"]);
        if (width.size() == 1 && height.size() == 1) {  // else it is not available
            lens.size = {static_cast<int>(width[0]), static_cast<int>(height[0])};
            listing_.lenses.push_back(std::move(lens));
        }
    }

    void read_transform_of(std::string_view line) {
        const std::string from = quoted(line, 0);
        const std::string to = quoted(line, 1);
        ListedTransform t{from, to, {}, {}, blame("Extrinsic from \"" + from + "\" to \"" + to + "\"")};
        std::string_view row;
        if (!next(row) || !row.starts_with("Rotation Matrix")) {
            return;  // N/A
        }
        for (int i = 0; i < 3 && next(row); ++i) {
            const std::vector<double> numbers = numbers_of(row);
            t.rotation.insert(t.rotation.end(), numbers.begin(), numbers.end());
        }
        while (t.translation.empty() && next(row)) {
            if (!row.empty()) {
                t.translation = numbers_of(row.substr(std::min(row.size(), row.find(':') + 1)));
                break;
            }
        }
        if (t.rotation.size() != 9 || t.translation.size() != 3) {
            t.blame.fail("is not a rotation matrix with a translation vector");
        }
        listing_.transforms.push_back(std::move(t));
    }

    void read_sensitivity() {
        std::string_view row;
        for (std::size_t i = 0; i < 3 && next(row); ++i) {
            const std::vector<double> numbers = numbers_of(row);
            for (std::size_t j = 0; j < numbers.size(); ++j) {
                const double ideal = i == j ? 1.0 : 0.0;
                listing_.corrects_imu = listing_.corrects_imu || numbers[j] != ideal;
            }
        }
    }

    const std::string& path_;
    std::istringstream lines_;
    std::string line_;
    int number_ = 0;
    Listing listing_;
};

double field_number(const ListedLens& lens, const char* key) {
    const auto field = lens.fields.find(key);
    const std::vector<double> numbers = field == lens.fields.end() ? std::vector<double>{} : numbers_of(field->second);
    if (numbers.size() != 1) {
        lens.blame.fail(fmt::format("{}: is missing, or no number", key));
    }
    return numbers[0];
}

bool is_zero(const std::vector<double>& values) {
    return std::ranges::all_of(values, [](double x) { return x == 0.0; });
}

CameraModel listed_camera(const ListedLens& lens) {
    const auto coefficients = lens.fields.find("Coeffs");
    const auto model = lens.fields.find("Distortion");
    std::vector<double> c =
        coefficients == lens.fields.end() ? std::vector<double>{} : numbers_of(coefficients->second);
    if (model == lens.fields.end() || c.size() != 5) {
        lens.blame.fail("Distortion and five Coeffs: missing");
    }
    const std::string& name = model->second;
    std::string distortion = "plumb_bob";
    if (name == "None") {
        distortion = "none";
    } else if (name == "Inverse Brown Conrady" && !is_zero(c)) {
        lens.blame.fail(
            "Inverse Brown Conrady maps from distorted to undistorted points, which is not supported: use the "
            "infrared streams, which are rectified, or calibrate this camera, for example with Kalibr");
    } else if (name == "Modified Brown Conrady" && !(c[2] == 0.0 && c[3] == 0.0)) {
        lens.blame.fail("Modified Brown Conrady with tangential coefficients is not supported");
    } else if (name.starts_with("Kannala Brandt")) {
        distortion = "equidistant";
        c.resize(4);
    } else if (name == "F-Theta" || name == "Ftheta") {
        distortion = "fov";
        c.resize(1);
    } else if (!name.ends_with("Brown Conrady")) {
        lens.blame.fail(fmt::format("unknown distortion '{}'", name));
    }
    return make_camera({.model = "pinhole",
                        .distortion = distortion,
                        .intrinsics = {field_number(lens, "Fx"), field_number(lens, "Fy"), field_number(lens, "PPX"),
                                       field_number(lens, "PPY")},
                        .coefficients = distortion == "none" ? std::vector<double>{} : c,
                        .resolution = {static_cast<double>(lens.size.width), static_cast<double>(lens.size.height)},
                        .model_node = lens.blame,
                        .distortion_node = lens.blame,
                        .intrinsics_node = lens.blame,
                        .coefficients_node = lens.blame,
                        .resolution_node = lens.blame});
}

bool has_stream(const Listing& listing, const std::string& stream) {
    return std::ranges::any_of(listing.lenses, [&](const ListedLens& lens) { return lens.stream == stream; });
}

/// The stream's lens for images of this size. Of two the one that is not of raw images alone: {Y16} is for calibration.
const ListedLens& choose_lens(const Listing& listing, const std::string& stream, const ImageExtent& images) {
    std::set<std::pair<int, int>> sizes;
    const ListedLens* first = nullptr;
    const ListedLens* chosen = nullptr;
    for (const ListedLens& lens : listing.lenses) {
        if (lens.stream != stream) {
            continue;
        }
        first = first == nullptr ? &lens : first;
        sizes.insert({lens.size.width, lens.size.height});
        const bool fits = images.width == 0 || lens.size == images;
        const bool is_better = chosen == nullptr || chosen->formats.find("{Y16}") != std::string::npos;
        chosen = fits && is_better ? &lens : chosen;
    }
    if (chosen != nullptr && (images.width > 0 || sizes.size() == 1)) {
        return *chosen;
    }
    std::vector<std::string> names;
    names.reserve(sizes.size());
    for (const auto& [width, height] : sizes) {
        names.push_back(fmt::format("{}x{}", width, height));
    }
    first->blame.fail(images.width > 0
                          ? fmt::format("the images have {}x{} px, which is none of its resolutions: {}", images.width,
                                        images.height, fmt::join(names, ", "))
                          : fmt::format("is there for {}, and no image says which: facet calibration FILE --image-size "
                                        "{} --to kalibr --out FOLDER chooses one",
                                        fmt::join(names, ", "), names.front()));
}

/// Maps from one stream's frame to the other's, directly or through others.
std::optional<Se3> find_transform(const Listing& listing, const std::string& from, const std::string& to) {
    std::map<std::string, Se3> known{{from, Se3{}}};
    for (bool grows = true; grows && !known.contains(to);) {
        grows = false;
        for (const ListedTransform& t : listing.transforms) {
            const bool forth = known.contains(t.from) && !known.contains(t.to);
            const bool back = known.contains(t.to) && !known.contains(t.from);
            if (!forth && !back) {
                continue;
            }
            using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
            const Eigen::Matrix3d R = nearest_rotation(Eigen::Map<const RowMajor>(t.rotation.data()), t.blame);
            const Se3 step{Eigen::Quaterniond(R).normalized(), {t.translation[0], t.translation[1], t.translation[2]}};
            known[forth ? t.to : t.from] = forth ? step * known[t.from] : step.inverse() * known[t.to];
            grows = true;
        }
    }
    const auto found = known.find(to);
    return found == known.end() ? std::nullopt : std::optional(found->second);
}

Se3 mount_of(const Listing& listing, const std::string& stream, const std::string& path) {
    for (const char* imu : {"Gyro", "Accel"}) {
        if (const std::optional<Se3> T_B_C = find_transform(listing, stream, imu)) {
            return *T_B_C;
        }
    }
    throw InputError(
        fmt::format("{}: has no extrinsic from \"{}\" to \"Gyro\": the listing is of a camera without an "
                    "IMU, or its IMU was not found",
                    path, stream));
}

bool is_listing(const std::string& text) {
    return std::ranges::any_of(
        std::initializer_list<const char*>{"Stream Profiles supported by", "Intrinsic of \"", "Extrinsic from \""},
        [&](const char* mark) { return text.find(mark) != std::string::npos; });
}

}  // namespace

bool is_realsense_listing(const std::string& path) {
    try {
        return is_listing(read_whole_text(path));
    } catch (const InputError&) {
        return false;
    }
}

void read_realsense(const std::string& path, const ImageExtent& images, Calibration& calibration) {
    const Listing listing = ListingReader(path, read_whole_text(path)).read();
    if (listing.lenses.empty()) {
        throw InputError(path +
                         ": is what rs-enumerate-devices prints, without its calibration: rs-enumerate-devices -c > "
                         "FILE writes it");
    }
    std::string left = "Color";
    std::string right;
    for (const char* kind : {"Fisheye", "Infrared"}) {
        if (has_stream(listing, std::string(kind) + " 1")) {
            left = std::string(kind) + " 1";
            right = has_stream(listing, std::string(kind) + " 2") ? std::string(kind) + " 2" : "";
        }
    }
    if (!has_stream(listing, left)) {
        throw InputError(path + ": has the intrinsics of none of \"Infrared 1\", \"Fisheye 1\" and \"Color\"");
    }
    const ListedLens& lens = choose_lens(listing, left, images);
    const CameraModel camera = listed_camera(lens);
    const Se3 T_B_C0 = mount_of(listing, left, path);
    calibration.rig = StereoRig::monocular(camera, T_B_C0);
    if (!right.empty()) {
        const ListedLens& other = choose_lens(listing, right, images.width > 0 ? images : lens.size);
        calibration.rig = {
            .left = camera, .right = listed_camera(other), .T_B_C0 = T_B_C0, .T_B_C1 = mount_of(listing, right, path)};
        check_baseline(calibration.rig, other.blame);
    }
    if (listing.devices > 1) {
        calibration.remarks.push_back(path + ": lists several cameras, of which the first one is used");
    }
    if (listing.corrects_imu) {
        calibration.remarks.push_back(
            path + ": motion intrinsics are not used: librealsense corrects the readings with them by default");
    }
}

}  // namespace facet
