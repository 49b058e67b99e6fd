#!/bin/bash
# One folder that runs on any x86-64 or arm64 Linux: make_tarball.sh VERSION INSTALLED DOCS CASES WORK DIST
# The program with the loader and all libraries of this machine; bin/strake is a script that starts them from wherever the folder is.
set -euo pipefail
version=$1 installed=$2 docs=$3 cases=$4 work=$5 dist=$6
name=strake-$version-$(uname -m)
folder=$work/$name
rm -rf "$work"
mkdir -p "$folder/bin" "$folder/lib" "$folder/share"
cp "$installed/bin/strake" "$installed/bin/make_surface" "$folder/lib"
missing=$(ldd "$folder/lib/strake" "$folder/lib/make_surface" | grep 'not found' || true)
[ -z "$missing" ] || { echo "make_tarball.sh: $missing" >&2; exit 1; }
ldd "$folder/lib/strake" "$folder/lib/make_surface" | awk '$2 == "=>" {print $3}' | sort -u | xargs -I{} cp -L {} "$folder/lib"
loader=$(ldd "$folder/lib/strake" | awk '$1 ~ /^\/.*ld-linux/ {print $1}')
cp -L "$loader" "$folder/lib/loader"
cat >"$folder/bin/strake" <<'SCRIPT'
#!/bin/sh
# Strake with its own loader and libraries. Programs that it starts see the environment as it was.
here=$(cd "$(dirname "$(readlink -f "$0")")/.." && pwd)
exec "$here/lib/loader" --library-path "$here/lib" --argv0 "$0" "$here/lib/PROGRAM" "$@"
SCRIPT
sed 's/PROGRAM/make_surface/' "$folder/bin/strake" >"$folder/bin/make_surface"
sed -i 's/PROGRAM/strake/' "$folder/bin/strake"
chmod +x "$folder/bin/strake" "$folder/bin/make_surface"
cp -r "$docs" "$folder/share/docs"
cp -r "$installed/share/man" "$installed/share/bash-completion" "$folder/share"
(cd "$cases/.." && git ls-files cases) | grep -v '^cases/geometry\|CMakeLists' | while read -r file; do
    mkdir -p "$folder/share/$(dirname "$file")"
    cp "$cases/../$file" "$folder/share/$file"
done
cp "$docs/../LICENSE" "$docs/../README.md" "$docs/../CHANGELOG.md" "$folder"
tar --sort=name --owner=0 --group=0 --numeric-owner --mtime="@${SOURCE_DATE_EPOCH:-0}" -C "$work" -cJf "$dist/$name.tar.xz" "$name"
