#!/usr/bin/env bash
# Fuzzes the readers of files: fuzz.sh [SECONDS] [TARGET...], two targets at a time, 60 s each unless told otherwise.
# Needs cargo-fuzz and a nightly toolchain. Prints a line a target; inputs that fail come to fuzz/artifacts/TARGET.
set -euo pipefail
cd "$(dirname "$0")/../fuzz"
seconds=${1:-60}
shift || true
targets=("$@")
[ ${#targets[@]} -gt 0 ] || targets=(parquet checkpoint packing model case csv mesh voxels bonds)
corpus=work/corpus

cargo +nightly fuzz build --codegen-units 16 1>&2
programs=target/$(rustc -vV | sed -n 's/host: //p')/release
"$programs/seeds" "$corpus"

# Largest input of a target, bytes.
declare -A largest=([case]=8192 [packing]=4096 [model]=8192 [checkpoint]=24576 [csv]=4096 [parquet]=8192 [mesh]=4096 [voxels]=4096 [bonds]=24576)

fuzz() {
    local target=$1 words=() log=work/$1.log start=$SECONDS finds
    mkdir -p "artifacts/$target" "$corpus/$target"
    for kept in "corpus/$target" "regressions/$target"; do
        [ -d "$kept" ] && cp -n "$kept"/* "$corpus/$target/" 2>/dev/null
    done
    [ -f "dictionaries/$target" ] && words=("-dict=dictionaries/$target")
    # A find ends a run of libFuzzer: go on until the time is over.
    : >"$log"
    while [ $((SECONDS - start)) -lt "$seconds" ]; do
        "$programs/$target" "$corpus/$target" "${words[@]}" -max_len="${largest[$target]}" -timeout=10 \
            -rss_limit_mb=1024 -malloc_limit_mb=512 -artifact_prefix="artifacts/$target/" -print_final_stats=1 \
            -max_total_time=$((seconds - SECONDS + start)) >>"$log" 2>&1 || true
    done
    finds=$(find "artifacts/$target" -type f | wc -l)
    awk -v target="$target" -v seconds=$((SECONDS - start)) -v finds="$finds" '
        /stat::number_of_executed_units/ { runs += $2 }
        / cov: / { for (k = 1; k < NF; k++) if ($k == "cov:") coverage = $(k + 1) }
        END { printf "%-10s %12d executions %7d edges %6d s %4d finds\n", target, runs, coverage, seconds, finds }' "$log"
}

running=0
for target in "${targets[@]}"; do
    fuzz "$target" &
    running=$((running + 1))
    if [ $running -ge 2 ]; then
        wait -n
        running=$((running - 1))
    fi
done
wait
