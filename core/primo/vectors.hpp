#pragma once
#include <Eigen/Core>

/// The long vectors of an iteration: loops on several threads (core/parallel.hpp), the same bits for any number of
/// them.
namespace strake {

using ConstColumn = Eigen::Ref<const Eigen::VectorXd>;
using Column = Eigen::Ref<Eigen::VectorXd>;

double dot(const ConstColumn& a, const ConstColumn& b);
double largest_entry(const ConstColumn& a);  ///< max |a_i|
/// y += factor x
void add_multiple(Column y, double factor, const ConstColumn& x);
/// p = z + factor p
void scale_and_add(Column p, double factor, const ConstColumn& z);

}  // namespace strake
