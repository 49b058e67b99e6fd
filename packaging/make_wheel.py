#!/usr/bin/python3
"""The wheel: make_wheel.py VERSION INSTALLED WORK DIST

INSTALLED is the prefix of an installation (bin/strake, lib/python3/dist-packages/strake). The wheel has the module, its types,
the program as `strake` on the PATH and by `python -m strake`, and every shared library that is not of glibc, in strake.libs,
found by a run path relative to each file. Fails if a library is missing or needs a newer glibc than Debian 12's. The wheel is
for the Python that the module was built for, which must be the one that runs this.
"""
import base64
import csv
import hashlib
import io
import os
import pathlib
import re
import shutil
import subprocess
import sys
import sysconfig
import zipfile

# What every Linux with this glibc has: never bundled.
OF_THE_SYSTEM = re.compile(r"^(ld-linux|linux-vdso|lib(c|m|dl|rt|pthread|util|resolv|anl|nsl)\.so)")
MAX_GLIBC = (2, 36)
PROGRAMS = ["strake", "make_surface"]


def run(*command):
    return subprocess.run([str(word) for word in command], check=True, text=True, capture_output=True).stdout


def needed(file):
    """{name: path} of the shared libraries that the loader finds for a file, the system's left out."""
    found = {}
    for line in run("ldd", file).splitlines():
        match = re.match(r"\s*(\S+) => (\S+|not found)", line)
        if not match or OF_THE_SYSTEM.match(match[1]):
            continue
        if match[2] == "not":
            raise SystemExit(f"make_wheel.py: {file} needs {match[1]}, which is not installed")
        found[match[1]] = match[2]
    return found


def glibc_of(file):
    """The newest version of glibc's symbols that a file needs."""
    versions = re.findall(r"GLIBC_(\d+)\.(\d+)", run("objdump", "-T", file))
    return max(((int(a), int(b)) for a, b in versions), default=(0, 0))


def bundle(package, libs):
    """Copies what module and program need, and points all of them there."""
    libs.mkdir()
    programs = [package / "bin" / name for name in PROGRAMS]
    ours = [*package.glob("_core*.so"), *programs]
    names = {}
    for file in ours:
        names |= needed(file)
    for name, path in sorted(names.items()):
        shutil.copy(path, libs / name)
        os.chmod(libs / name, 0o755)
    for file in [*ours, *libs.iterdir()]:
        to_libs = "/../../strake.libs" if file in programs else "" if file.parent == libs else "/../strake.libs"
        run("patchelf", "--set-rpath", "$ORIGIN" + to_libs, file)
    for file in [*ours, *libs.iterdir()]:
        if glibc_of(file) > MAX_GLIBC:
            raise SystemExit(f"make_wheel.py: {file.name} needs glibc {'.'.join(map(str, glibc_of(file)))}, newer than {MAX_GLIBC}")
        stray = [path for path in needed(file).values() if pathlib.Path(path).resolve().parent != libs.resolve()]
        if stray:
            raise SystemExit(f"make_wheel.py: {file.name} finds {stray} outside of the wheel")


MAIN = '''"""`python -m strake` and the command `strake`: the program."""
import os
import pathlib
import sys


def start(name):
    program = pathlib.Path(__file__).parent / "bin" / name
    os.execv(program, [str(program), *sys.argv[1:]])


def main():
    start("strake")


def make_surface():
    start("make_surface")


if __name__ == "__main__":
    main()
'''


def python_of(package):
    """(major, minor) of the Python that the module is for: the one that runs this."""
    module = next(package.glob("_core.cpython-*.so"), None)
    if module is None:
        raise SystemExit(f"make_wheel.py: {package} has no module")
    digits = re.match(r"_core\.cpython-(\d)(\d+)", module.name)
    version = (int(digits[1]), int(digits[2]))
    if version != sys.version_info[:2]:
        raise SystemExit("make_wheel.py: the module is for Python {}.{}, this is {}.{}".format(*version, *sys.version_info[:2]))
    return version


