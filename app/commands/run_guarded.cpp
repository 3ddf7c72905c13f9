// SPDX-License-Identifier: BSD-2-Clause
#include "app/commands/run_guarded.h"

#include <fmt/core.h>

#include <cstdio>
#include <exception>

#include "app/support/console.h"
#include "app/support/input_error.h"

namespace facet {

void print_error(const char* message) { print_err("facet: error: {}\n", printable(message)); }

int run_guarded(const std::function<int()>& body) {
    try {
        return body();
    } catch (const InputError& e) {
        print_error(e.what());
        return kExitBadInput;
    } catch (const std::exception& e) {
        print_error(e.what());
        return kExitFailed;
    }
}

}  // namespace facet
