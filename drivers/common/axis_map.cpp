// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/common/axis_map.h"

#include <Eigen/LU>

namespace facet {

Status AxisMap::parse(std::string_view text) {
    Eigen::Matrix3d R = Eigen::Matrix3d::Zero();
    int row = 0;
    double sign = 1.0;
    bool signed_already = false;
    for (const char c : text) {
        if (c == ' ' || c == ',') {
            if (signed_already) {
                return Status::kInvalidArgument;
            }
        } else if ((c == '-' || c == '+') && !signed_already) {
            sign = c == '-' ? -1.0 : 1.0;
            signed_already = true;
        } else if (c >= 'x' && c <= 'z' && row < 3) {
            R(row++, c - 'x') = sign;
            sign = 1.0;
            signed_already = false;
        } else {
            return Status::kInvalidArgument;
        }
    }
    // A repeated axis has determinant 0, a mirror -1.
    if (row != 3 || signed_already || R.determinant() < 0.5) {
        return Status::kInvalidArgument;
    }
    R_B_S_ = R;
    return Status::kOk;
}

}  // namespace facet
