// SPDX-License-Identifier: BSD-2-Clause
// The one exception of the program's edge: the user's input cannot be used.
#pragma once

#include <stdexcept>
#include <string>

namespace facet {

/// Bad usage or input. what() is one line that names file, line or field; commands print it and exit with 2.
class InputError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

}  // namespace facet
