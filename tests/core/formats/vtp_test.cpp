#include "core/formats/vtp.hpp"

#include "core/error.hpp"
#include "core/mesh/temp_folder.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>

#include <cstring>

namespace strake {
namespace {

/// The bytes of the appended array of that name.
std::string array_of(const std::string& vtp, const std::string& name) {
    const std::size_t at = vtp.find("Name=\"" + name + "\"");
    if (at == std::string::npos) return "";
    const std::size_t offset = std::stoul(vtp.substr(vtp.find("offset=\"", at) + 8));
    const std::size_t begin = vtp.find("<AppendedData encoding=\"raw\">\n_") + 31 + offset;
    std::uint64_t length = 0;
    std::memcpy(&length, vtp.data() + begin, 8);
    return vtp.substr(begin + 8, length);
}

std::string raw(const void* data, std::size_t bytes) { return {static_cast<const char*>(data), bytes}; }

TEST(Vtp, ArraysStandWhereTheHeaderSays) {
    const TempFolder folder;
    const TriMesh mesh = icosphere(1);
    const Eigen::VectorXd scalar = Eigen::VectorXd::LinSpaced(mesh.num_vertices(), 0, 1);
    std::vector<int> label(static_cast<std::size_t>(mesh.num_triangles()));
    for (std::size_t t = 0; t < label.size(); ++t) label[t] = static_cast<int>(t % 5);
    write_vtp(folder / "a.vtp", mesh, {{"height", scalar}, {"v", mesh.vertices}}, {{"patch <1>", label}});
    const std::string vtp = bytes_of(folder / "a.vtp");
    EXPECT_EQ(array_of(vtp, "height"), raw(scalar.data(), 8 * scalar.size()));
    EXPECT_EQ(array_of(vtp, "v"), raw(mesh.vertices.data(), 8 * mesh.vertices.size()));
    EXPECT_EQ(array_of(vtp, "Points"), raw(mesh.vertices.data(), 8 * mesh.vertices.size()));
    EXPECT_EQ(array_of(vtp, "patch &lt;1&gt;"), raw(label.data(), 4 * label.size()));
    EXPECT_EQ(array_of(vtp, "connectivity"), raw(mesh.triangles.data(), 4 * mesh.triangles.size()));
    const std::string offsets = array_of(vtp, "offsets");
    int last = 0;
    std::memcpy(&last, offsets.data() + offsets.size() - 4, 4);
    EXPECT_EQ(last, 3 * mesh.num_triangles());
}

TEST(Vtp, RefusesWrongCountsAndValues) {
    const TempFolder folder;
    const TriMesh mesh = icosphere(0);
    const auto file = folder / "a.vtp";
    EXPECT_THROW(write_vtp(file, mesh, {{"a", Eigen::VectorXd::Zero(11).eval()}}), InvalidInput);
    EXPECT_THROW(write_vtp(file, mesh, {}, {{"a", std::vector<int>(19)}}), InvalidInput);
    EXPECT_THROW(write_vtp(file, mesh, {{"a", Eigen::VectorXd::Constant(12, NAN).eval()}}), InvalidInput);
    EXPECT_FALSE(std::filesystem::exists(file));
    EXPECT_THROW(write_vtp(folder / "none/a.vtp", mesh), OutputError);
}

TEST(Vtp, SeriesNamesEachStep) {
    const TempFolder folder;
    write_pvd(folder / "s.pvd", {{0, "a.vtp"}, {0.5, "b&c.vtp"}});
    const std::string pvd = bytes_of(folder / "s.pvd");
    EXPECT_NE(pvd.find("<DataSet timestep=\"0.5\" part=\"0\" file=\"b&amp;c.vtp\"/>"), std::string::npos);
}

}  // namespace
}  // namespace strake
