// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/state_keeper.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

#include "app/support/input_error.h"
#include "app/support/text_file.h"
#include "platform/base/hash64.h"

namespace facet {
namespace {

constexpr const char* kForm = "facet_state_1";

/// Any change of the calibration changes it.
std::string fingerprint(const Calibration& calibration) {
    const StereoRig& rig = calibration.rig;
    std::string text = fmt::format("{}", rig.has_right);
    for (const CameraModel& camera : {rig.left, rig.right}) {
        const CameraIntrinsics& k = camera.intrinsics();
        text += fmt::format(" {} {} {} {} {} {} {}", k.width, k.height, k.fx, k.fy, k.cx, k.cy,
                            static_cast<int>(k.distortion));
        for (const auto& coefficients : {k.coeffs, k.more}) {
            text += fmt::format(" {}", fmt::join(coefficients, " "));
        }
    }
    for (const Se3& T : {rig.T_B_C0, rig.T_B_C1}) {
        text += fmt::format(" {} {} {} {} {} {} {}", T.q.w(), T.q.x(), T.q.y(), T.q.z(), T.p.x(), T.p.y(), T.p.z());
    }
    for (const Eigen::Matrix3d& M :
         {calibration.imu_model.M_a(), calibration.imu_model.M_w(), calibration.imu_model.M_g()}) {
        text += fmt::format(" {}", fmt::join(M.data(), M.data() + M.size(), " "));
    }
    return fmt::format("{:016x}", fnv1a(text));
}

template <class Vector>
std::string row(const char* name, const Vector& values) {
    std::string text = name;
    for (int i = 0; i < values.size(); ++i) {
        text += fmt::format(" {}", values(i));
    }
    return text + "\n";
}

/// Reads what row() has written. @return whether it was there
template <class Vector>
bool read_row(std::istream& in, const char* name, Vector&& values) {
    std::string word;
    in >> word;
    for (int i = 0; i < values.size(); ++i) {
        in >> values(i);
    }
    return !in.fail() && word == name;
}

/// What stands before the state.
struct Header {
    std::string boot;
    std::string calibration;
    Timestamp stamp;
};

/// @return whether it was there
bool read_header(std::istream& in, Header& out) {
    std::string form;
    std::string boot;
    std::string rig;
    std::string stamp_ns;
    in >> form >> boot >> out.boot >> rig >> out.calibration >> stamp_ns >> out.stamp.ns;
    return !in.fail() && form == kForm && boot == "boot" && rig == "rig" && stamp_ns == "stamp_ns";
}

bool read_state(std::istream& in, KeptState& out) {
    RigCalibration::Tangent correction;
    NavState& s = out.state;
    const bool is_whole = read_row(in, "q_xyzw", s.q_W_B.coeffs()) && read_row(in, "p", s.p_W_B) &&
                          read_row(in, "v", s.v_W_B) && read_row(in, "bias_gyro", s.bias.gyro) &&
                          read_row(in, "bias_accel", s.bias.accel) && read_row(in, "sigma", out.sigma) &&
                          read_row(in, "calibration", correction) &&
                          read_row(in, "calibration_sigma", out.calibration.sigma);
    std::string word;
    out.calibration.correction = RigCalibration{}.box_plus(correction);
    return is_whole && in >> word && word == "end";
}

}  // namespace

StateKeeper::StateKeeper(const std::string& folder, const Calibration& calibration, std::string boot)
    : path_(folder.empty() ? "" : folder + "/last_state"),
      calibration_(fingerprint(calibration)),
      boot_(std::move(boot)) {}

std::optional<StateKeeper::Found> StateKeeper::load(Timestamp now, std::string& refusal) const {
    refusal.clear();
    std::ifstream in(path_);
    if (path_.empty() || !in) {
        return std::nullopt;
    }
    Found found;
    Header header;
    if (!read_header(in, header) || !read_state(in, found.state)) {
        refusal = path_ + ": not a whole state";
    } else if (header.boot != boot_) {
        refusal = path_ + ": of another boot";
    } else if (header.calibration != calibration_) {
        refusal = path_ + ": of another calibration";
    } else if (header.stamp > now || now.ns / 2 - header.stamp.ns / 2 > static_cast<std::int64_t>(kOldest_s * 0.5e9)) {
        refusal = fmt::format("{}: not of the last {:g} s", path_, kOldest_s);
    } else {
        found.elapsed_s = (now - header.stamp).seconds();
        return found;
    }
    return std::nullopt;
}

bool StateKeeper::is_in_flight() const {
    std::ifstream in(path_);
    Header header;
    return !path_.empty() && read_header(in, header) && header.boot == boot_;
}

std::string StateKeeper::keep(const KeptState& state, Timestamp now) {
    if (path_.empty()) {
        return {};
    }
    const RigCalibration::Tangent correction = RigCalibration{}.box_minus_to(state.calibration.correction);
    try {
        make_folder(path_.substr(0, path_.rfind('/')));
        TextFile file(path_);
        file.print("{}\nboot {}\nrig {}\nstamp_ns {}\n", kForm, boot_, calibration_, now.ns);
        file.write(row("q_xyzw", state.state.q_W_B.coeffs()) + row("p", state.state.p_W_B) +
                   row("v", state.state.v_W_B) + row("bias_gyro", state.state.bias.gyro) +
                   row("bias_accel", state.state.bias.accel) + row("sigma", state.sigma) +
                   row("calibration", correction) + row("calibration_sigma", state.calibration.sigma) + "end\n");
        file.close();
    } catch (const InputError& e) {
        path_.clear();
        return e.what();
    }
    return {};
}

void StateKeeper::forget() const {
    std::error_code ignored;  // there may be none
    std::filesystem::remove(path_, ignored);
}

std::string boot_id() {
    std::ifstream in("/proc/sys/kernel/random/boot_id");
    std::string id;
    in >> id;
    return id;
}

}  // namespace facet
