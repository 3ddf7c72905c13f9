// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/reset_count.h"

#include <fstream>

#include "app/support/input_error.h"
#include "app/support/text_file.h"

namespace facet {

ResetCount::ResetCount(const std::string& folder) : path_(folder.empty() ? "" : folder + "/reset_counter") {
    int last = 0;
    if (!path_.empty() && std::ifstream(path_) >> last) {
        is_restart_ = true;
        first_ = static_cast<std::uint8_t>((last + 1) & 0xFF);
    }
}

std::string ResetCount::keep(std::uint8_t counter) {
    if (path_.empty() || (is_kept_ && counter == kept_)) {
        return {};
    }
    try {
        make_folder(path_.substr(0, path_.rfind('/')));
        TextFile file(path_);
        file.print("{}\n", counter);
        file.close();
    } catch (const InputError& e) {
        path_.clear();
        return e.what();
    }
    is_kept_ = true;
    kept_ = counter;
    return {};
}

}  // namespace facet
