#pragma once
#include "core/fields/field_functions.hpp"
#include "core/fields/thin_products.hpp"

#include <Eigen/QR>

/// Values of many functions at the vertices of a surface, while the motions of displacement fields are chosen. Internal
/// to core/fields.
namespace strake {

/// Functions along the axes of the frame at one point; room for them is made once.
class LocalFunctions {
public:
    LocalFunctions(const FieldFrame& frame, AlongAxis along, const std::vector<Powers>& powers) : frame_(frame) {
        std::array<int, 3> last{0, 0, 0};
        for (const Powers& p : powers)
            for (int k = 0; k < 3; ++k) last[k] = std::max(last[k], p[k]);
        for (int k = 0; k < 3; ++k) along_.emplace_back(k == 0 ? along : AlongAxis::polynomials, 0, last[k]);
    }
    void set(const Eigen::Vector3d& x) {
        const Eigen::Vector3d at = frame_.local(x);
        for (int k = 0; k < 3; ++k) along_[k].set(at[k]);
    }
    double value(const Powers& p) const {
        return along_[0].value[p[0]] * along_[1].value[p[1]] * along_[2].value[p[2]];
    }
    /// By the local coordinate k, per length.
    double slope(const Powers& p, int k) const {
        double product = frame_.half[k] > 0 ? 1 / frame_.half[k] : 0;
        for (int i = 0; i < 3; ++i) product *= i == k ? along_[i].slope[p[i]] : along_[i].value[p[i]];
        return product;
    }

private:
    const FieldFrame& frame_;
    std::vector<FunctionsAlong> along_;
};

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

constexpr Eigen::Index rows_at_once = 256;  ///< of products of many columns: they stay in the cache

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
