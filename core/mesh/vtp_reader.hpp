#pragma once
#include "core/mesh/io.hpp"

#include <Eigen/Core>
#include <string_view>

/// VTK's polygon files as others write them: XML with arrays as text, base64 or appended bytes, of either byte order,
/// plain or compressed by zlib.
namespace strake {

struct VtpField {
    std::string name;
    /// One row a point, one column a component; not necessarily finite.
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> values;
};

struct VtpFile {
    /// Points, and polygons and strips cut into triangles (maybe none); lines and single points are left out.
    SurfaceFile surface;
    std::vector<VtpField> point_fields;  ///< numeric ones
};

/// `name` of the file for messages. @throws InputError `NAME: what` for whatever is not a finite, indexed surface.
VtpFile parse_vtp(std::string_view bytes, const std::string& name);

}  // namespace strake
