#!/usr/bin/env bash
# Measures everything and prints the tables of docs/performance.md; draws docs/performance.svg.
# On a quiet machine: each bench counts processor time, but caches and memory are shared with whatever else runs.
# `benches/run.sh evaluation grid` runs only those.
set -euo pipefail
cd "$(dirname "$0")"
echo "$(date -u +%F), load $(cut -d' ' -f1-3 /proc/loadavg), $(sed -n 's/^model name.*: //p' /proc/cpuinfo | head -1), $(rustc --version)"
cargo build -q --release --manifest-path ../Cargo.toml --bin loftsman --locked
mkdir -p target
names=("$@")
[ ${#names[@]} -gt 0 ] || names=(evaluation grid threads tessellation least_adjustment interpolation area_volume conversion)
for name in "${names[@]}"; do
    features=()
    [ "$name" != threads ] || features=(--features parallel)
    # Criterion's own lines stay away; what went wrong does not.
    cargo bench -q --locked --bench "$name" "${features[@]}" 2>"target/$name.log" | grep -E '^(\||## |$)' | cat -s \
        || { cat "target/$name.log" >&2; exit 1; }
done
cargo run -q --profile bench --locked --bin chart > ../docs/performance.svg
