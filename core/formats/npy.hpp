#pragma once
#include "core/mesh/mesh.hpp"

#include <stdexcept>
#include <string>
#include <string_view>

/// NumPy's .npy files of vectors (format versions 1 to 3, as NumPy's documentation of `numpy.lib.format` says).
namespace strake {

/// A wrong array: the text names the place (byte, row and column) and what is expected.
struct NpyError : std::runtime_error {
    using runtime_error::runtime_error;
};

/// An array of shape (n, 3) of 4- or 8-byte floats, in C or Fortran order and either byte order. Numbers need not be
/// finite. @throws NpyError.
Points parse_npy(std::string_view bytes);

/// Version 1.0, little-endian doubles in C order.
std::string npy_bytes(const Points& points);

}  // namespace strake
