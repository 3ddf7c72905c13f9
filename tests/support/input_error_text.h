// SPDX-License-Identifier: BSD-2-Clause
// Catches an InputError for its message.
#pragma once

#include <string>

#include "app/support/input_error.h"

namespace facet::test {

/// Message of the InputError that `action` throws; "no error" if it throws none. Other exceptions pass.
template <class Action>
std::string input_error_text(const Action& action) {
    try {
        action();
    } catch (const InputError& e) {
        return e.what();
    }
    return "no error";
}

}  // namespace facet::test
