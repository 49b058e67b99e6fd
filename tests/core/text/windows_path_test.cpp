#include "core/text/windows_path.hpp"

#include <gtest/gtest.h>

/// Paths as Windows writes them, in messages of a program that runs under WSL.
namespace strake {
namespace {

TEST(WindowsPath, ADriveIsUnderMnt) {
    EXPECT_EQ(windows_path_hint("C:\\Users\\a b\\wing.stl"),
              "; in WSL this path of Windows is /mnt/c/Users/a b/wing.stl");
    EXPECT_EQ(windows_path_hint("d:/wing.stl"), "; in WSL this path of Windows is /mnt/d/wing.stl");
}

TEST(WindowsPath, AShareOfWslIsAFolderOfLinux) {
    EXPECT_EQ(windows_path_hint("\\\\wsl$\\Debian\\home\\a\\wing.stl"),
              "; in Linux folders are separated by '/': /home/a/wing.stl");
    EXPECT_EQ(windows_path_hint("\\\\wsl.localhost\\Debian\\home"), "; in Linux folders are separated by '/': /home");
    EXPECT_EQ(windows_path_hint("\\\\wsl$\\Debian"), "; in Linux folders are separated by '/': /");
}

TEST(WindowsPath, FoldersAreSeparatedBySlashes) {
    EXPECT_EQ(windows_path_hint("my data\\wing.stl"), "; in Linux folders are separated by '/': my data/wing.stl");
}

TEST(WindowsPath, OtherPathsNeedNoRemark) {
    for (const char* path : {"", "C:", "a", "my data/wing.stl", "/mnt/c/wing.stl", "1:/a", "cc:/a", "host:a"})
        EXPECT_EQ(windows_path_hint(path), "") << path;
}

TEST(WindowsPath, RemarksAreSafeToPrint) {
    EXPECT_EQ(windows_path_hint("a\\\x1b[31m"), "; in Linux folders are separated by '/': a/\\x1B[31m");
}

}  // namespace
}  // namespace strake
