#include "optimize/journal/packed_arrays.hpp"

#include <bit>
#include <cstdint>
#include <cstring>

namespace strake {
namespace {

static_assert(std::endian::native == std::endian::little, "journals hold numbers in little-endian order");

void put(std::string& bytes, std::int64_t value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); }

template <class Matrix>
std::string packed_matrices(const std::vector<Matrix>& all) {
    std::string bytes;
    put(bytes, static_cast<std::int64_t>(all.size()));
    for (const Matrix& m : all) {
        put(bytes, m.rows());
        bytes.append(reinterpret_cast<const char*>(m.data()), sizeof(double) * static_cast<std::size_t>(m.size()));
    }
    return bytes;
}

template <class Matrix>
std::vector<Matrix> unpacked_all(const std::string& bytes) {
    std::size_t at = 0;
    const auto integer = [&] {
        std::int64_t value = 0;
        if (at + sizeof value <= bytes.size()) std::memcpy(&value, bytes.data() + at, sizeof value);
        at += sizeof value;
        return value;
    };
    std::vector<Matrix> all(static_cast<std::size_t>(integer()));
    for (Matrix& m : all) {
        if constexpr (Matrix::ColsAtCompileTime == 1)
            m.resize(integer());
        else
            m.resize(integer(), Matrix::ColsAtCompileTime);
        const std::size_t length = sizeof(double) * static_cast<std::size_t>(m.size());
        std::memcpy(m.data(), bytes.data() + at, length);
        at += length;
    }
    return all;
}

}  // namespace

std::string packed_all(const std::vector<Points>& all) { return packed_matrices(all); }
std::string packed_all(const std::vector<Eigen::VectorXd>& all) { return packed_matrices(all); }
std::vector<Points> unpacked_gradients(const std::string& bytes) { return unpacked_all<Points>(bytes); }
std::vector<Eigen::VectorXd> unpacked_derivatives(const std::string& bytes) {
    return unpacked_all<Eigen::VectorXd>(bytes);
}

std::string packed(const std::vector<double>& values) {
    return {reinterpret_cast<const char*>(values.data()), sizeof(double) * values.size()};
}

std::vector<double> unpacked(const std::string& bytes) {
    std::vector<double> values(bytes.size() / sizeof(double));
    std::memcpy(values.data(), bytes.data(), values.size() * sizeof(double));
    return values;
}

std::string lines_of(const std::vector<std::string>& names) {
    std::string lines;
    for (const std::string& name : names) lines += name + "\n";
    return lines;
}

std::vector<std::string> names_in(const std::string& lines) {
    std::vector<std::string> names;
    for (std::size_t at = 0, end; (end = lines.find('\n', at)) != std::string::npos; at = end + 1)
        names.push_back(lines.substr(at, end - at));
    return names;
}

}  // namespace strake
