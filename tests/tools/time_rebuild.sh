#!/usr/bin/env bash
# Time of a rebuild, old and new in turn: tests/tools/time_rebuild.sh OLD [NEW] [ROUNDS]
#
# OLD and NEW are clones (NEW: this one); ROUNDS of each, 3 at least. PYTHON names the interpreter of an environment
# with the requirements of both (python3 on the path otherwise). In each round every clone is built twice in a fresh
# copy: cold, with nothing compiled and no result, and warm, with the engine compiled and the results removed. At the
# end both ratios new / old are printed, of the shortest times, with the medians beside them. Use a machine that does
# nothing else.
set -euo pipefail

old=$(realpath "${1:?usage: time_rebuild.sh OLD [NEW] [ROUNDS]}")
new=$(realpath "${2:-$(dirname "$0")/../..}")
rounds=${3:-3}
python=$(command -v "${PYTHON:-python3}")
cores=${CORES:-2}

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

build() { # NAME KIND: builds the copy, and notes its time
    local begun ended
    begun=$(date +%s.%N)
    (cd "$work/copy" && PYTHONPATH="$work/copy/src" XDG_CACHE_HOME="$work/cache" \
        "$python" -m snakemake "-j$cores" >"$work/log" 2>&1) || { tail -30 "$work/log" >&2; exit 1; }
    ended=$(date +%s.%N)
    echo "$1 $2 $(echo "$ended $begun" | awk '{printf "%.2f", $1 - $2}')" | tee -a "$work/times"
}

for ((round = 1; round <= rounds; round++)); do
    for name in old new; do
        rm -rf "$work/copy" "$work/cache"
        mkdir "$work/copy"
        # Without .git, results and all that a run leaves.
        tar -C "${!name}" -cf - --exclude=./.git --exclude=./.venv --exclude=./.snakemake --exclude=./results \
            --exclude=./logs --exclude=__pycache__ . | tar -C "$work/copy" -xf -
        build "$name" cold
        # The markers of the compiled engine stay, as they do for somebody who changes a setting of every figure.
        find "$work/copy/results" -mindepth 1 -maxdepth 1 ! -name 'engine*' -exec rm -rf {} +
        build "$name" warm
    done
done

"$python" - "$work/times" <<'END'
import sys
from statistics import median

times = {}
for line in open(sys.argv[1], encoding="utf-8"):
    name, kind, seconds = line.split()
    times.setdefault((kind, name), []).append(float(seconds))
for kind in ("cold", "warm"):
    old, new = times[kind, "old"], times[kind, "new"]
    print(f"{kind} rebuild: new / old = {min(new) / min(old):.0%} of the shortest times ({min(new):.1f} s / {min(old):.1f} s), "
          f"{median(new) / median(old):.0%} of the medians ({median(new):.1f} s / {median(old):.1f} s), {len(new)} each")
END
