"""A build with -DSTRAKE_GPL=OFF has no part under the GPL: permissive_test.py STRAKE LIBRARY_FOLDER [FILE]...

By what the program says, by the libraries that the loader finds for it and for FILEs, by the names in the archives (those of
CHOLMOD, SPQR, Ceres and CGAL's alpha wrap would show there), and by the licences of all headers that were compiled in.
"""
import functools
import pathlib
import re
import subprocess
import sys

GPL = re.compile(r"cholmod|spqr|umfpack|klu|btf|ceres|glog|gflags|suitesparse|amd\.so|colamd|camd")
NAMES = re.compile(r"\bcholmod_|SuiteSparseQR|ceres::|CGAL::Alpha_wrap|CGAL::Alpha_wraps_3")


def told(*command):
    return subprocess.run([str(word) for word in command], check=True, text=True, capture_output=True).stdout


@functools.lru_cache(None)
def license_of(header):
    """The licence that a header names in its first lines; those of the system and of the compiler have exceptions for users."""
    try:
        begin = pathlib.Path(header).read_text(errors="replace")[:3000]
    except OSError:  # made meanwhile, or gone
        return ""
    named = re.search(r"SPDX-License-Identifier:(.*)", begin)
    if named:
        return named[1]
    of_choice = "Lesser General Public License" in begin  # as GMP: either
    return "GPL" if "GNU General Public License" in begin and "xception" not in begin and not of_choice else ""


def gpl_headers(folder):
    """{object: headers under the GPL} of the objects of a build, by what the compiler has read; tests, benchmarks and make_jet,
    which is a program of a test, are nobody's part."""
    found, objects, name = {}, 0, ""
    for line in told("ninja", "-C", folder, "-t", "deps").splitlines():
        if line and not line[0].isspace():
            name = line.split(":")[0]
            objects += 1
        elif line.strip() and not re.match(r"tests/|bench/|.*make_jet", name):
            of = license_of(line.strip())
            if re.search(r"(?<!L)GPL", of) and " WITH " not in of:
                found.setdefault(name, []).append(line.strip())
    assert objects > 20, objects
    return found


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
if (folder / "build.ninja").is_file():
    assert license_of("/usr/include/CGAL/alpha_wrap_3.h").strip().startswith("GPL-3.0"), "the check of headers sees a licence"
    found = gpl_headers(folder)
    assert not found, found
print(f"{len(sys.argv) - 2} binaries and {len(archives)} libraries have no part under the GPL")
