#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/formats/npy.hpp"
#include "core/formats/vtp.hpp"
#include "core/text/file.hpp"
#include "surfaces.hpp"

#include <zlib.h>

#include <algorithm>
#include <cstdio>
#include <cstring>

/// Seeds of the fuzzers: what the writers write, and variants that only others do.
namespace strake {
namespace {

namespace fs = std::filesystem;

/// Words big-endian: 4 or 8 bytes each.
template <class T>
std::string big_endian(std::initializer_list<T> values) {
    std::string bytes;
    for (T value : values) {
        char raw[sizeof(T)];
        std::memcpy(raw, &value, sizeof(T));
        std::reverse(raw, raw + sizeof(T));
        bytes.append(raw, sizeof(T));
    }
    return bytes;
}
template <class T>
std::string raw(std::initializer_list<T> values) {
    std::string bytes;
    for (T value : values) bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
    return bytes;
}
std::string record(const std::string& payload) {
    const std::string marker = raw({static_cast<int>(payload.size())});
    return marker + payload + marker;
}
std::string gzipped(const std::string& plain) {
    z_stream stream{};
    if (deflateInit2(&stream, 9, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY) != Z_OK) throw std::bad_alloc();
    std::string packed(plain.size() + 1000, '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(plain.data()));
    stream.avail_in = static_cast<uInt>(plain.size());
    stream.next_out = reinterpret_cast<Bytef*>(packed.data());
    stream.avail_out = static_cast<uInt>(packed.size());
    deflate(&stream, Z_FINISH);
    packed.resize(stream.total_out);
    deflateEnd(&stream);
    return packed;
}

class Seeds {
public:
    explicit Seeds(fs::path folder) : folder_(std::move(folder)) {}
    void add(const std::string& fuzzer, const std::string& bytes) {
        fs::create_directories(folder_ / fuzzer);
        write_atomically(folder_ / fuzzer / text("seed-", count_++), bytes);
    }

private:
    fs::path folder_;
    int count_ = 0;
};

void written_by_us(Seeds& seeds) {
    TriMesh box = box_surface(), sheet = strip(1, 1, 1, 1);
    box.group_names = {"1", "left wing"};
    for (int t = 0; t < box.num_triangles(); ++t) box.group.push_back(t % 2);
    for (const TriMesh& mesh : {box, sheet})
        for (const char* name :
             {"stl", "stl-ascii", "obj", "ply", "ply-ascii", "off", "tri", "vtk", "vtp", "su2", "msh", "nastran"}) {
            const SurfaceFormat format = format_named(name);
            const std::string bytes = surface_bytes(mesh, format, name);
            seeds.add(extension_of(format).substr(1), bytes);
            if (format == SurfaceFormat::stl_binary || format == SurfaceFormat::stl_ascii)
                seeds.add("gz", gzipped(bytes));
        }
    const std::string fields = vtp_bytes(box, {{"p", Eigen::VectorXd(Eigen::VectorXd::Ones(box.num_vertices()))}});
    seeds.add("vtp", fields);
    seeds.add("vtp_fields", fields);
    seeds.add("npy", npy_bytes(box.vertices));
    seeds.add("repair", std::string("\x08\x01") + std::string(reinterpret_cast<const char*>(box.triangles.data()), 60));
    for (int start = 3; start < 250; start += 29) {
        std::string bytes;
        for (int i = 0; i < 90; ++i) bytes += static_cast<char>((start * (i + 1) * 37 + i * i) % 251);
        seeds.add("repair", bytes);
    }
}

void text_variants(Seeds& seeds) {
    seeds.add("obj",
              "mtllib a.mtl\r\no a\r\ng left right\r\nv 0 0 0 1\nv 1 0 0\nv 0 1 0\nv 1 1 \\\n0\nvt 0 0\nvn 0 0 1\n"
              "usemtl x\ns off\nf 1/1/1 2//1 3/1\nf -3 -1 -2 # back\nl 1 2\n");
    seeds.add("off", "COFF BINARY\n3 1 0\n");
    seeds.add("off", "# c\nOFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3 255 0 0\n");
    seeds.add("ply",
              "ply\nformat ascii 1.0\ncomment x\nobj_info y\nelement vertex 4\nproperty double x\nproperty float y\n"
              "property int z\nproperty uchar red\nelement face 1\nproperty list uchar uint vertex_index\n"
              "property ushort group\nelement edge 1\nproperty int a\nend_header\n0 0 0 1\n1 0 0 2\n1 1 0 3\n"
              "0 1 0 4\n4 0 1 2 3 7\n5\n");
    seeds.add("ply",
              "ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
              "float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n" +
                  big_endian({0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F}) + "\x03" + big_endian({0, 1, 2}));
    seeds.add("stl",
              "solid a b\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
              "endfacet\nendsolid a b\nSOLID\n FACET NORMAL 0 0 1\n OUTER LOOP\nVERTEX 1e0 0 0\nVERTEX 1 1 0\n"
              "VERTEX 0 1 0\nENDLOOP\nENDFACET\nENDSOLID\n");
    seeds.add("tri", "3 1\n0 0 0\n1 0 0\n0 1 0\n1 2 3\n7\n");
    seeds.add("tri", "3 1 6\n0 0 0\n1 0 0\n0 1 0\n1 2 3\n7\n1 2 3 4 5 6\n1 2 3 4 5 6\n1 2 3 4 5 6\n");
    seeds.add("tri", record(raw({3, 1})) + record(raw({0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F})) +
                         record(raw({1, 2, 3})) + record(raw({2})));
    seeds.add("tri", record(raw({3, 1})) + record(raw({0., 0., 0., 1., 0., 0., 0., 1., 0.})) + record(raw({1, 2, 3})));
    seeds.add("vtk",
              "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n0 0 0 1 0 0 1 1 0 0 1 0\n"
              "POLYGONS 1 5\n4 0 1 2 3\nCELL_DATA 1\nSCALARS a int 1\nLOOKUP_TABLE default\n3\nPOINT_DATA 4\n"
              "VECTORS v float\n0 0 0 0 0 0 0 0 0 0 0 0\n");
    seeds.add("vtk",
              "# vtk DataFile Version 5.1\nx\nASCII\nDATASET POLYDATA\nPOINTS 3 double\n0 0 0 1 0 0 0 1 0\n"
              "POLYGONS 2 3\nOFFSETS vtktypeint64\n0 3\nCONNECTIVITY vtktypeint64\n0 1 2\n");
    seeds.add("vtk",
              "# vtk DataFile Version 2.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n0 0 0 1 0 0 1 1 0 "
              "0 1 0\nCELLS 2 9\n3 0 1 2\n4 0 1 2 3\nCELL_TYPES 2\n5\n9\n");
    const std::string vtp =
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" byte_order=\"LittleEndian\"><PolyData>"
        "<Piece NumberOfPoints=\"3\" NumberOfPolys=\"1\"><PointData><DataArray type=\"Float32\" "
        "Name=\"p\" format=\"ascii\">1 2 3</DataArray></PointData><Points><DataArray type=\"Float32\" "
        "NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0 0 1 0</DataArray></Points><Polys>"
        "<DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">0 1 2</DataArray><DataArray "
        "type=\"Int32\" Name=\"offsets\" format=\"ascii\">3</DataArray></Polys></Piece></PolyData>"
        "</VTKFile>\n";
    seeds.add("vtp", vtp);
    seeds.add("vtp_fields", vtp);
}

void mesher_variants(Seeds& seeds) {
    seeds.add("su2",
              "% c\nNDIME= 3\nNELEM= 1\n10 0 1 2 3 0\nNPOIN= 4\n0 0 0 0\n1 0 0 1\n0 1 0 2\n0 0 1 3\nNMARK= 2\n"
              "MARKER_TAG= wall\nMARKER_ELEMS= 2\n5 0 1 2\n5 0 1 3\nMARKER_TAG= far\nMARKER_ELEMS= 1\n9 0 1 2 3\n");
    seeds.add("msh",
              "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n2 4 \"upper side\"\n$EndPhysicalNames\n"
              "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n9 0 1 0\n$EndNodes\n$Elements\n3\n1 15 2 1 1 1\n"
              "2 3 2 4 11 1 2 3 9\n3 2 2 4 11 1 2 3\n$EndElements\n");
    seeds.add("msh",
              "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 1 0\n1 0 0 0 1 1 0 1 4 0\n$EndEntities\n$Nodes\n"
              "1 3 1 3\n2 1 0 3\n1\n2\n3\n0 0 0\n1 0 0\n0 1 0\n$EndNodes\n$Elements\n1 1 1 1\n2 1 2 1\n1 1 2 3\n"
              "$EndElements\n");
    const std::string nodes =
        raw({1}) + raw({0., 0., 0.}) + raw({2}) + raw({1., 0., 0.}) + raw({3}) + raw({0., 1., 0.});
    seeds.add("msh", "$MeshFormat\n2.2 1 8\n" + raw({1}) + "\n$EndMeshFormat\n$Nodes\n3\n" + nodes +
                         "\n$EndNodes\n$Elements\n1\n" + raw({2, 1, 2, 1, 4, 11, 1, 2, 3}) + "\n$EndElements\n");
    seeds.add("nas",
              "SOL 101\nCEND\nBEGIN BULK\nGRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.+0,0.\nCTRIA3,1,7,1,2,3\n"
              "CQUAD4,2,7,1,2,3,1\nENDDATA\n");
    seeds.add("nas",
              "GRID           1              0.      0.      0.\nGRID           2              1.      0.      0.\n"
              "GRID           3              0.    1.-3      0.\nCTRIA3         1       2       1       2       3\n");
    seeds.add("nas",
              "GRID*                  1                              0.              0.\n*                     0.\n"
              "GRID*                  2                              1.              0.\n*                     0.\n"
              "GRID*                  3                              0.              1.\n*                     0.\n"
              "CTRIA3         1       2       1       2       3\n");
}

void volumes(Seeds& seeds) {
    seeds.add(
        "su2_volume",
        "NDIME= 3\nNELEM= 2\n10 0 1 2 3 0\n13 0 1 2 3 4 5 1\nNPOIN= 6\n0 0 0 0\n1 0 0 1\n0 1 0 2\n0 0 1 3\n1 0 1 4\n"
        "0 1 1 5\nNMARK= 1\nMARKER_TAG= wall\nMARKER_ELEMS= 1\n5 0 1 2\n");
    const std::string begin =
        "<VTKFile type=\"UnstructuredGrid\" byte_order=\"LittleEndian\" "
        "header_type=\"UInt64\"><UnstructuredGrid><Piece>"
        "<Points><DataArray type=\"Float64\" Name=\"P\" NumberOfComponents=\"3\" ";
    const std::string cells =
        "</Points><Cells><DataArray type=\"Int32\" Name=\"connectivity\">0 1 2 3 0 1 2 3</DataArray><DataArray "
        "type=\"Int32\" Name=\"offsets\">4 8</DataArray><DataArray type=\"UInt8\" Name=\"types\">10 "
        "42</DataArray><DataArray "
        "type=\"Int32\" Name=\"faces\">4 3 0 1 2 3 0 1 3 3 1 2 3 3 0 2 3</DataArray><DataArray type=\"Int32\" "
        "Name=\"faceoffsets\">-1 17</DataArray></Cells></Piece></UnstructuredGrid>";
    seeds.add("vtu", begin + "format=\"ascii\">0 0 0 1 0 0 0 1 0 0 0 1</DataArray>" + cells + "</VTKFile>");
    seeds.add("vtu", begin + "format=\"appended\" offset=\"0\"/>" + cells + "<AppendedData encoding=\"raw\">_" +
                         raw<std::uint64_t>({96}) + raw({0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1.}) +
                         "</AppendedData></VTKFile>");
    const auto head = [](const char* format, const char* kind) {
        return text("FoamFile { version 2.0; format ", format, "; class ", kind,
                    "; arch \"LSB;label=32;scalar=64\"; }\n");
    };
    seeds.add("foam", head("ascii", "vectorField") + "2((0 0 0) (1 2e-3 -4))\n");
    seeds.add("foam", head("binary", "vectorField") + "1(" + raw({0., 1., 2.}) + ")");
    seeds.add("foam", head("ascii", "faceList") + "2(3(0 1 2) 4(0 1 2 3)) // end\n");
    seeds.add("foam", head("ascii", "labelList") + "/* c */ 5{0}");
    seeds.add("foam", head("binary", "labelList") + "2(" + raw({1, 2}) + ")");
}

/// Requests to the studio; the first byte says what the rest is (fuzz_studio.cpp).
void requests(Seeds& seeds) {
    const std::string head = " HTTP/1.1\r\nHost: $H\r\n";
    for (const char* path : {"", "api/state?from=0", "api/surface", "studio.js", "report", "../x", "api/felt/mode?j=1",
                             "api/felt/shape?of=1"})
        seeds.add("studio", text(std::string(1, '\0'), "GET /$T/", path, head, "\r\n"));
    seeds.add("studio",
              text(std::string(1, '\0'), "GET /x/", head, "Origin: http://evil.example\r\nCookie: a=b\r\n\r\n"));
    seeds.add("studio",
              text(std::string(1, '\0'), "POST /$T/api", head,
                   "Content-Type: application/json\r\nContent-Length: 20\r\n\r\n{\"do\":\"form\",\"text\":\"\"}"));
    seeds.add("studio", text(std::string(1, '\0'), "POST /$T/api", head,
                             "Transfer-Encoding: chunked\r\n\r\n2\r\n{}\r\n0\r\n\r\n"));
    const std::string yaml = "surface: {file: body.obj}\\nobjective: {maximize: area}\\n";
    const std::string with_text = "\",\"text\":\"" + yaml + "\"";
    for (const std::string& body : std::vector<std::string>{
             "open\",\"name\":\"case.yaml\"", "open\",\"name\":\"../secret.yaml\"", "attach\",\"name\":\"runs/a\"",
             "check" + with_text, "form" + with_text,
             "set" + with_text + ",\"values\":[[\"optimize.seed\",\"3\"],[\"objective\",\"\"]]",
             "choose" + with_text +
                 ",\"steps\":[{\"component\":0},{\"op\":\"-\",\"triangles\":[1]},{\"grow\":0.1},{\"invert\":true}]",
             "choose" + with_text +
                 ",\"steps\":[{\"plane\":{\"normal\":[0,0,1],\"at\":0.1,\"above\":true}},{\"op\":\"&\",\"box\":[[0,0,0]"
                 ",["
                 "1,1,1]]}]",
             "choose" + with_text + ",\"steps\":[{\"triangles\":[0]},{\"mirror\":{\"normal\":[0,1,0],\"offset\":0.5}}]",
             "choose" + with_text +
                 ",\"steps\":[{\"wing\":{\"of\":\"\",\"chord\":[0,1],\"span\":[0,1]}},{\"flood\":{\"point\":[0,0,0],"
                 "\"angle\":30}}]",
             "region" + with_text + ",\"name\":\"b\",\"fix\":true,\"steps\":[{\"triangles\":[0]}]", "feel" + with_text,
             "feel" + with_text + ",\"level\":1,\"x\":[0.1],\"slope\":true", "run\"", "save\""})
        seeds.add("studio", "\x01{\"do\":\"" + body + "}");
    for (const char* path :
         {"api/design?run=runs&evaluation=0", "api/designs", "api/state?from=99999999999", "api/felt_state"})
        seeds.add("studio", text("\x02", path));
    const std::string nothing(1, '\0');
    seeds.add("studio", "\x03s" + nothing + "new.yaml" + nothing + "surface: body.obj\n" + nothing + "0");
    seeds.add("studio", "\x03s" + nothing + "../new.yaml" + nothing + "x" + nothing + "0");
    seeds.add("studio",
              "\x03" + nothing + "b" + nothing + "surface: body.obj\n" + nothing + nothing + "[{\"triangles\":[0,2]}]");
}

/// The texts between R"( and )" of another file: the seeds of its own mutations.
void cases_of(const fs::path& source, Seeds& seeds) {
    const std::string code = read_bytes(source);
    for (std::size_t at = 0; (at = code.find("R\"(", at)) != code.npos;) {
        const std::size_t end = code.find(")\"", at + 3);
        if (end == code.npos) break;
        seeds.add("case", code.substr(at + 3, end - at - 3));
        at = end;
    }
}

}  // namespace
}  // namespace strake

int main(int argc, char** argv) {
    if (argc != 3) {
        std::fprintf(stderr, "usage: fuzz_seeds FOLDER CASE_FUZZ_TEST.cpp\n");
        return 2;
    }
    strake::Seeds seeds(argv[1]);
    strake::written_by_us(seeds);
    strake::text_variants(seeds);
    strake::mesher_variants(seeds);
    strake::volumes(seeds);
    strake::requests(seeds);
    strake::cases_of(argv[2], seeds);
}
