#include "core/formats/io.hpp"

#include "core/error.hpp"
#include "core/mesh/temp_folder.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <limits>

/// What is there after a surface was written, or could not be.
namespace strake {
namespace {

TEST(SurfaceWriting, WritesThroughLinksWithTheUmaskAndLeavesNothingBehind) {
    const TempFolder folder;
    const TriMesh mesh = icosphere(0);
    std::filesystem::create_symlink(folder / "real.off", folder / "link.off");
    folder.write("real.off", "old");
    write_surface(folder / "link.off", mesh, SurfaceFormat::off);
    EXPECT_TRUE(std::filesystem::is_symlink(folder / "link.off"));
    EXPECT_EQ(read_surface(folder / "real.off").mesh.num_triangles(), 20);
    const mode_t old = umask(077);
    write_surface(folder / "private.off", mesh, SurfaceFormat::off);
    umask(old);
    struct stat st;
    ASSERT_EQ(stat((folder / "private.off").c_str(), &st), 0);
    EXPECT_EQ(st.st_mode & 0777, 0600u);
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 3);
}

TEST(SurfaceWriting, AFailedWriteKeepsTheOldFile) {
    const TempFolder folder;
    TriMesh mesh = icosphere(0);
    const auto file = folder.write("a.stl", "old");
    mesh.vertices(0, 0) = 1e300;
    EXPECT_THROW(write_surface(file, mesh, SurfaceFormat::stl_binary), OutputError);
    mesh.vertices(0, 0) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(write_surface(file, mesh, SurfaceFormat::off), InvalidInput);
    EXPECT_EQ(bytes_of(file), "old");
    EXPECT_THROW(write_surface(folder / "none/a.off", icosphere(0), SurfaceFormat::off), OutputError);
    EXPECT_THROW(write_surface(folder.path(), icosphere(0), SurfaceFormat::off), OutputError);
}

}  // namespace
}  // namespace strake
