#pragma once
#include "core/fields/function_sum.hpp"

#include <Eigen/QR>

/// Values of many functions at the vertices of a surface, while the motions of displacement fields are chosen. Internal
/// to core/fields.
namespace strake {

/// The functions at the vertices, columns in the order of `powers`, times the cut-off. All of them are needed only
/// while motions are chosen, and are gigabytes of millions of vertices: some rows at a time.
struct FunctionValues {
    LocalFunctions functions;
    const Points& x;
    const std::vector<Powers>& powers;
    const Eigen::VectorXd& cut;

    /// Those of the vertices from `first` on.
    void fill(Eigen::Index first, Eigen::Ref<Eigen::MatrixXd> values) {
        for (Eigen::Index v = 0; v < values.rows(); ++v) {
            functions.set(x.row(first + v));
            for (std::size_t f = 0; f < powers.size(); ++f)
                values(v, static_cast<Eigen::Index>(f)) = cut[first + v] * functions.value(powers[f]);
        }
    }
};

/// Of the values times the roots of the vertices' areas, which are nowhere else.
class ValuesQR : public Eigen::HouseholderQR<Eigen::MatrixXd> {
public:
    ValuesQR(FunctionValues values, const Eigen::VectorXd& areas)
        : HouseholderQR(values.x.rows(), static_cast<Eigen::Index>(values.powers.size())) {
        values.fill(0, m_qr);
        const Eigen::VectorXd roots = areas.cwiseSqrt();
        for (Eigen::Index f = 0; f < m_qr.cols(); ++f) m_qr.col(f).array() *= roots.array();
        computeInPlace();
    }
    Eigen::MatrixXd triangle() const {
        return m_qr.topRows(std::min(m_qr.rows(), m_qr.cols())).triangularView<Eigen::Upper>();
    }
};

constexpr Eigen::Index vertices_at_once = 256;  ///< of products of many columns: they stay in the cache

/// The largest displacements of the vertices by many motions, from blocks of vertices.
class LargestMotions {
public:
    explicit LargestMotions(const std::vector<Coefficients>& motions)
        : squares_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(motions.size()))) {
        for (std::size_t first = 0; first < motions.size(); first += motions_at_once) {
            const std::size_t n = std::min(motions_at_once, motions.size() - first);
            Eigen::MatrixXd factors(motions[first].rows(), 3 * static_cast<Eigen::Index>(n));
            Eigen::Index used = 0;  // early motions have few functions, which come first
            for (std::size_t b = 0; b < n; ++b) {
                factors.middleCols(3 * static_cast<Eigen::Index>(b), 3) = motions[first + b];
                const std::vector<std::size_t> own = used_functions(motions[first + b]);
                if (!own.empty()) used = std::max(used, static_cast<Eigen::Index>(own.back()) + 1);
            }
            factors_.push_back(factors.topRows(used));
        }
    }
    void add(const Eigen::MatrixXd& values) {
        Eigen::Index motion = 0;
        for (const Eigen::MatrixXd& factors : factors_) {
            moved_.noalias() = values.leftCols(factors.rows()) * factors;
            for (Eigen::Index b = 0; b < factors.cols(); b += 3, ++motion)
                squares_[motion] =
                    std::max(squares_[motion], moved_.middleCols(b, 3).rowwise().squaredNorm().maxCoeff());
        }
    }
    Eigen::VectorXd result() const { return squares_.cwiseSqrt(); }

private:
    static constexpr std::size_t motions_at_once = 16;
    std::vector<Eigen::MatrixXd> factors_;
    Eigen::VectorXd squares_;
    Eigen::MatrixXd moved_;
};

}  // namespace strake
