// SPDX-License-Identifier: BSD-2-Clause
// Image files with their stamps, out of a list or a folder.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace facet {

struct StampedFile {
    std::int64_t stamp_ns = 0;
    std::string path;
};

/// What a list says: of one camera, or of two that have a column each.
struct ImageList {
    std::vector<StampedFile> left;
    std::vector<StampedFile> right;  ///< empty: the list is of one camera
};

/// Reads one of these:
///  - a table with a column of stamps and one of file names, or two (left and right by their headers, else in this
///    order; a column of depth images is left out), in any order, such as TUM's rgb.txt and EuRoC's data.csv;
///  - names without stamps, if the names themselves are numbers: "1403636579763555584.png";
///  - a folder of images with such names, or of any names in their order if `stamps` has as many rows.
/// Names are below the list's folder, or below data/ there. The unit of the stamps is that of unit_of_stamps.
/// @param stamps  a table with a column of stamps; empty: none
/// Throws InputError naming file, line and what is missing.
ImageList read_image_list(const std::string& path, const std::string& stamps);

/// All stamps of a table (PlainTable) in ns: of the column that is called so, else the first number that does not
/// merely count the rows. Throws InputError.
std::vector<std::int64_t> read_stamps(const std::string& path);

bool is_text_file(const std::string& path);

/// Whether a file is text whose first row has the name of a file.
bool is_image_list(const std::string& path);

/// By its first bytes.
bool is_image_file(const std::string& path);

}  // namespace facet
