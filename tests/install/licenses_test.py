"""`strake --licenses` names every library that the loader finds for the program: licenses_test.py STRAKE"""
import re
import subprocess
import sys

OF_THE_SYSTEM = r"linux-vdso|ld-linux|lib(c|m|dl|rt|pthread)$"
#: What the list calls a library, by the beginning of its file's name.
NAMES = {
    "yaml-cpp": "yaml-cpp", "fmt": "fmt", "nlopt": "NLopt", "metis": "METIS", "openblas": "OpenBLAS", "lapack": "OpenBLAS",
    "blas": "OpenBLAS", "sqlite3": "SQLite", "cpp-httplib": "cpp-httplib", "ssl": "OpenSSL", "crypto": "OpenSSL",
    "brotli": "Brotli", "z": "zlib", "gmp": "GMP", "mpfr": "MPFR", "embree": "Embree", "tbb": "oneTBB",
    "stdc++": "runtime libraries of GCC", "gcc_s": "runtime libraries of GCC", "gomp": "runtime libraries of GCC",
    "gfortran": "runtime libraries of GCC", "quadmath": "runtime libraries of GCC", "atomic": "runtime libraries of GCC",
    "ceres": "Ceres", "glog": "glog", "gflags": "gflags", "unwind": "libunwind", "lzma": "liblzma", "cholmod": "CHOLMOD",
    "spqr": "SPQR", "cxsparse": "CXSparse", "amd": "AMD", "camd": "CAMD", "colamd": "COLAMD", "ccolamd": "CCOLAMD",
    "suitesparseconfig": "CHOLMOD",
}


def told(*command):
    return subprocess.run(command, check=True, text=True, capture_output=True).stdout


licenses = told(sys.argv[1], "--licenses")
libraries = [line.split()[0].split("/")[-1].split(".so")[0] for line in told("ldd", sys.argv[1]).splitlines()]
assert "libc" in libraries, libraries
unnamed = []
for library in libraries:
    if re.match(OF_THE_SYSTEM, library):
        continue
    word = re.sub(r"^lib", "", library)
    begin = max((name for name in NAMES if word == name or len(name) > 1 and word.startswith(name)), key=len, default=None)
    if begin is None or not re.search(rf"(^|[ ,(]){re.escape(NAMES[begin])}", licenses, re.M):
        unnamed.append(library)
assert not unnamed, f"not in --licenses: {unnamed}\n{licenses}"
print(f"{len(libraries)} libraries, all named")
