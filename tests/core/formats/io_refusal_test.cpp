#include "core/error.hpp"
#include "core/formats/formats.hpp"
#include "core/formats/io.hpp"
#include "core/mesh/temp_folder.hpp"
#include "core/text/file.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstring>

/// What is not a surface is refused with its place, whatever the bytes.
namespace strake {
namespace {

using Reader = SurfaceFile (*)(std::string_view, const std::string&);

struct Format {
    const char* name;
    Reader read;
    std::string sample;  ///< a tetrahedron
};

TriMesh tetrahedron() {
    TriMesh mesh;
    mesh.vertices.resize(4, 3);
    mesh.vertices << 0, 0, 0, 1.5, 0, 0, 0, 1.25, 0, 0, 0, -1e-3;
    mesh.triangles.resize(4, 3);
    mesh.triangles << 0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0;
    return mesh;
}

std::string record(const std::string& data) {
    const auto n = static_cast<std::uint32_t>(data.size());
    const std::string marker(reinterpret_cast<const char*>(&n), 4);
    return marker + data + marker;
}

template <class T>
std::string raw(const std::vector<T>& values) {
    return {reinterpret_cast<const char*>(values.data()), sizeof(T) * values.size()};
}

std::string tri_records() {
    const TriMesh mesh = tetrahedron();
    std::vector<int> corners(mesh.triangles.data(), mesh.triangles.data() + 12);
    for (int& c : corners) ++c;
    return record(raw<int>({4, 4})) + record({reinterpret_cast<const char*>(mesh.vertices.data()), 96}) +
           record(raw(corners)) + record(raw<int>({1, 1, 2, 2}));
}

std::vector<Format> samples() {
    const TriMesh mesh = tetrahedron();
    return {{"stl", formats::read_stl, formats::stl_binary(mesh, "")},
            {"stl-ascii", formats::read_stl, formats::stl_ascii(mesh)},
            {"obj", formats::read_obj, formats::obj(mesh)},
            {"ply-ascii", formats::read_ply, formats::ply(mesh, false)},
            {"ply", formats::read_ply, formats::ply(mesh, true)},
            {"off", formats::read_off, formats::off(mesh)},
            {"tri", formats::read_tri, formats::tri(mesh)},
            {"tri-binary", formats::read_tri, tri_records()},
            {"vtk", formats::read_vtk, formats::vtk(mesh)},
            {"su2", formats::read_su2, formats::su2(mesh)},
            {"msh", formats::read_gmsh, formats::gmsh(mesh)},
            {"nastran", formats::read_nastran, formats::nastran(mesh)}};
}

/// The reader's message, or "" when it accepts; anything but a sound surface or an InputError fails the test.
std::string refusal(Reader read, std::string_view bytes, SurfaceFile* accepted = nullptr) {
    try {
        const SurfaceFile surface = read(bytes, "f");
        const TriMesh& mesh = surface.mesh;
        EXPECT_TRUE(mesh.vertices.allFinite());
        EXPECT_GT(mesh.num_triangles(), 0);
        EXPECT_GE(mesh.triangles.minCoeff(), 0);
        EXPECT_LT(mesh.triangles.maxCoeff(), mesh.num_vertices());
        EXPECT_TRUE(mesh.group.empty() || mesh.group.size() == static_cast<std::size_t>(mesh.num_triangles()));
        if (accepted) *accepted = surface;
        return "";
    } catch (const InputError& e) {
        const std::string message = e.what();
        EXPECT_EQ(message.substr(0, 2), "f:");
        EXPECT_LT(message.size(), 500u);
        for (const char* jargon : {"std::", "basic_string", "bad_alloc", "stoi"})
            EXPECT_EQ(message.find(jargon), std::string::npos) << message;
        return message;
    }
}

TEST(SurfaceRefusal, TruncationAtEveryByte) {
    for (const Format& format : samples()) {
        ASSERT_EQ(refusal(format.read, format.sample), "") << format.name;
        for (std::size_t n = 0; n < format.sample.size(); ++n) {
            SurfaceFile accepted;
            if (!refusal(format.read, std::string_view(format.sample).substr(0, n), &accepted).empty()) continue;
            // A text may lack its last line end; OBJ announces no counts, so whole faces may be gone unnoticed.
            const bool only_line_end = n + 1 == format.sample.size() && format.sample.back() == '\n';
            // Component numbers are optional: a file that ends before their record is whole.
            const bool no_components =
                format.sample[3] == 0 && format.read == formats::read_tri && n + 24 == format.sample.size();
            // NASTRAN's cards announce no counts either; what follows VTK's cells is not looked at.
            const bool no_counts = format.read == formats::read_obj || format.read == formats::read_nastran;
            EXPECT_TRUE(only_line_end || no_components || no_counts) << format.name << " cut at byte " << n;
        }
    }
}

/// Deterministic noise.
struct Noise {
    std::uint64_t state;
    std::size_t below(std::size_t n) {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        return static_cast<std::size_t>((state >> 11) % n);
    }
};

std::string mutant(std::string s, Noise& noise) {
    static const std::vector<std::string> tokens = {"-1",
                                                    "0",
                                                    "4294967296",
                                                    "18446744073709551616",
                                                    "2147483647",
                                                    "-2147483648",
                                                    "nan",
                                                    "inf",
                                                    "1e400",
                                                    "1e-400",
                                                    "1,5",
                                                    "\n",
                                                    "\r",
                                                    " ",
                                                    "#",
                                                    "/",
                                                    "\\\n",
                                                    "//",
                                                    "list",
                                                    "element face 1\n",
                                                    std::string(1, '\0'),
                                                    "\xff\xff\xff\xff",
                                                    "f",
                                                    "v",
                                                    "endsolid",
                                                    "facet",
                                                    "1.0D5",
                                                    "property list uchar int vertex_indices\n"};
    const std::size_t edits = 1 + noise.below(4);
    for (std::size_t i = 0; i < edits && !s.empty(); ++i) {
        const std::size_t at = noise.below(s.size());
        switch (noise.below(6)) {
            case 0:
                s[at] = static_cast<char>(noise.below(256));
                break;
            case 1:
                s[at] = static_cast<char>(s[at] ^ (1 << noise.below(8)));
                break;
            case 2:
                s.erase(at, 1 + noise.below(12));
                break;
            case 3:
                s.insert(at, tokens[noise.below(tokens.size())]);
                break;
            case 4:
                s.replace(at, std::min<std::size_t>(4, s.size() - at), tokens[noise.below(tokens.size())]);
                break;
            default:
                s.insert(at, s.substr(noise.below(s.size()), noise.below(40)));
        }
    }
    return s;
}

TEST(SurfaceRefusal, MutantsNeverCrash) {
    Noise noise{0x9E3779B97F4A7C15ull};
    int refused = 0, mutants = 0;
    for (const Format& format : samples())
        for (int i = 0; i < 4000; ++i, ++mutants)
            refused += !refusal(format.read, mutant(format.sample, noise)).empty();
    EXPECT_GT(refused, mutants / 4);
    EXPECT_LT(refused, mutants);
}

/// A file, and what its refusal must say.
struct Broken {
    Reader read;
    std::string bytes, message;
};

std::string ply_head(const std::string& vertices, const std::string& faces) {
    return "ply\nformat ascii 1.0\nelement vertex " + vertices +
           "\nproperty double x\nproperty double y\nproperty double z\nelement face " + faces +
           "\nproperty list uchar int vertex_indices\nend_header\n";
}

TEST(SurfaceRefusal, NamesTheLineAndTheWord) {
    const std::string xyz = "0 0 0\n1 0 0\n0 1 0\n", v = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    const auto off = formats::read_off, obj = formats::read_obj, ply = formats::read_ply, tri = formats::read_tri,
               stl = formats::read_stl;
    for (const Broken& broken : std::vector<Broken>{
             {off, "OFF\n3 1 0\n0 0 0\n1,5 0 0\n0 1 0\n3 0 1 2\n", "f:4: expected a number"},
             {off, "OFF\n3 1 0\n0 0 0\n1.0.0 0 0\n0 1 0\n3 0 1 2\n", "got '1.0.0'"},
             {off, "OFF\n3 1 0\n0 0 0\n1e400 0 0\n0 1 0\n3 0 1 2\n", "outside the range of double"},
             {off, "OFF\n3 1 0\n0 0 0\nnan 0 0\n0 1 0\n3 0 1 2\n", "not a finite number"},
             {off, "OFF\n3 1 0\n0 0 0\n-inf 0 0\n0 1 0\n3 0 1 2\n", "not a finite number"},
             {off, "OFF\n3 1 0\n0 0 0\n0x10 0 0\n0 1 0\n3 0 1 2\n", "got '0x10'"},
             {off, "OFF\n3 1 0\n" + xyz + "3 0 1 3\n", "f:6: corner 2 of face 0 is vertex 3, limits 0 and 2"},
             {off, "OFF\n3 1 0\n" + xyz + "3 0 1 4294967298\n", "vertex 4294967298"},
             {off, "OFF\n3 1 0\n" + xyz + "3 0 1 18446744073709551618\n", "too large"},
             {off, "OFF\n3 1 0\n" + xyz + "2 0 1\n", "at least 3"},
             {off, "OFF\n3 2 0\n" + xyz + "3 0 1 2\n", "f:"},
             {off, "OFF\n3 1 0\n" + xyz + "3 0 1 2\n3 0 1 2\n", "f:7: expected the end of the file"},
             {off, "OFF\n2000000000 1 0\n" + xyz, "room for at most"},
             {off, "OFF\n-3 1 0\n" + xyz, "cannot be negative"},
             {off, "OFF BINARY\n", "binary form of OFF"},
             {off, "4OFF\n3 1 0\n", "three dimensions"},
             {obj, v + "f 1 2 4\n", "f:4: vertex number 4 of a face: the file has 3 vertices"},
             {obj, v + "f 1 2 0\n", "counts from 1"},
             {obj, v + "f 1 2 -4\n", "only 3 vertices precede"},
             {obj, v + "f 1 2 4294967299\n", "too large"},
             {obj, v + "f 1 2 /3\n", "f:4: expected a corner"},
             {obj, v + "f 1 2 3/1/1/1\n", "f:4: expected a corner"},
             {obj, v + "f 1 2\n", "at least 3 corners"},
             {obj, "v 0 0\n", "f:1: expected coordinate of a vertex, got the end"},
             {obj, v, "holds no triangles"},
             {obj, "hello\n", "f:1: expected an OBJ keyword"},
             {ply, ply_head("3", "1") + xyz + "3 0 1 7\n", "f:13: a corner of a face is vertex 7, limits 0 and 2"},
             {ply, ply_head("3", "1") + xyz + "3 0 1\n", "f:13: expected vertex_indices, got the end of the"},
             {ply, ply_head("3", "1") + "0 0 0 0\n" + xyz, "f:10: expected the end of the line, got '0'"},
             {ply, ply_head("99999999999", "1") + xyz, "at most 2147483647"},
             {ply, ply_head("99999999", "1") + xyz, "room for at most"},
             {ply, ply_head("3", "1") + xyz + "3.0 0 1 2\n", "expected a whole number"},
             {ply, "ply\nformat ascii 2.0\nend_header\n", "f:2: expected version 1.0, got '2.0'"},
             {ply, "ply\nformat ascii 1.0\nelement vertex 1\n", "no line 'end_header'"},
             {ply, "PLY\n", "begins with the line 'ply'"},
             {tri, "3 1\n" + xyz + "1 2 4\n", "corner 4 of a triangle, limits 1 and 3"},
             {tri, "3 1\n" + xyz + "0 1 2\n", "corner 0 of a triangle"},
             {tri, "3 1\n" + xyz + "1 2 3\n1\n1\n", "need 12 numbers, or 13 with component numbers; the file has 14"},
             {tri, "3000000000 1\n" + xyz, "at most 2147483647"},
             {stl, "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0\nvertex", "f:5: expected a number"},
             {stl, "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nendloop", "f:5: expected 'vertex'"},
             {stl, "solid\nendsolid\n", "holds no triangles"},
             {stl, "solid x\n", "got the end of the file"},
             {stl, std::string(84, 'x'), "f: byte 80: the header announces 2021161080 triangles"},
             {stl, "abc", "ends inside the header"},
         }) {
        const std::string message = refusal(broken.read, broken.bytes);
        EXPECT_NE(message.find(broken.message), std::string::npos) << "for:\n" << broken.bytes << "\ngot: " << message;
    }
}

TEST(SurfaceRefusal, BinaryValuesThatAreNotFinite) {
    const float inf = std::numeric_limits<float>::infinity();
    std::string stl = formats::stl_binary(tetrahedron(), "");
    std::memcpy(stl.data() + 84 + 50 + 12, &inf, 4);
    EXPECT_NE(refusal(formats::read_stl, stl).find("byte 146: corner 0 of triangle 1 is not finite"),
              std::string::npos);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    std::string ply = formats::ply(tetrahedron(), true);
    std::memcpy(ply.data() + ply.find("end_header\n") + 11 + 24 + 8, &nan, 8);
    EXPECT_NE(refusal(formats::read_ply, ply).find("(vertex 1): y is not finite"), std::string::npos);
}

TEST(SurfaceRefusal, WhatIsNotARegularFileDoesNotBlock) {
    const TempFolder folder;
    ASSERT_EQ(mkfifo((folder / "pipe.stl").c_str(), 0600), 0);
    std::filesystem::create_symlink("loop.stl", folder / "loop.stl");
    folder.write("empty.stl", "");
    for (const std::string& file :
         {(folder / "pipe.stl").string(), folder.path().string(), std::string("/dev/zero"),
          (folder / "loop.stl").string(), (folder / "none.stl").string(), (folder / "empty.stl").string()}) {
        try {
            read_surface(file);
            ADD_FAILURE() << file << " was read";
        } catch (const InputError& e) {
            EXPECT_EQ(std::string(e.what()).rfind(file + ": ", 0), 0u) << e.what();
        }
    }
}

TEST(SurfaceRefusal, MessagesShowNoControlCharacters) {
    EXPECT_EQ(printable("a\nb\x1b[31m\xff"), "a\\x0Ab\\x1B[31m\\xFF");
    EXPECT_EQ(printable("Flügel"), "Flügel");
    const std::string message = refusal(formats::read_obj, "v 0 \x1b[2J 0\n");
    EXPECT_NE(message.find("\\x1B[2J"), std::string::npos);
}

}  // namespace
}  // namespace strake
