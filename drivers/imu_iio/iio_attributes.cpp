// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/imu_iio/iio_attributes.h"

#include <fcntl.h>

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace facet {
namespace {

/// Of a record of getdents64: inode and offset (8 bytes each), its length (2), a type (1), the name.
constexpr std::size_t kLengthAt = 16;
constexpr std::size_t kNameAt = 19;

}  // namespace

IioPath IioPath::operator/(std::string_view name) const {
    IioPath longer = *this;
    longer.text_.append("/");
    longer.text_.append(name);
    return longer;
}

int read_attribute(KernelIo& io, const IioPath& path, IioText& text) {
    const int fd = io.open(path.c_str(), O_RDONLY);
    if (fd < 0) {
        return fd;
    }
    std::array<char, 1023> content{};
    const std::int64_t size = io.read(fd, content.data(), content.size());
    (void)io.close(fd);
    if (size < 0) {
        return static_cast<int>(size);
    }
    // Of current_timestamp_clock the kernel gives the zero behind the text as well.
    std::string_view whole(content.data(), static_cast<std::size_t>(size));
    whole = whole.substr(0, whole.find('\0'));
    text = IioText(whole.substr(0, whole.find_last_not_of(" \n") + 1));
    return 0;
}

int write_attribute(KernelIo& io, const IioPath& path, std::string_view text) {
    const int fd = io.open(path.c_str(), O_WRONLY);
    if (fd < 0) {
        return fd;
    }
    const std::int64_t written = io.write(fd, text.data(), text.size());
    (void)io.close(fd);
    return written < 0 ? static_cast<int>(written) : 0;
}

bool take_number(std::string_view& text, double& number) {
    const std::size_t begin = text.find_first_not_of(' ');
    if (begin == std::string_view::npos) {
        return false;
    }
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data() + begin, text.data() + text.size(), value);
    if (error != std::errc{} || !std::isfinite(value)) {
        return false;
    }
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    number = value;
    return true;
}

NumberText::NumberText(double number) {
    const auto [end, error] =
        std::to_chars(chars_.data(), chars_.data() + chars_.size(), number, std::chars_format::fixed);
    size_ = error == std::errc{} ? static_cast<std::size_t>(end - chars_.data()) : 0;
}

int read_number(KernelIo& io, const IioPath& path, double& number) {
    IioText text;
    if (const int error = read_attribute(io, path, text); error != 0) {
        return error;
    }
    std::string_view rest = text.view();
    return take_number(rest, number) ? 0 : -EINVAL;
}

int read_number(KernelIo& io, const IioPath& path, int& number) {
    double value = 0.0;
    if (const int error = read_number(io, path, value); error != 0) {
        return error;
    }
    if (std::abs(value) > 1e9 || value != std::floor(value)) {
        return -EINVAL;
    }
    number = static_cast<int>(value);
    return 0;
}

IioFolder::IioFolder(KernelIo& io, const IioPath& path) : io_(io), fd_(io.open(path.c_str(), O_RDONLY | O_DIRECTORY)) {}

IioFolder::~IioFolder() {
    if (fd_ >= 0) {
        (void)io_.close(fd_);
    }
}

bool IioFolder::next(std::string_view& name) {
    if (fd_ < 0) {
        return false;
    }
    if (at_ >= filled_) {
        const std::int64_t size = io_.read_folder(fd_, entries_.data(), entries_.size());
        error_ = size < 0 ? static_cast<int>(size) : 0;
        at_ = 0;
        filled_ = size < 0 ? 0 : static_cast<std::size_t>(size);
    }
    if (at_ + kNameAt >= filled_) {
        return false;
    }
    std::uint16_t length = 0;
    std::memcpy(&length, entries_.data() + at_ + kLengthAt, sizeof length);
    if (length <= kNameAt || at_ + length > filled_) {
        filled_ = at_ = 0;
        error_ = -EIO;
        return false;
    }
    const char* const text = entries_.data() + at_ + kNameAt;
    name = {text, ::strnlen(text, length - kNameAt)};
    at_ += length;
    return true;
}

}  // namespace facet
