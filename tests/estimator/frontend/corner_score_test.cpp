// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/corner_score.h"

#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>

#include "tests/estimator/frontend/synthetic.h"

namespace facet::corner_score_test {
namespace {

/// The definition, pixel by pixel.
double score_of(const ImageView& image, int u, int v) {
    Eigen::Matrix2d m = Eigen::Matrix2d::Zero();
    for (int y = v - 2; y <= v + 2; ++y) {
        for (int x = u - 2; x <= u + 2; ++x) {
            Eigen::Vector2d g = Eigen::Vector2d::Zero();
            for (const int k : {-1, 0, 1}) {
                const double weight = k == 0 ? 2.0 : 1.0;
                g.x() += weight * (image.at(x + 1, y + k) - image.at(x - 1, y + k));
                g.y() += weight * (image.at(x + k, y + 1) - image.at(x + k, y - 1));
            }
            g /= 20.0 * 255.0;
            m += g * g.transpose();
        }
    }
    return Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(m).eigenvalues()[0];
}

}  // namespace

TEST_CASE("corner score is the least eigenvalue of the gradient matrix", "[frontend]") {
    const auto [width, height] = GENERATE(std::pair{64, 48}, std::pair{71, 37});
    CornerScore score;
    score.configure(width, height);
    for (const unsigned seed : {3U, 4U}) {  // nothing of the first image is left in the second one's scores
        const synthetic::Image image = synthetic::warp(synthetic::Texture(7.0, 30.0, seed), width, height, {0.0, 0.0});
        score.compute(image.view());
        float best = 0.0F;
        for (int v = 0; v < height; ++v) {
            for (int u = 0; u < width; ++u) {
                const float found = score.row(v)[u];
                best = std::max(best, found);
                const bool inside = u >= CornerScore::kReach && v >= CornerScore::kReach &&
                                    u < width - CornerScore::kReach && v < height - CornerScore::kReach;
                const double expected = inside ? score_of(image.view(), u, v) : 0.0;
                if (!(std::abs(found - expected) < 1e-9 + 1e-4 * expected)) {
                    CAPTURE(seed, u, v, found, expected);
                    FAIL();
                }
            }
        }
        CHECK(best > 0.0F);
        CHECK(score.best() == best);
    }
}

}  // namespace facet::corner_score_test
