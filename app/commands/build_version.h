// SPDX-License-Identifier: BSD-2-Clause
// Which program this is: for facet --version and facet info.
#pragma once

#include <string>

namespace facet {

/// Twelve digits of the commit, with "+changes" if the tree differed from it; "unknown" without git. Reentrant.
const char* build_commit();

/// Version, commit, compiler, target and flags, a line each, aligned. No newline at the end. Reentrant.
std::string build_version();

}  // namespace facet
