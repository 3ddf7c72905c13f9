// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/common/mjpeg_decoder.h"

#include <jpeglib.h>
#include <cstdio>  // jpeglib.h needs it before it

#include <algorithm>
#include <csetjmp>
#include <string_view>

namespace facet {
namespace {

/// libjpeg-turbo works on rows of whole SIMD registers, two at a time.
constexpr std::size_t kRowMultiple = 64;
/// Rows of blocks, their context and the colour they are not converted to, some thirty rows of the image; and tables.
constexpr std::size_t kBytesPerColumn = 96;
constexpr std::size_t kBytesAtLeast = std::size_t{256} * 1024;
constexpr std::size_t kBytesForGood = std::size_t{128} * 1024;
constexpr std::size_t kMostBytesOfRow = std::size_t{1} << 20;

}  // namespace

/// Reached by the callbacks through client_data.
struct MjpegState {
    explicit MjpegState(std::size_t image_bytes) : image(image_bytes) {}

    jpeg_decompress_struct info{};
    jpeg_error_mgr errors{};
    std::jmp_buf jump{};
    JpegArena permanent{kBytesForGood};  ///< tables, and the parts that read markers
    JpegArena image;                     ///< of one image
    char message[JMSG_LENGTH_MAX] = {};
};

namespace {

MjpegState& state_of(j_common_ptr info) { return *static_cast<MjpegState*>(info->client_data); }

[[noreturn]] void leave(j_common_ptr info) {
    MjpegState& state = state_of(info);
    info->err->format_message(info, state.message);
    std::longjmp(state.jump, 1);
}

/// A warning says that data are damaged or missing, which libjpeg would replace by grey.
void refuse_warning(j_common_ptr info, int level) {
    if (level < 0) {
        leave(info);
    }
}

[[noreturn]] void leave_without_memory(j_common_ptr info) {
    constexpr char kWords[] = "needs more memory than a camera's JPEG";
    static_assert(sizeof kWords <= sizeof(MjpegState::message));
    MjpegState& state = state_of(info);
    std::copy_n(kWords, sizeof kWords, state.message);
    std::longjmp(state.jump, 1);
}

void* take_memory(j_common_ptr info, int pool, std::size_t size) {
    MjpegState& state = state_of(info);
    void* const at = (pool == JPOOL_PERMANENT ? state.permanent : state.image).take(size);
    if (at == nullptr) {
        leave_without_memory(info);
    }
    return at;
}

JSAMPARRAY take_rows(j_common_ptr info, int pool, JDIMENSION width, JDIMENSION rows) {
    if (width > kMostBytesOfRow || rows > kMostBytesOfRow) {
        leave_without_memory(info);
    }
    const std::size_t stride = (std::size_t{width} + kRowMultiple - 1) / kRowMultiple * kRowMultiple;
    auto* const list = static_cast<JSAMPARRAY>(take_memory(info, pool, rows * sizeof(JSAMPROW)));
    auto* const samples = static_cast<JSAMPROW>(take_memory(info, pool, stride * rows));
    for (JDIMENSION row = 0; row < rows; ++row) {
        list[row] = samples + row * stride;
    }
    return list;
}

/// For images that come in several scans, which are refused before anything asks for it.
JBLOCKARRAY take_blocks(j_common_ptr info, int /*pool*/, JDIMENSION /*width*/, JDIMENSION /*rows*/) {
    leave_without_memory(info);
}

void free_memory(j_common_ptr info, int pool) {
    if (pool == JPOOL_IMAGE) {
        state_of(info).image.clear();
    }
}

/// No object of the functions below may have a destructor: libjpeg jumps out of them.
bool create(MjpegState& state) {
    if (setjmp(state.jump) != 0) {
        return false;
    }
    state.info.err = jpeg_std_error(&state.errors);
    state.errors.error_exit = leave;
    state.errors.emit_message = refuse_warning;
    state.info.client_data = &state;
    jpeg_create_decompress(&state.info);
    state.info.mem->alloc_small = take_memory;
    state.info.mem->alloc_large = take_memory;
    state.info.mem->alloc_sarray = take_rows;
    state.info.mem->alloc_barray = take_blocks;
    state.info.mem->free_pool = free_memory;
    return true;
}

/// @return whether the image is one that a camera sends; the size is judged by who knows it
bool read_header(MjpegState& state, std::span<const std::uint8_t> bytes) {
    if (setjmp(state.jump) != 0) {
        return false;
    }
    jpeg_mem_src(&state.info, bytes.data(), bytes.size());
    jpeg_read_header(&state.info, TRUE);
    state.info.out_color_space = JCS_GRAYSCALE;
    return true;
}

bool read_rows(MjpegState& state, std::uint8_t* out) {
    if (setjmp(state.jump) != 0) {
        return false;
    }
    jpeg_start_decompress(&state.info);
    while (state.info.output_scanline < state.info.output_height) {
        JSAMPROW row = out + std::size_t{state.info.output_scanline} * state.info.output_width;
        jpeg_read_scanlines(&state.info, &row, 1);
    }
    jpeg_finish_decompress(&state.info);
    return true;
}

}  // namespace

void* JpegArena::take(std::size_t size) {
    const auto begin = reinterpret_cast<std::uintptr_t>(bytes_.get());
    const std::size_t skipped = (kAlignment - begin % kAlignment) % kAlignment;
    const std::size_t rounded = (size + kAlignment - 1) / kAlignment * kAlignment;
    if (rounded < size || rounded > size_ - used_) {
        return nullptr;
    }
    std::byte* const at = bytes_.get() + skipped + used_;
    used_ += rounded;
    return at;
}

MjpegDecoder::MjpegDecoder(int width, int height)
    : width_(width),
      height_(height),
      state_(std::make_unique<MjpegState>(kBytesAtLeast + kBytesPerColumn * static_cast<std::size_t>(width))) {
    if (!create(*state_)) {
        state_.reset();
    }
}

MjpegDecoder::~MjpegDecoder() {
    if (state_) {
        jpeg_destroy_decompress(&state_->info);
    }
}

/// @return what is wrong; nullptr if nothing is
const char* MjpegDecoder::read(std::span<const std::uint8_t> bytes, std::span<std::uint8_t> out) {
    if (!read_header(*state_, bytes)) {
        return state_->message;
    }
    jpeg_decompress_struct& info = state_->info;
    if (info.image_width != static_cast<JDIMENSION>(width_) || info.image_height != static_cast<JDIMENSION>(height_)) {
        return "an image of another size";
    }
    if (info.progressive_mode != FALSE || info.arith_code != FALSE || jpeg_has_multiple_scans(&info) != FALSE) {
        return "no baseline JPEG of one scan";
    }
    if (out.size() < std::size_t{info.image_width} * info.image_height) {
        return "no room for the image";
    }
    return read_rows(*state_, out.data()) ? nullptr : state_->message;
}

Status MjpegDecoder::decode(std::span<const std::uint8_t> bytes, std::span<std::uint8_t> out) {
    if (!state_) {
        problem_ = {"libjpeg cannot be used"};
        return Status::kCorrupt;
    }
    const char* const fault = read(bytes, out);
    if (fault == nullptr) {
        return Status::kOk;
    }
    const std::string_view words(fault);
    problem_.fill('\0');
    std::copy_n(words.begin(), std::min(words.size(), problem_.size() - 1), problem_.begin());
    jpeg_abort_decompress(&state_->info);
    return Status::kCorrupt;
}

}  // namespace facet
