// SPDX-License-Identifier: BSD-2-Clause
// Reports the beginning and the end of a scope to a stage observer.
#pragma once

#include "estimator/values/stage.h"

namespace facet {

/// Reports one stage for the lifetime of the object; does nothing without an observer.
class StageScope {
public:
    StageScope(StageObserver* observer, Stage stage) : observer_(observer), stage_(stage) {
        if (observer_ != nullptr) {
            observer_->begin(stage_);
        }
    }
    ~StageScope() {
        if (observer_ != nullptr) {
            observer_->end(stage_);
        }
    }
    StageScope(const StageScope&) = delete;
    StageScope& operator=(const StageScope&) = delete;

private:
    StageObserver* observer_;
    Stage stage_;
};

}  // namespace facet
