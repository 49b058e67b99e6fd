"""A build with -DSTRAKE_GPL=OFF has no part under the GPL: permissive_test.py STRAKE LIBRARY_FOLDER [FILE]...

By what the program says, by the libraries that the loader finds for it and for FILEs, and by the names in the archives: those of
CHOLMOD, SPQR, Ceres and CGAL's alpha wrap would show there.
"""
import pathlib
import re
import subprocess
import sys

GPL = re.compile(r"cholmod|spqr|umfpack|klu|btf|ceres|glog|gflags|suitesparse|amd\.so|colamd|camd")
NAMES = re.compile(r"\bcholmod_|SuiteSparseQR|ceres::|CGAL::Alpha_wrap|CGAL::Alpha_wraps_3")


def told(*command):
    return subprocess.run([str(word) for word in command], check=True, text=True, capture_output=True).stdout


strake, folder = sys.argv[1], pathlib.Path(sys.argv[2])
licenses = told(strake, "--licenses")
assert "no part under the GPL" in licenses, licenses
assert not re.search(r"\bGPL-(?!\S+ WITH GCC-exception)", licenses), licenses
for file in [strake, *sys.argv[3:]]:
    libraries = told("ldd", file)
    assert "libc.so" in libraries, libraries  # that ldd looks into it
    assert not GPL.search(libraries), f"{file}\n{libraries}"
archives = sorted(folder.rglob("libstrake_*.a"))
assert len(archives) > 10, archives
for archive in archives:
    found = NAMES.search(told("nm", "-C", archive))
    assert not found, f"{archive}: {found[0]}"
print(f"{len(sys.argv) - 2} binaries and {len(archives)} libraries have no part under the GPL")
