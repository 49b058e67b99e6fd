#include "core/wrap/wide_product.hpp"

#include <gtest/gtest.h>

namespace strake {
namespace {

TEST(WideProduct, EqualsThePlainProductOfAnySize) {
    for (const int rows : {1, 3, 4, 511, 512, 1030})
        for (const int columns : {4, 5, 7, 18})
            for (const int of_b : {3, 6, 18}) {
                const Eigen::MatrixXd a = Eigen::MatrixXd::Random(rows, columns),
                                      b = Eigen::MatrixXd::Random(rows, of_b), expected = a.transpose() * b,
                                      found = wide_product(a, b);
                ASSERT_EQ(found.rows(), columns);
                ASSERT_EQ(found.cols(), of_b);
                EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 1e-13 * rows + 1e-15)
                    << rows << " x " << columns << ", " << of_b;
            }
}

}  // namespace
}  // namespace strake
