// SPDX-License-Identifier: BSD-2-Clause
// A mesh's file that is there as a whole or not at all.
#pragma once

#include <string>

#include "app/support/ply_writer.h"

namespace facet {

/// write_ply() into a file that grows beside its name, as TextFile does, and then replaces what has that name. Throws
/// InputError naming the path if it cannot be written; what has the name then stays as it was. Reentrant. Heap.
void replace_ply(const std::string& path, const std::string& comment, const PlyMesh& mesh);

}  // namespace facet
