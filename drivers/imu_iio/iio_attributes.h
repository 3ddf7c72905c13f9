// SPDX-License-Identifier: BSD-2-Clause
// Attributes of the kernel's devices: small text files, by paths that need no heap.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "platform/base/status.h"
#include "platform/port/kernel_io.h"

namespace facet {

/// A text of bounded length that ends with a zero. What does not fit is cut off, and remembered. Reentrant. No heap.
template <std::size_t Capacity>
class ShortText {
public:
    ShortText() = default;
    explicit ShortText(std::string_view text) { append(text); }

    void append(std::string_view text) {
        is_cut_ = is_cut_ || text.size() > Capacity - size_;
        const std::size_t taken = text.copy(chars_.data() + size_, Capacity - size_);
        size_ += taken;
        chars_[size_] = '\0';
    }
    const char* c_str() const { return chars_.data(); }
    std::string_view view() const { return {chars_.data(), size_}; }
    bool is_cut() const { return is_cut_; }

private:
    std::array<char, Capacity + 1> chars_{};
    std::size_t size_ = 0;
    bool is_cut_ = false;
};

/// Longest path: a root of a test's own, the device, its folder and the attribute.
inline constexpr std::size_t kMaxIioPath = 255;

/// A path; one that was cut off cannot be opened.
class IioPath {
public:
    IioPath() = default;
    explicit IioPath(std::string_view root) : text_(root) {}

    /// The same path, continued by a slash and a name.
    IioPath operator/(std::string_view name) const;
    const char* c_str() const { return text_.is_cut() ? "" : text_.c_str(); }
    std::string_view view() const { return text_.view(); }

private:
    ShortText<kMaxIioPath> text_;
};

/// Content of an attribute up to a zero, without white space at its end; the longest are lists of sampling frequencies.
using IioText = ShortText<1023>;

/// @return 0, or -errno with `text` untouched. Reentrant. No heap.
int read_attribute(KernelIo& io, const IioPath& path, IioText& text);
/// @return 0 or -errno; -EINVAL is how drivers refuse a value. Reentrant. No heap.
int write_attribute(KernelIo& io, const IioPath& path, std::string_view text);
/// The same of a number. @return -EINVAL if it is not a number
int read_number(KernelIo& io, const IioPath& path, double& number);
int read_number(KernelIo& io, const IioPath& path, int& number);

/// Reads a number from the front of a text, after spaces, and takes it off. @return whether there was one, and finite
bool take_number(std::string_view& text, double& number);

/// A number as text, without exponent. Reentrant. No heap.
class NumberText {
public:
    explicit NumberText(int number) : NumberText(static_cast<double>(number)) {}
    explicit NumberText(double number);
    std::string_view view() const { return {chars_.data(), size_}; }

private:
    std::array<char, 32> chars_{};
    std::size_t size_ = 0;
};

/// Names in a folder, in the kernel's order. Thread-bound. No heap.
class IioFolder {
public:
    /// Opens; `error()` tells whether that worked.
    IioFolder(KernelIo& io, const IioPath& path);
    ~IioFolder();
    IioFolder(const IioFolder&) = delete;
    IioFolder& operator=(const IioFolder&) = delete;

    /// 0 or -errno, of opening or of the last next().
    int error() const { return fd_ < 0 ? fd_ : error_; }
    /// @param name  valid until the next call
    /// @return false at the end, or if the folder cannot be read
    bool next(std::string_view& name);

private:
    KernelIo& io_;
    int fd_;
    int error_ = 0;
    alignas(8) std::array<char, 2048> entries_{};
    std::size_t filled_ = 0;
    std::size_t at_ = 0;
};

}  // namespace facet
