#!/usr/bin/env bash
# Measures everything and prints the tables of docs/performance.md; draws docs/performance.svg.
# On a quiet machine: each bench counts processor time, but caches and memory are shared with whatever else runs.
# `benches/run.sh evaluation grid` runs only those. Peers in Python (peers/NAME.py, with numpy and scipy) run before the bench
# of that name, and their numbers stand in its tables; PYTHON says which interpreter to ask (python3).
set -euo pipefail
cd "$(dirname "$0")"
echo "$(date -u +%F), load $(cut -d' ' -f1-3 /proc/loadavg), $(sed -n 's/^model name.*: //p' /proc/cpuinfo | head -1), $(rustc --version)"
cargo build -q --release --manifest-path ../Cargo.toml --bin loftsman --locked
mkdir -p target
names=("$@")
[ ${#names[@]} -gt 0 ] || names=(evaluation grid threads tessellation solids least_adjustment interpolation area_volume quadratic_program fairing \
    five_surfaces conversion fine_tuning dynamics subdivision)
results="${CRITERION_HOME:-${CARGO_TARGET_DIR:-target}/criterion}"
for name in "${names[@]}"; do
    if [ -f "peers/$name.py" ]; then
        # Never numbers of an earlier run beside today's.
        find "$results" -mindepth 2 -maxdepth 2 \( -name numpy -o -name 'MuJoCo cable' -o -name OpenCASCADE -o -name scipy -o -name PyElastica -o -name 'OpenSubdiv*' \) -prune -exec rm -r {} + 2>/dev/null || true
        if "${PYTHON:-python3}" -c 'import numpy, scipy' 2>/dev/null; then
            OPENBLAS_NUM_THREADS=1 "${PYTHON:-python3}" "peers/$name.py" "$results"
        else
            echo "SKIPPED: peers/$name.py: ${PYTHON:-python3} has no numpy and scipy; set PYTHON to one that has" >&2
        fi
    fi
    features=()
    [ "$name" != threads ] || features=(--features parallel)
    if [ "$name" = subdivision ]; then
        if [ -n "${PETITE:-}" ]; then features=(--features petite); else
            echo "SKIPPED: opensubdiv-petite, which compiles OpenSubdiv: PETITE=1 where cmake, a compiler of C++ and libclang are" >&2
        fi
    fi
    # Criterion's own lines stay away; what went wrong does not.
    cargo bench -q --locked --bench "$name" "${features[@]}" 2>"target/$name.log" | grep -E '^(\||## |$)' | cat -s \
        || { cat "target/$name.log" >&2; exit 1; }
done
cargo run -q --profile bench --locked --bin chart > ../docs/performance.svg
