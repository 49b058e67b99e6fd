#include "core/formats/vtp_reader.hpp"

#include "core/error.hpp"
#include "core/formats/formats.hpp"
#include "core/formats/vtp.hpp"
#include "core/mesh/temp_folder.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <zlib.h>
#include <algorithm>
#include <cstring>

/// VTP as VTK writes it: every encoding of the same two triangles.
namespace strake {
namespace {

const std::vector<double> coordinates{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0.5};
const std::vector<std::int64_t> corners{0, 1, 2, 0, 2, 3}, ends{3, 6};
const std::vector<float> gradient{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};

template <class T>
std::string bytes_in(const std::vector<T>& values, bool swap = false) {
    std::string bytes;
    for (const T value : values) {
        char raw[sizeof(T)];
        std::memcpy(raw, &value, sizeof raw);
        if (swap) std::reverse(raw, raw + sizeof raw);
        bytes.append(raw, sizeof raw);
    }
    return bytes;
}

std::string base64(const std::string& bytes) {
    const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        unsigned group = 0;
        for (std::size_t k = 0; k < 3; ++k)
            group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
        for (int shift = 18; shift >= 0; shift -= 6) out += digits[group >> shift & 63];
    }
    for (std::size_t k = 0; k < (3 - bytes.size() % 3) % 3; ++k) out[out.size() - 1 - k] = '=';
    return out;
}

/// One way to write arrays.
struct Way {
    bool is_text = false, is_appended = false, is_base64 = true, is_compressed = false, is_big = false, is_wide = true;
};

class Writer {
public:
    explicit Writer(const Way& way) : way_(way) {}
    template <class T>
    std::string array(const std::string& name, const char* type, int components, const std::vector<T>& values) {
        std::string tag =
            text("<DataArray type=\"", type, "\" Name=\"", name, "\" NumberOfComponents=\"", components, "\" format=\"",
                 way_.is_text       ? "ascii"
                 : way_.is_appended ? "appended"
                                    : "binary",
                 "\"");
        if (way_.is_text) {
            tag += ">\n";
            for (const T value : values) tag += text(" ", value);
            return tag + "\n</DataArray>\n";
        }
        const std::string encoded = encode(bytes_in(values, way_.is_big));
        if (!way_.is_appended) return tag + ">\n  " + encoded + "\n</DataArray>\n";
        const std::size_t offset = data_.size();
        data_ += encoded;
        return tag + text(" offset=\"", offset, "\"/>\n");
    }
    std::string file() {
        std::string out =
            text("<?xml version='1.0'?>\n<!-- made -->\n<VTKFile type=\"PolyData\" byte_order=\"",
                 way_.is_big ? "BigEndian" : "LittleEndian", "\"", way_.is_wide ? " header_type=\"UInt64\"" : "",
                 way_.is_compressed ? " compressor=\"vtkZLibDataCompressor\"" : "",
                 ">\n<PolyData><Piece "
                 "NumberOfPoints=\"4\" NumberOfPolys=\"2\">\n<PointData>\n");
        out += array("dDrag", "Float32", 3, gradient);
        out += "<DataArray type=\"String\" Name=\"words\" format=\"ascii\">1 2</DataArray>\n</PointData>\n<Points>";
        out += array("Points", "Float64", 3, coordinates) + "</Points>\n<Polys>\n";
        out += array("connectivity", "Int64", 1, corners) + array("offsets", "Int64", 1, ends);
        out += "</Polys>\n</Piece></PolyData>\n";
        if (way_.is_appended)
            out += text("<AppendedData encoding=\"", way_.is_base64 ? "base64" : "raw", "\">\n_") + data_ +
                   "\n</AppendedData>\n";
        return out + "</VTKFile>\n";
    }

private:
    std::string lengths(const std::vector<std::uint64_t>& values) const {
        if (way_.is_wide) return bytes_in(values, way_.is_big);
        return bytes_in(std::vector<std::uint32_t>(values.begin(), values.end()), way_.is_big);
    }
    std::string coded(const std::string& bytes) const {
        return way_.is_base64 || !way_.is_appended ? base64(bytes) : bytes;
    }
    std::string encode(const std::string& bytes) const {
        if (!way_.is_compressed) return coded(lengths({bytes.size()}) + bytes);
        const std::size_t block = 40;  // several blocks, the last one shorter
        std::vector<std::uint64_t> head{(bytes.size() + block - 1) / block, block, bytes.size() % block};
        std::string packed;
        for (std::size_t at = 0; at < bytes.size(); at += block) {
            const std::string part = bytes.substr(at, block);
            uLongf length = compressBound(part.size());
            std::string out(length, '\0');
            compress(reinterpret_cast<Bytef*>(out.data()), &length, reinterpret_cast<const Bytef*>(part.data()),
                     part.size());
            packed += out.substr(0, length);
            head.push_back(length);
        }
        return coded(lengths(head)) + coded(packed);
    }
    Way way_;
    std::string data_;
};

std::vector<Way> all_ways() {
    std::vector<Way> ways{{.is_text = true}};
    for (int bits = 0; bits < 32; ++bits) {
        const auto bit = [&](int k) { return (bits >> k & 1) != 0; };
        if (bit(0) || bit(1)) ways.push_back({false, bit(0), bit(1), bit(2), bit(3), bit(4)});
    }
    return ways;
}

TEST(VtpReader, ReadsEveryEncodingAlike) {
    for (const Way& way : all_ways()) {
        SCOPED_TRACE(text("appended ", way.is_appended, " base64 ", way.is_base64, " packed ", way.is_compressed,
                          " big ", way.is_big, " wide ", way.is_wide));
        const VtpFile file = parse_vtp(Writer(way).file(), "a.vtp");
        ASSERT_EQ(file.surface.mesh.num_vertices(), 4);
        EXPECT_EQ(file.surface.mesh.vertices, Eigen::Map<const Points>(coordinates.data(), 4, 3));
        EXPECT_EQ(file.surface.mesh.triangles.row(1), Eigen::RowVector3i(0, 2, 3));
        ASSERT_EQ(file.point_fields.size(), 1u);
        EXPECT_EQ(file.point_fields[0].name, "dDrag");
        EXPECT_EQ(file.point_fields[0].values(2, 1), 8);
    }
}

TEST(VtpReader, ReadsWhatWeWriteBitForBit) {
    const TempFolder folder;
    TriMesh mesh = icosphere(2);
    mesh.vertices *= 0.1;
    write_surface(folder / "s.vtp", mesh, SurfaceFormat::vtp);
    const SurfaceFile file = read_surface(folder / "s.vtp");
    EXPECT_EQ(file.format, SurfaceFormat::vtp);
    EXPECT_EQ(file.mesh.triangles, mesh.triangles);
    EXPECT_EQ(std::memcmp(file.mesh.vertices.data(), mesh.vertices.data(), 8 * mesh.vertices.size()), 0);
    const VtpFile fields = parse_vtp(vtp_bytes(mesh, {{"g & <h>", mesh.vertices}}), "s.vtp");
    EXPECT_EQ(fields.point_fields.at(0).name, "g & <h>");
}

TEST(VtpReader, StripsAndPolygonsBecomeTriangles) {
    std::string vtp = Writer({.is_text = true}).file();
    const auto put = [&](const std::string& what, const std::string& by) {
        vtp.replace(vtp.find(what), what.size(), by);
    };
    put(" 0 1 2 0 2 3\n", " 0 1 2 3\n");
    put(" 3 6\n", " 4\n");
    EXPECT_EQ(parse_vtp(vtp, "a").surface.mesh.num_triangles(), 2);
    put("<Polys>", "<Strips>");
    put("</Polys>", "</Strips>");
    const Triangles strip = parse_vtp(vtp, "a").surface.mesh.triangles;
    ASSERT_EQ(strip.rows(), 2);
    EXPECT_EQ(strip.row(1), Eigen::RowVector3i(1, 3, 2)) << "every other triangle of a strip is turned";
}

std::string refusal(const std::string& bytes) {
    try {
        parse_vtp(bytes, "a.vtp");
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

TEST(VtpReader, SaysWhatIsWrong) {
    const std::string good = Writer({.is_text = true}).file();
    const auto with = [&](const std::string& what, const std::string& by) {
        std::string bytes = good;
        return refusal(bytes.replace(bytes.find(what), what.size(), by));
    };
    EXPECT_EQ(refusal(good), "");
    EXPECT_NE(refusal("").find("no VTK file"), std::string::npos);
    EXPECT_NE(with("PolyData", "UnstructuredGrid").find("must be PolyData"), std::string::npos);
    EXPECT_NE(with(" 0 2 3\n", " 0 2 4\n").find("has point 4, limits 0 and 3"), std::string::npos);
    EXPECT_NE(with(" 3 6\n", " 3 7\n").find("ends at corner 7"), std::string::npos);
    EXPECT_NE(with(" 0 0 0 1 ", " 0 0 nan 1 ").find("not finite"), std::string::npos);
    EXPECT_NE(with(" 0 0 0 1 ", " 0 0 x 1 ").find("'x' is not a number"), std::string::npos);
    EXPECT_NE(with("<Piece", "<Piece/><Piece").find("2 pieces"), std::string::npos);
}

TEST(VtpReader, NothingThatIsCutOffOrDamagedCrashes) {
    for (const Way& way : {Way{.is_appended = true, .is_compressed = true},
                           Way{.is_appended = true, .is_base64 = false}, Way{.is_compressed = true}}) {
        const std::string whole = Writer(way).file();
        for (std::size_t n = 0; n < whole.size(); n += 3) refusal(whole.substr(0, n));
        for (std::size_t at = 0; at < whole.size(); at += 2)
            for (const char damage : {'\0', '\xff', '<', '9'}) {
                std::string bytes = whole;
                bytes[at] = damage;
                refusal(bytes);
            }
    }
}

/// VTK writes the names of fields as they are.
TEST(VtpReader, AValueMayHoldTheEndOfATag) {
    std::string file = vtp_bytes(box_surface(), {{"Mach", Eigen::VectorXd::Ones(8).eval()}});
    file.replace(file.find("\"Mach\""), 6, "\"Mach > 1\"");
    const VtpFile read = parse_vtp(file, "f.vtp");
    ASSERT_EQ(read.point_fields.size(), 1u);
    EXPECT_EQ(read.point_fields[0].name, "Mach > 1");
    EXPECT_EQ(read.surface.mesh.num_triangles(), 12);
    file.replace(file.find("\"Mach > 1\""), 10, "\"Mach > 1 ");
    EXPECT_THROW(parse_vtp(file, "f.vtp"), InputError);
}

/// VTK 9 writes what it knows about the values behind them, older ones before.
TEST(VtpReader, NotesOnTheValuesMayStandOnBothSides) {
    const std::string key = "<InformationKey name=\"L2_NORM_RANGE\"><Value index=\"0\">0</Value></InformationKey>\n";
    const auto file = [&](const std::string& before, const std::string& behind) {
        const auto array = [&](const char* type, const char* name, int components, const char* values) {
            return text("<DataArray type=\"", type, "\" Name=\"", name, "\" NumberOfComponents=\"", components,
                        "\" format=\"ascii\">\n", before, values, "\n", behind, "</DataArray>\n");
        };
        return "<VTKFile type=\"PolyData\" version=\"1.0\" "
               "byte_order=\"LittleEndian\">\n<PolyData>\n<Piece>\n<Points>\n" +
               array("Float64", "Points", 3, "0 0 0 1 0 0 0 1 0") + "</Points>\n<Polys>\n" +
               array("Int64", "connectivity", 1, "0 1 2") + array("Int64", "offsets", 1, "3") +
               "</Polys>\n</Piece>\n</PolyData>\n</VTKFile>\n";
    };
    for (const std::string& xml : {file("", ""), file(key, ""), file("", key), file("", key + key)})
        EXPECT_EQ(formats::read_vtp(xml, "f.vtp").mesh.vertices,
                  (Points(3, 3) << 0, 0, 0, 1, 0, 0, 0, 1, 0).finished());
}

/// Parts by numbers alone, as other programs write them; of another length they are none.
TEST(VtpReader, PartsAreGroups) {
    std::vector<int> part(12, 4);
    part[3] = 7;
    const TriMesh mesh = formats::read_vtp(vtp_bytes(box_surface(), {}, {{"part", part}}), "f.vtp").mesh;
    ASSERT_EQ(mesh.group.size(), 12u);
    EXPECT_EQ(mesh.group_names[mesh.group[3]], "7");
    EXPECT_EQ(mesh.group_names[mesh.group[4]], "4");
    const Eigen::VectorXd reals = Eigen::VectorXd::Ones(12);
    EXPECT_TRUE(formats::read_vtp(vtp_bytes(box_surface(), {}, {{"part", reals}}), "f.vtp").mesh.group.empty());
}

}  // namespace
}  // namespace strake
