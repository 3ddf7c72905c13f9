// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/common/serial_line.h"

#include <asm/ioctls.h>
#include <asm/termbits.h>
#include <fcntl.h>
#include <linux/serial.h>

#include <cerrno>
#include <cstring>

namespace facet {

Status open_serial_line(KernelIo& io, const std::string& device, int baud, int& fd, std::string& problem) {
    const int opened = io.open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK);
    if (opened < 0) {
        problem = device + ": cannot be opened: " + std::strerror(-opened);
        return opened == -ENOENT || opened == -ENODEV || opened == -ENXIO ? Status::kNotFound : Status::kIo;
    }
    // termios2 accepts any baud rate as a number. Raw mode: bytes pass unchanged, and a read does not wait.
    termios2 line{};
    int result = io.ioctl(opened, TCGETS2, &line);
    if (result >= 0) {
        line.c_iflag = IGNBRK | IGNPAR;
        line.c_oflag = 0;
        line.c_lflag = 0;
        line.c_cflag = static_cast<tcflag_t>(CS8 | CREAD | CLOCAL | BOTHER);
        line.c_ispeed = line.c_ospeed = static_cast<speed_t>(baud);
        line.c_cc[VMIN] = 1;
        line.c_cc[VTIME] = 0;
        result = io.ioctl(opened, TCSETS2, &line);
    }
    if (result < 0) {
        (void)io.close(opened);
        problem = device + ": " + (result == -ENOTTY ? std::string("not a serial line") : std::strerror(-result));
        return result == -ENOTTY ? Status::kInvalidArgument : Status::kIo;
    }
    serial_struct adapter{};
    if (io.ioctl(opened, TIOCGSERIAL, &adapter) >= 0) {
        adapter.flags |= ASYNC_LOW_LATENCY;
        (void)io.ioctl(opened, TIOCSSERIAL, &adapter);
    }
    fd = opened;
    return Status::kOk;
}

}  // namespace facet
