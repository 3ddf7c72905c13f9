// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/trigger_gpio/gpio_line.h"

#include <cerrno>
#include <cstring>

#include "drivers/trigger_gpio/chardev_line.h"
#include "drivers/trigger_gpio/libgpiod_line.h"

namespace facet {

std::unique_ptr<GpioLine> make_gpio_line(GpioBackend backend, KernelIo& io) {
    if (backend == GpioBackend::kChardev || (backend == GpioBackend::kAuto && !LibgpiodLine::kNumbersEdges)) {
        return std::make_unique<ChardevLine>(io);
    }
    return std::make_unique<LibgpiodLine>();
}

std::string describe(const GpioLineName& name) {
    return name.chip + " line " + (name.offset >= 0 ? std::to_string(name.offset) : "'" + name.name + "'");
}

Status gpio_problem(const std::string& label, const char* what, int result, std::string& problem) {
    problem = label + ": " + what + ": " + std::strerror(-result);
    return result == -ENOENT || result == -ENODEV || result == -ENXIO ? Status::kNotFound : Status::kIo;
}

Status gpio_refusal(const std::string& label, int result, std::string& problem) {
    return gpio_problem(label, result == -EBUSY ? "in use by another program" : "refused", result, problem);
}

}  // namespace facet
