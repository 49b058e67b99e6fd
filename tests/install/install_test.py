"""Installs the build into a fresh folder and builds the example of docs/library.md against it: install_test.py BUILD."""
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
STANDARD = {"algorithm", "array", "atomic", "chrono", "cmath", "cstddef", "cstdint", "cstdlib", "cstring", "deque", "exception",
            "filesystem", "fstream", "functional", "future", "limits", "locale", "map", "memory", "mutex", "numeric",
            "optional", "set", "span", "sstream", "stdexcept", "string", "string_view", "thread", "tuple", "utility",
            "variant", "vector", "stddef.h", "stdint.h"}


def run(*command, cwd=None):
    done = subprocess.run([str(word) for word in command], cwd=cwd, text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, check=False)
    if done.returncode != 0:
        sys.exit(f"{command}: status {done.returncode}\n{done.stdout[-4000:]}")
    return done.stdout


def check_headers(include):
    """What a header includes is installed, of the standard library, or Eigen's."""
    headers = sorted(include.rglob("*.h*"))
    assert len(headers) > 100, f"{len(headers)} headers"
    for header in headers:
        for quoted, angled in re.findall(r'^#include (?:"([^"]+)"|<([^>]+)>)', header.read_text(), re.M):
            known = (include / quoted).is_file() if quoted else angled in STANDARD or angled.startswith("Eigen/")
            assert known, f"{header.relative_to(include)} includes {quoted or angled}"


def main():
    build = pathlib.Path(sys.argv[1]).resolve()
    page = (ROOT / "docs/library.md").read_text(encoding="utf-8")
    blocks = {kind: code for kind, code in re.findall(r"^```(cmake|cpp)\n(.*?)^```", page, re.M | re.S)}
    with tempfile.TemporaryDirectory() as temporary:
        prefix, project = pathlib.Path(temporary) / "prefix", pathlib.Path(temporary) / "project"
        run("cmake", "--install", build, "--prefix", prefix)
        check_headers(prefix / "include/strake")
        project.mkdir()
        (project / "CMakeLists.txt").write_text(blocks["cmake"])
        (project / "bend.cpp").write_text(blocks["cpp"])
        run("cmake", "-S", project, "-B", project / "build", "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={prefix}")
        run("cmake", "--build", project / "build")
        told = run(project / "build/bend", cwd=project)
        print(told)
        lifted = float(re.search(r"lifted by ([-0-9.e]+)", told)[1])
        assert 0.01 < lifted < 2, told
        version = run(prefix / "bin/strake", "--version").split()[1]
        assert f"strake {version}:" in told, (version, told)
        text = "\n".join(f.read_text() for f in (prefix / "lib/cmake/strake").glob("*.cmake"))
        assert str(ROOT) not in text and str(build) not in text, "the package names folders of the build"


if __name__ == "__main__":
    main()
