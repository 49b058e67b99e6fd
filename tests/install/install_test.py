"""Installs the build into a fresh folder, compiles its headers, and builds the programs of docs/library.md and
docs/developer.md against it: install_test.py BUILD

All headers are compiled together, so that two that say different things of one name are found, forwards and backwards, so
that most that lack an include are; where STRAKE_LONG is set, each by itself, so that all such are."""
import concurrent.futures
import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
STANDARD = {"algorithm", "any", "array", "atomic", "bit", "bitset", "cfenv", "charconv", "chrono", "cinttypes", "cmath", "compare",
            "complex", "concepts", "condition_variable", "cstddef", "cstdint", "cstdio", "cstdlib", "cstring", "deque",
            "exception", "filesystem", "fstream", "functional", "future", "initializer_list", "iomanip", "ios", "iosfwd",
            "iostream", "istream", "iterator", "limits", "list", "locale", "map", "memory", "mutex", "new", "numbers",
            "numeric", "optional", "ostream", "queue", "random", "ranges", "ratio", "regex", "set", "shared_mutex", "span",
            "sstream", "stack", "stdexcept", "stop_token", "string", "string_view", "system_error", "thread", "tuple",
            "type_traits", "typeindex", "typeinfo", "unordered_map", "unordered_set", "utility", "valarray", "variant",
            "vector", "version", "stddef.h", "stdint.h"}


def run(*command, cwd=None):
    done = subprocess.run([str(word) for word in command], cwd=cwd, text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, check=False)
    if done.returncode != 0:
        raise SystemExit(f"{command}: status {done.returncode}\n{done.stdout[-4000:]}")
    return done.stdout


def check_headers(include):
    """What a header includes is installed, of the standard library, or Eigen's."""
    headers = sorted(include.rglob("*.h*"))
    assert len(headers) > 100, f"{len(headers)} headers"
    for header in headers:
        for quoted, angled in re.findall(r'^#include (?:"([^"]+)"|<([^>]+)>)', header.read_text(), re.M):
            known = (include / quoted).is_file() if quoted else angled in STANDARD or angled.startswith("Eigen/")
            assert known, f"{header.relative_to(include)} includes {quoted or angled}"


def eigen():
    for folder in (pathlib.Path("/usr/include/eigen3"), pathlib.Path("/usr/local/include/eigen3")):
        if folder.is_dir():
            return folder
    return pathlib.Path(run("pkg-config", "--variable=includedir", "eigen3").strip()) / "eigen3"


def compile_one(include, source):
    """As other people's compilers see it: with warnings, of which there are none."""
    return run(os.environ.get("CXX", "c++"), "-std=c++20", "-fsyntax-only", "-Wall", "-Werror", f"-I{include}",
               f"-isystem{eigen()}", source)


def compile_headers(include, folder):
    headers = [str(h.relative_to(include)) for h in sorted(include.rglob("*.hpp"))]
    alone = [[h] for h in headers] if os.environ.get("STRAKE_LONG") else []
    sources = []
    for number, group in enumerate([headers, headers[::-1]] + alone):
        sources.append(folder / f"headers{number}.cpp")
        sources[-1].write_text("".join(f'#include "{h}"\n' for h in group))
    with concurrent.futures.ThreadPoolExecutor(max_workers=2) as two:
        list(two.map(lambda source: compile_one(include, source), sources))
    (folder / "plugin.c").write_text("#include <strake/plugin.h>\n")
    run(os.environ.get("CC", "cc"), "-std=c99", "-fsyntax-only", "-Wall", "-Wextra", "-Wpedantic", "-Werror",
        f"-I{include.parent}", folder / "plugin.c")
    return len(headers)


def moved():
    """Old path -> new paths of the headers that have moved."""
    rows = [line.split() for line in (ROOT / "cmake/moved_headers.txt").read_text(encoding="ascii").splitlines() if line[0] != "#"]
    for old, *new in rows:
        for header in new:
            assert (ROOT / header).is_file(), f"cmake/moved_headers.txt: {old}: there is no {header}"
    return {old: new for old, *new in rows}


def check_moved(include, folder, *sources):
    """Programs written against 0.1 compile: each old path leads to its header, with a note that says where that is."""
    table = moved()
    there = {old: new for old, new in table.items() if all((include / header).is_file() for header in new)}
    assert len(there) > 60, f"{len(there)} of {len(table)} moved headers have one at the old path"
    missing = [old for old in there if not (include / old).is_file()]
    assert not missing, missing
    old_path = {new[0]: old for old, new in there.items()}
    for number, source in enumerate(sources):
        before = re.sub(r'^#include "([^"]+)"', lambda m: f'#include "{old_path.get(m[1], m[1])}"', source, flags=re.M)
        assert before != source, "the program includes no moved header"
        (folder / f"before{number}.cpp").write_text(before)
        said = compile_one(include, folder / f"before{number}.cpp")
        assert re.search(r"has moved to \S+; the old path goes at 1\.0", said), said
    return len(there)


def programs(name):
    """The blocks of C++ of a page, and its CMakeLists.txt if it has one."""
    page = (ROOT / "docs" / name).read_text(encoding="utf-8")
    return [code for kind, code in re.findall(r"^```(cmake|cpp)\n(.*?)^```", page, re.M | re.S)]


def main():
    build = pathlib.Path(sys.argv[1]).resolve()
    cmake, bend = programs("library.md")
    quantity, = programs("developer.md")
    with tempfile.TemporaryDirectory() as temporary:
        prefix, project = pathlib.Path(temporary) / "prefix", pathlib.Path(temporary) / "project"
        run("cmake", "--install", build, "--prefix", prefix)
        check_headers(prefix / "include/strake")
        project.mkdir()
        print(compile_headers(prefix / "include/strake", project), "headers compile")
        print(check_moved(prefix / "include/strake", project, bend, quantity), "old paths lead to a header")
        (project / "CMakeLists.txt").write_text(cmake + "add_executable(quantity quantity.cpp)\n"
                                                        "target_link_libraries(quantity PRIVATE strake::objectives)\n")
        (project / "bend.cpp").write_text(bend)
        (project / "quantity.cpp").write_text(quantity)
        run("cmake", "-S", project, "-B", project / "build", "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={prefix}")
        run("cmake", "--build", project / "build")
        print(run(project / "build/quantity", cwd=project))
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
