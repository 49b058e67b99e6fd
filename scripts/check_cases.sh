#!/bin/bash
# Makes the surfaces of the shipped cases and runs `strake check` on all of them: check_cases.sh BIN
# BIN holds strake and make_surface. The bunny, which is a download, only where it is there.
set -uo pipefail
cd "$(dirname "$0")/.."
bin=$1
scripts/examples.sh cases "$bin" || exit 1
count=0 bad=0
while IFS= read -r -d '' file; do
    grep -q '^case *:' "$file" || continue
    [ "$file" != cases/paper/bunny.yaml ] || [ -e cases/paper/generated/bunny.ply ] || continue
    count=$((count + 1))
    "$bin/strake" check "$file" || { echo "$file: status $?"; bad=$((bad + 1)); }
done < <(find cases -name '*.yaml' -not -path '*/generated/*' -print0 | sort -z)
echo "$count cases checked, $bad bad"
[ $count -gt 0 ] && [ $bad = 0 ]
