// SPDX-License-Identifier: BSD-2-Clause
#include "app/output/ply_file.h"

#include <cstdio>

#include "app/support/input_error.h"
#include "app/support/text_file.h"

namespace facet {

void replace_ply(const std::string& path, const std::string& comment, const PlyMesh& mesh) {
    const std::string growing = path + TextFile::kPartEnding;
    if (!ok(write_ply(growing, comment, mesh)) || std::rename(growing.c_str(), path.c_str()) != 0) {
        throw InputError(path + ": cannot be written");
    }
}

}  // namespace facet
