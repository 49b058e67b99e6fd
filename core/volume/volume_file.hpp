#pragma once
#include "core/volume/foam_file.hpp"
#include "core/volume/volume_mesh.hpp"

#include <filesystem>

/// Files of volume meshes: reads and replaces their points; everything else stays, byte for byte.
namespace strake {

enum class VolumeFormat {
    open_foam,  ///< a folder polyMesh, or its file `points`
    su2,        ///< .su2 with elements of three dimensions
    vtu         ///< VTK's XML file of an unstructured grid
};

/// Position and format of the points in a VTU file.
struct VtuPlace {
    std::size_t begin = 0, end = 0;  ///< the element `DataArray`
    std::size_t raw = 0;             ///< offset of the first number, if replaceable in place; else 0
    std::string offset;
    bool is_text = false, is_swapped = false, is_compressed = false;
    std::size_t header_bytes = 4;
};

struct VolumeFile {
    VolumeFormat format = VolumeFormat::vtu;
    VolumeMesh mesh;  ///< of a file `points` without the files of cells beside it: no cells
    std::string bytes, name;
    std::filesystem::path source;  ///< the file that holds the points
    std::filesystem::path folder;  ///< OpenFOAM: polyMesh; empty for a file `points` on its own

    foam::ListPlace list;                                     ///< OpenFOAM
    std::vector<std::pair<std::size_t, std::size_t>> places;  ///< SU2: of each point's coordinates in `bytes`
    VtuPlace array;                                           ///< VTU
};

/// Whether the name (for .su2 also the content) is that of a volume mesh.
bool is_volume(const std::filesystem::path& path);

/// A polyMesh folder (or the folder of a case with constant/polyMesh in it), its file `points`, also packed by gzip;
/// .su2; .vtu as text, base64 or appended, compressed by zlib or not.
/// @throws InputError `FILE: byte N: what` or `FILE:LINE: what`.
VolumeFile read_volume(const std::filesystem::path& path);

/// The same file with other points (P x 3). Single precision becomes double, except in OpenFOAM's files, whose header
/// fixes the precision.
std::string with_points(const VolumeFile& file, const Points& points);

/// Writes that. OpenFOAM: a folder gets `points` and copies of the other files of the mesh; a path that ends in
/// `points` only that file. @throws InvalidInput when kind or extension differ from the input's, or the input would be
/// overwritten; OutputError.
void write_volume(const std::filesystem::path& out, const VolumeFile& file, const Points& points);
/// Checks the name alone; throws like `write_volume`.
void check_volume_output(const std::filesystem::path& out, const std::filesystem::path& in);

namespace volume_formats {
/// The single formats; internal.
VolumeFile read_poly_mesh(const std::filesystem::path& path);
VolumeFile read_su2(std::string bytes, const std::string& name);
VolumeFile read_vtu(std::string bytes, const std::string& name);
std::string vtu_with_points(const VolumeFile& file, const Points& points);
/// @throws InputError when a face or cell names a missing point.
void check_corners(const VolumeMesh& mesh, const std::string& name);
}  // namespace volume_formats

}  // namespace strake
