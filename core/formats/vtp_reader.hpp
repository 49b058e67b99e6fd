#pragma once
#include "core/formats/io.hpp"

#include <Eigen/Core>
#include <string_view>

/// VTK's polygon files from other programs: XML with arrays as text, base64 or appended bytes, of either byte order,
/// plain or compressed by zlib.
namespace strake {

struct VtpField {
    std::string name;
    /// One row per point, one column per component; may be non-finite.
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> values;
};

struct VtpFile {
    /// Points, and polygons and strips cut into triangles (may be none); lines and single points are ignored.
    SurfaceFile surface;
    std::vector<VtpField> point_fields;  ///< numeric ones
};

/// `name` of the file for messages. @throws InputError `NAME: what` for anything but a finite, indexed surface.
VtpFile parse_vtp(std::string_view bytes, const std::string& name);

}  // namespace strake