def numpy_of(package):
    """The versions of NumPy that the module works with: pybind11 before 2.12 does not know NumPy 2."""
    asked = f"import sys; sys.path.insert(0, {str(package)!r}); import _core; print(_core.numpy_2)"
    return ">=1.24" if run(sys.executable, "-B", "-c", asked).strip() == "True" else ">=1.24,<2"


def metadata(version, readme, licenses, python, numpy):
    permissive = "no part under the GPL" in licenses
    return (f"Metadata-Version: 2.1\nName: strake\nVersion: {version}\n"
            "Summary: Shape optimization of triangulated surfaces without CAD\n"
            f"License: {'Apache-2.0; libraries: see strake --licenses' if permissive else 'GPL-3.0-or-later'}\n"
            "Classifier: Programming Language :: C++\nClassifier: Topic :: Scientific/Engineering\nClassifier: Typing :: Typed\n"
            f"Requires-Python: >={python[0]}.{python[1]},<{python[0]}.{python[1] + 1}\nRequires-Dist: numpy{numpy}\n"
            f"Description-Content-Type: text/markdown\n\n{readme}")


def write(folder, info, tag, target):
    """All files in order, with times of SOURCE_DATE_EPOCH and a RECORD of their hashes."""
    when = __import__("time").gmtime(int(os.environ.get("SOURCE_DATE_EPOCH", "1000000000")))[:6]
    record = io.StringIO()
    rows = csv.writer(record, lineterminator="\n")
    (folder / info / "WHEEL").write_text(f"Wheel-Version: 1.0\nGenerator: strake\nRoot-Is-Purelib: false\nTag: {tag}\n")
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as out:
        def add(name, data, mode):
            item = zipfile.ZipInfo(name, when)
            item.external_attr = (0o100000 | mode) << 16
            item.compress_type = zipfile.ZIP_DEFLATED
            out.writestr(item, data)
        for file in sorted(p for p in folder.rglob("*") if p.is_file()):
            name, data = file.relative_to(folder).as_posix(), file.read_bytes()
            digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
            rows.writerow([name, f"sha256={digest}", len(data)])
            add(name, data, 0o755 if os.access(file, os.X_OK) else 0o644)
        rows.writerow([f"{info}/RECORD", "", ""])
        add(f"{info}/RECORD", record.getvalue(), 0o644)


def make(version, installed, work, dist):
    """@return the wheel's path"""
    root = pathlib.Path(__file__).resolve().parents[1]
    shutil.rmtree(work, ignore_errors=True)
    package = work / "strake"
    shutil.copytree(installed / "lib/python3/dist-packages/strake", package)
    (package / "bin").mkdir()
    for name in PROGRAMS:
        shutil.copy(installed / "bin" / name, package / "bin" / name)
    (package / "__main__.py").write_text(MAIN)
    python = python_of(package)
    bundle(package, work / "strake.libs")
    info = f"strake-{version}.dist-info"
    (work / info).mkdir()
    (work / info / "METADATA").write_text(metadata(
        version, (root / "README.md").read_text(encoding="utf-8"), run(package / "bin/strake", "--licenses"), python, numpy_of(package)),
        encoding="utf-8")
    (work / info / "entry_points.txt").write_text("[console_scripts]\nstrake = strake.__main__:main\nmake_surface = strake.__main__:make_surface\n")
    shutil.copy(root / "LICENSE", work / info / "LICENSE")
    machine = sysconfig.get_platform().replace("-", "_").replace(".", "_").replace("linux", "manylinux_{}_{}".format(*MAX_GLIBC))
    tag = "cp{0}{1}-cp{0}{1}-{2}".format(*python, machine)
    target = dist / f"strake-{version}-{tag}.whl"
    write(work, info, tag, target)
    return target


if __name__ == "__main__":
    make(sys.argv[1], *map(pathlib.Path, sys.argv[2:]))
