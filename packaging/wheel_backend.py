"""Makes the wheel for `pip install .` and `pip wheel .` (PEP 517): builds and installs by CMake, bundles by make_wheel.py.

Needs what scripts/setup.sh run package installs. The environment's CMAKE_ARGS go to CMake, for example -DSTRAKE_GPL=OFF; so does
`--config-settings=build-dir=FOLDER`: a build with -DSTRAKE_PYTHON=ON that is there already, which is installed as it is.
"""
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

import make_wheel

ROOT = pathlib.Path(__file__).resolve().parents[1]


class UnsupportedOperation(Exception):
    """What PEP 517 wants to see where there is no source distribution."""


def run(*command):
    subprocess.run([str(word) for word in command], cwd=ROOT, check=True)


def built():
    """A folder with the program and the module for the Python that runs this."""
    missing = [name for name in ("cmake", "ninja", "patchelf") if not shutil.which(name)]
    if missing:
        raise SystemExit(f"strake: building needs {', '.join(missing)}; on Debian 12 `scripts/setup.sh run package` installs everything")
    build = ROOT / f"build/wheel-{sys.implementation.cache_tag}"
    run("cmake", "-S", ".", "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DSTRAKE_TESTS=OFF", "-DSTRAKE_UNITY=ON",
        "-DSTRAKE_PYTHON=ON", f"-DPython_EXECUTABLE={sys.executable}", *shlex.split(os.environ.get("CMAKE_ARGS", "")))
    run("ninja", "-C", build)
    return build


def get_requires_for_build_wheel(config_settings=None):  # pylint: disable=unused-argument
    return ["numpy"]  # the module is asked which versions of it it knows


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):  # pylint: disable=unused-argument
    version = re.search(r"^project\(strake VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"), re.M)[1]
    build = (config_settings or {}).get("build-dir") or built()
    with tempfile.TemporaryDirectory() as folder:
        installed = pathlib.Path(folder) / "installed"
        run("cmake", "--install", build, "--prefix", installed)
        return make_wheel.make(version, installed, pathlib.Path(folder) / "wheel", pathlib.Path(wheel_directory)).name


def build_sdist(sdist_directory, config_settings=None):
    raise UnsupportedOperation("./package.sh source makes strake-VERSION.tar.xz")
