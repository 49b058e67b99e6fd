#pragma once
#include "core/mesh/mesh.hpp"

#include <string>
#include <vector>

/// Numbers as bytes, little-endian, exact: how the journal and the cache of answers keep them. Internal.
namespace strake {

/// Gradients and derivatives of an answer: their number, then rows and entries of each.
std::string packed_all(const std::vector<Points>& all);
std::string packed_all(const std::vector<Eigen::VectorXd>& all);
/// @pre `bytes` are what packed_all gave.
std::vector<Points> unpacked_gradients(const std::string& bytes);
std::vector<Eigen::VectorXd> unpacked_derivatives(const std::string& bytes);
std::string packed(const std::vector<double>& values);
std::vector<double> unpacked(const std::string& bytes);
/// Names, which hold no line feed.
std::string lines_of(const std::vector<std::string>& names);
std::vector<std::string> names_in(const std::string& lines);

}  // namespace strake
