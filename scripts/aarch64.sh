#!/usr/bin/env bash
# Shows that aarch64 gives the bits of the machine at hand: builds granum for both, runs small cases of every compiled set of
# laws, and of two that run through slots, natively and under emulation, and compares the digests of the runs. Then counts the instructions
# of a grain-step, the only figure of speed that an emulator can give.
#
# Needs (Debian): apt-get install gcc-aarch64-linux-gnu libc6-dev-arm64-cross qemu-user; rustup target add aarch64-unknown-linux-gnu
# Usage: scripts/aarch64.sh [--quick | --count]        (about 10 minutes on two cores, the most of it compilation)
#   --quick    only the engine: short runs with six sets of laws, grains of three shapes and bonds
# Exit code 77 where the cross compiler or the emulator is missing.
set -euo pipefail
cd "$(dirname "$0")/.."
target=aarch64-unknown-linux-gnu
for need in aarch64-linux-gnu-gcc qemu-aarch64; do
    command -v "$need" > /dev/null || { echo "$need is missing: apt-get install gcc-aarch64-linux-gnu libc6-dev-arm64-cross qemu-user"; exit 77; }
done
rustup target add "$target" > /dev/null 2>&1 || rustc --print target-libdir --target "$target" | xargs ls > /dev/null 2>&1 \
    || { echo "the standard library for $target cannot be had here"; exit 77; }
export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc CC_aarch64_unknown_linux_gnu=aarch64-linux-gnu-gcc
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

folder=${CARGO_TARGET_DIR:-target}
if [ "${1:-}" = --quick ]; then
    cargo build --locked -p granum-dem --example bits
    cargo build --locked -p granum-dem --example bits --target "$target"
    # The instruction sets differ, and all of one machine give the same: the digests of portable code are compared.
    "$folder/debug/examples/bits" | grep portable > "$out/here"
    qemu-aarch64 -L /usr/aarch64-linux-gnu "$folder/$target/debug/examples/bits" > "$out/all"
    cat "$out/all"
    grep portable "$out/all" > "$out/there"
    sed 's/neon/portable/' "$out/all" | sort -u | cut -c1-16 | sort > "$out/each"
    cut -c1-16 "$out/here" | sort | diff - "$out/each" && diff "$out/here" "$out/there" || { echo "DIFFERENT"; exit 1; }
    echo "same"
    exit
fi
cargo build --release --locked
cargo build --release --locked --target "$target"
native=$folder/release/granum
foreign=(qemu-aarch64 -L /usr/aarch64-linux-gnu "$folder/$target/release/granum")

# A shear test of 60 grains; the rest are keys of the case.
digest() {
    local name=$1; shift
    local program=(); while [ "$1" != -- ]; do program+=("$1"); shift; done; shift
    "${program[@]}" shear "$out/case.toml" --out "$out/$name" --threads 1 --set grains.count=60 --set preparation.solid_fraction=none \
        --set shear.deviator_strain=0.01 --set shear.inertial_number=1e-2 --set recording.states=5 \
        --set recording.observations_per_state=2 "$@" > /dev/null 2> "$out/$name.log" || { cat "$out/$name.log"; exit 1; }
    # The hash without the name of the folder.
    "$native" digest "$out/$name" | cut -d" " -f1
}

"$native" init "$out/case.toml" > /dev/null
failed=0
number=0
while read -r normal tangential rolling spread; do
    number=$((number + 1))
    keys=(--set "contact.normal=$normal" --set "contact.tangential=$tangential" --set "contact.rolling=$rolling" --set "grains.spread=$spread")
    here=$(digest "here-$number" "$native" -- "${keys[@]}")
    there=$(digest "there-$number" "${foreign[@]}" -- "${keys[@]}")
    if [ "$here" = "$there" ]; then same="same"; else same="DIFFERENT"; failed=1; fi
    printf '%-9s %s  %s %s %s, spread %s\n' "$same" "${here:0:16}" "$normal" "$tangential" "$rolling" "$spread"
done <<'CASES'
hertz mindlin-deresiewicz none 0
hertz no-slip none 0.3
jkr mindlin-deresiewicz none 0.3
jkr no-slip none 0
jkr peeling none 0.3
hooke no-slip none 0.3
hertz no-slip elastic-plastic 0.3
CASES

if [ "${1:-}" = --count ]; then
    ${CC:-cc} -shared -fPIC -O2 scripts/instruction_count.c -o "$out/count.so"
    count() {
        qemu-aarch64 -L /usr/aarch64-linux-gnu -plugin "$out/count.so" -d plugin -D "$out/count.txt" \
            "$folder/$target/release/granum" bench --packing data/packing-5000.csv --grains 5000 --threads 1 --only dem "$@" > /dev/null
        sed -n 's/^instructions: //p' "$out/count.txt"
    }
    for law in hertz,no-slip jkr,no-slip; do
        for isa in neon portable; do
            few=$(count --law "$law" --isa "$isa" --steps 40)
            many=$(count --law "$law" --isa "$isa" --steps 240)
            printf '%s, %s: %d instructions a grain-step\n' "$law" "$isa" $(( (many - few) / (200 * 5000) ))
        done
    done
fi
exit "$failed"
