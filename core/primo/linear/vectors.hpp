#pragma once
#include <Eigen/Core>

/// Operations on long vectors, parallel (core/parallel.hpp), with the same bits for any number of threads.
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
