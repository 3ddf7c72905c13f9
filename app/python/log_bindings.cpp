// SPDX-License-Identifier: BSD-2-Clause
#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <memory>
#include <mutex>
#include <utility>
#include <variant>

#include "app/lab/convert/opened_log.h"
#include "app/lab/replay/log_options.h"
#include "app/lab/replay/range_log.h"
#include "app/lab/replay/replay.h"
#include "app/python/bindings.h"
#include "app/python/flight.h"
#include "app/support/input_error.h"

namespace facet::python {
namespace {

/// One image, owned.
struct OwnedImage {
    std::vector<std::uint8_t> pixels;
    int width = 0;
    int height = 0;

    void take(const ImageView& view) {
        width = view.empty() ? 0 : view.width;
        height = view.empty() ? 0 : view.height;
        pixels.clear();
        for (int v = 0; v < height; ++v) {
            pixels.insert(pixels.end(), view.row(v), view.row(v) + width);
        }
    }
};

/// A frame whose images outlast the reader's next step. Shared with the arrays that show them.
struct LogFrame {
    Timestamp stamp;
    std::shared_ptr<OwnedImage> left = std::make_shared<OwnedImage>();
    std::shared_ptr<OwnedImage> right = std::make_shared<OwnedImage>();
};

/// A log from its begin to its end. Thread-safe.
class Log {
public:
    using Sample = std::variant<ImuSample, RangeSample, LogFrame>;

    Log(const std::string& path, const std::string& calibration, const std::string& imu_calibration, double start_s,
        std::optional<double> duration_s)
        : opened_(path, [this](const std::string& line) { warnings_.push_back(line); }) {
        constexpr double kMost_s = 1e9;
        if (!(start_s >= 0.0 && start_s <= kMost_s) || (duration_s && !(*duration_s > 0.0 && *duration_s <= kMost_s))) {
            throw InputError("start_s must not be negative, duration_s must be positive, and both at most 1e9");
        }
        const Calibration known = calibration.empty() ? load_calibration(opened_.root(), "", imu_calibration)
                                                      : read_calibration(calibration, imu_calibration);
        AslOptions options = log_options_of(known);
        options.files = opened_.files();
        options.imu_tail = kRetry;
        options.start = Duration::from_seconds(start_s);
        if (duration_s) {
            options.length = Duration::from_seconds(*duration_s);
        }
        std::string error;
        if (!ok(log_.open(
                path, options, [this](const AslWarning& w) { warnings_.push_back(w.text()); }, error))) {
            throw InputError(error);
        }
        ranges_ = RangeLog(path, opened_.files());
    }

    /// The next sample; nothing at the end.
    std::optional<Sample> next() {
        const std::lock_guard lock(mutex_);
        if (!frame_) {
            ImuSample sample;
            StereoFrame frame;
            switch (log_.next(sample, frame)) {
                case AslDataset::Event::kImu: return sample;
                case AslDataset::Event::kEnd: return std::nullopt;
                case AslDataset::Event::kFrame: break;
            }
            frame_.emplace();
            frame_->stamp = frame.stamp;
            frame_->left->take(frame.left);
            frame_->right->take(frame.right);
        }
        if (const RangeSample* const reading = ranges_.next_before(frame_->stamp)) {
            return *reading;
        }
        return std::exchange(frame_, std::nullopt);
    }
    std::size_t frame_count() const { return log_.frame_count(); }
    std::vector<std::string> warnings() {
        const std::lock_guard lock(mutex_);
        return warnings_;
    }

private:
    std::mutex mutex_;
    std::vector<std::string> warnings_;
    OpenedLog opened_;
    AslDataset log_;
    RangeLog ranges_;
    std::optional<LogFrame> frame_;  ///< readings that were given before it come first
};

/// Shows an image without a copy; None if there is none.
py::object show(const std::shared_ptr<OwnedImage>& image) {
    if (image->pixels.empty()) {
        return py::none();
    }
    auto* const owner = new std::shared_ptr<OwnedImage>(image);
    const py::capsule keep(owner, [](void* pointer) { delete static_cast<std::shared_ptr<OwnedImage>*>(pointer); });
    return py::array_t<std::uint8_t>({image->height, image->width}, image->pixels.data(), keep);
}

Log::Sample next_of(Log& log) {
    std::optional<Log::Sample> sample;
    {
        const py::gil_scoped_release released;
        sample = log.next();
    }
    if (!sample) {
        throw py::stop_iteration();
    }
    return std::move(*sample);
}

}  // namespace

void add_log(py::module_& module) {
    py::class_<ImuSample>(
        module, "ImuSample",
        "An inertial sample of a log: stamp_ns, angular rate (rad/s) and specific force (m/s^2) in B.")
        .def_property_readonly("stamp_ns", [](const ImuSample& s) { return s.stamp.ns; })
        .def_property_readonly("rate", [](const ImuSample& s) { return s.w_B; })
        .def_property_readonly("force", [](const ImuSample& s) { return s.a_B; });
    py::class_<RangeSample>(
        module, "RangeSample",
        "A reading of a log's range finder: stamp_ns, and where the beam met the ground, point (m), "
        "in B.")
        .def_property_readonly("stamp_ns", [](const RangeSample& s) { return s.stamp.ns; })
        .def_property_readonly("point", [](const RangeSample& s) { return s.p_B; });
    py::class_<LogFrame>(module, "StereoFrame",
                         "A frame of a log: stamp_ns and grey images (rows x columns of uint8), None if missing.")
        .def_property_readonly("stamp_ns", [](const LogFrame& f) { return f.stamp.ns; })
        .def_property_readonly("left", [](const LogFrame& f) { return show(f.left); })
        .def_property_readonly("right", [](const LogFrame& f) { return show(f.right); });
    py::class_<Log>(module, "Log",
                    "Reads a log, a folder in the format of EuRoC or its MCAP file, once: an iterator of ImuSample, "
                    "RangeSample and StereoFrame in order of time, each frame after the first inertial sample at or "
                    "behind it and after the readings of a range finder that it may use. Stamps are of the inertial "
                    "sensor's clock by the calibration, the log's own unless another one is named. warnings: what was "
                    "skipped so far, with file and line.")
        .def(py::init<const std::string&, const std::string&, const std::string&, double, std::optional<double>>(),
             py::arg("path"), py::kw_only(), py::arg("calibration") = "", py::arg("imu_calibration") = "",
             py::arg("start_s") = 0.0, py::arg("duration_s") = py::none())
        .def("__iter__", [](py::object self) { return self; })
        .def("__next__", &next_of)
        .def_property_readonly("frame_count", &Log::frame_count)
        .def_property_readonly("warnings", &Log::warnings);
}

}  // namespace facet::python
