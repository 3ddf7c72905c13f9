// SPDX-License-Identifier: BSD-2-Clause
#include "app/output/residual_log.h"

#include "app/support/text_file.h"

namespace facet {

std::array<NamedResiduals, 4> named_residuals(const VisionResiduals& residuals) {
    return {{{"left_u", &residuals.left_u},
             {"left_v", &residuals.left_v},
             {"right_u", &residuals.right_u},
             {"right_v", &residuals.right_v}}};
}

void write_residuals(const VisionResiduals& residuals, const std::string& folder) {
    TextFile file(folder + "/residuals.csv");
    const auto columns = named_residuals(residuals);
    file.print("bin_px");
    for (const NamedResiduals& column : columns) {
        file.print(",{}", column.name);
    }
    for (int bin = 0; bin < ResidualHistogram::kBins; ++bin) {
        file.print("\n{:.2f}", ResidualHistogram::centre_px(bin));
        for (const NamedResiduals& column : columns) {
            file.print(",{}", column.histogram->count(bin));
        }
    }
    file.print("\n");
    file.close();

    TextFile by_angle(folder + "/residuals_by_angle.csv");
    by_angle.print("angle_deg,left_count,left_rms_px,right_count,right_rms_px\n");
    const ResidualsByAngle& left = residuals.left_by_angle;
    const ResidualsByAngle& right = residuals.right_by_angle;
    for (int bin = 0; bin < ResidualsByAngle::kBins; ++bin) {
        by_angle.print("{:.1f},{},{:.4f},{},{:.4f}\n", ResidualsByAngle::kBinDeg * (bin + 0.5), left.count(bin),
                       left.rms_px(bin), right.count(bin), right.rms_px(bin));
    }
    by_angle.close();
}

}  // namespace facet
