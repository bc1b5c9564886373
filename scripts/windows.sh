#!/usr/bin/env bash
# Shows that the program for Windows gives the bits of the machine at hand: cross-builds granum for x86_64-pc-windows-gnu, runs it by wine,
# and compares runs of all kinds, predictions of the shipped families, a training, a campaign that is killed and resumed, and names of
# files that Windows does not like, with the native program.
#
# Needs (Debian): apt-get install gcc-mingw-w64-x86-64 wine64; rustup target add x86_64-pc-windows-gnu
# Usage: scripts/windows.sh [--quick] [--release]
#   --quick    only the engine: short runs with six sets of laws on every instruction set, what CI has time for
#   --release  programs as they are shipped instead of those of the profile dev, whose engine is optimised as well: longer to build
# Exit code 77 where mingw-w64 or wine is missing.
set -euo pipefail
cd "$(dirname "$0")/.."
root=$PWD
quick=; profile=dev; built=debug
for option in "$@"; do
    case $option in
        --quick) quick=1 ;;
        --release) profile=release; built=release ;;
        *) echo "unknown option $option: --quick, --release"; exit 2 ;;
    esac
done
target=x86_64-pc-windows-gnu
wine=$(command -v wine64 || ls /usr/lib/wine/wine64 2> /dev/null || true)
for need in "${wine:-wine64}" x86_64-w64-mingw32-gcc; do
    command -v "$need" > /dev/null || { echo "$need is missing: apt-get install gcc-mingw-w64-x86-64 wine64"; exit 77; }
done
rustup target add "$target" > /dev/null 2>&1 || rustc --print target-libdir --target "$target" | xargs ls > /dev/null 2>&1 \
    || { echo "the standard library for $target cannot be had here"; exit 77; }
export CARGO_TARGET_X86_64_PC_WINDOWS_GNU_LINKER=x86_64-w64-mingw32-gcc CARGO_TARGET_X86_64_PC_WINDOWS_GNU_RUNNER=$wine

what=(--package granum)
if [ -n "$quick" ]; then what=(--package granum-dem --example bits); fi
cargo build --profile "$profile" --locked "${what[@]}"
cargo build --profile "$profile" --locked "${what[@]}" --target "$target"
folder=$(realpath "${CARGO_TARGET_DIR:-target}")
out=$(mktemp -d)
export WINEPREFIX=$out/wine WINEDEBUG=-all WINEDLLOVERRIDES="mscoree,mshtml="
end() { "${wine%/*}/wineserver" -k > /dev/null 2>&1 || wineserver -k > /dev/null 2>&1 || true; rm -rf "$out"; }
trap end EXIT
mkdir "$out/bin"
program=granum
if [ -n "$quick" ]; then program=examples/bits; fi
native=$folder/$built/$program
cp "$folder/$target/$built/$program.exe" "$out/bin/program.exe"
foreign=("$wine" "$out/bin/program.exe")

# Wine 8 lacks this library, from which Rust takes random numbers for its hash maps; every Windows since 8 has it.
library() {
    x86_64-w64-mingw32-gcc -shared -O1 -o "$1" -x c - -ladvapi32 <<'C'
#include <windows.h>
BOOLEAN NTAPI SystemFunction036(PVOID, ULONG);
__declspec(dllexport) BOOL WINAPI ProcessPrng(PBYTE data, SIZE_T length) {
    while (length) {
        ULONG part = length > 65536 ? 65536 : (ULONG)length;
        SystemFunction036(data, part);
        data += part;
        length -= part;
    }
    return TRUE;
}
C
}
library "$out/bin/bcryptprimitives.dll"
"$wine" wineboot --init > /dev/null 2>&1 || true

if [ -n "$quick" ]; then
    "$native" > "$out/here"
    "${foreign[@]}" | tr -d '\r' > "$out/there"
    cat "$out/there"
    diff "$out/here" "$out/there" || { echo "DIFFERENT: < here, > Windows"; exit 1; }
    echo "same"
    exit
fi
"${foreign[@]}" --version

failed=0
# What, and two texts or files that must be equal.
compare() {
    local word=same
    [ -n "$2" ] && [ "$2" = "$3" ] || { word=DIFFERENT; failed=1; }
    printf '%-9s %.16s  %s\n' "$word" "$2" "$1"
}
cd "$out"
digest() { "$native" digest "$1" | cut -d" " -f1; }
hash() { sha256sum < "$1" | cut -d" " -f1; }

# A run of a case here and there, with the same options.
run() {
    local name=$1; shift
    rm -rf here there
    "$native" run "$@" -o here --threads 1 > here.log 2>&1 || { cat here.log; exit 1; }
    "${foreign[@]}" run "$@" -o there --threads 2 > there.log 2>&1 || { cat there.log; exit 1; }
    compare "$name" "$(digest here)" "$(digest there)"
}

# Sets of laws: the compiled ones, and two that run through slots.
cat > laws.toml <<'TOML'
[grains]
count = 60
[preparation]
solid_fraction = "none"
[shear]
deviator_strain = 0.01
inertial_number = 1e-2
[recording]
states = 5
observations_per_state = 2
TOML
while read -r normal tangential rolling spread; do
    keys=(--set "contact.normal=$normal" --set "contact.tangential=$tangential" --set "contact.rolling=$rolling" --set "grains.spread=$spread")
    run "run, $normal $tangential $rolling, spread $spread" laws.toml "${keys[@]}"
done <<'CASES'
hertz mindlin-deresiewicz none 0
hertz no-slip none 0.3
jkr mindlin-deresiewicz none 0.3
jkr no-slip none 0
jkr peeling none 0.3
hooke no-slip none 0.3
hertz no-slip elastic-plastic 0.3
CASES

# Sixteen cases of all kinds: undrained, cyclic, powders, wet and rolling grains, several materials. Their digests are those of the tests.
cases=$root/crates/granum/tests/end_to_end/sixteen_cases
while read -r expected case; do
    cp "$cases/$case.toml" .
    "${foreign[@]}" run "$case.toml" -o "there-$case" > there.log 2>&1 || { cat there.log; exit 1; }
    compare "run, $case" "$expected" "$(digest "there-$case")"
done < "$cases/digests.txt"

# Without vector instructions single numbers and lanes are fused one by one.
for isa in portable avx2; do
    "${foreign[@]}" run drained-triaxial.toml -o "there-$isa" --isa "$isa" > there.log 2>&1 || { cat there.log; exit 1; }
    compare "run, drained-triaxial, $isa" "$(digest there-drained-triaxial)" "$(digest "there-$isa")"
done

# A prediction of each family.
for family in sand powder; do
    case $family in
        sand) keys=(--friction 0.4 --rolling-friction 0.2 --pressure "100 kPa" --youngs-modulus "2 GPa" --void-ratio 0.7) ;;
        powder) keys=(--friction 0.3 --pressure "5 kPa" --youngs-modulus "100 MPa" --interface-energy "2 mJ/m2" --diameter "10 um") ;;
    esac
    "$native" predict --family "$family" "${keys[@]}" -o "here-$family.csv" > here.log 2>&1 || { cat here.log; exit 1; }
    "${foreign[@]}" predict --family "$family" "${keys[@]}" -o "there-$family.csv" > there.log 2>&1 || { cat there.log; exit 1; }
    compare "prediction of the family $family" "$(hash "here-$family.csv")" "$(hash "there-$family.csv")"
done

# A training on two of the runs.
train() {
    local study=$1; shift
    "$@" train -o "$study" there-drained-triaxial there-undrained-triaxial --input deviator_strain --input mean_stress --output stress_ratio \
        --hidden 4 --threads 1 > train.log 2>&1 || { cat train.log; exit 1; }
}
train here-study "$native"
train there-study "${foreign[@]}"
for model in feed-forward ridge mean-curve; do
    compare "training, $model" "$(hash "here-study/stress_ratio-$model.json")" "$(hash "there-study/stress_ratio-$model.json")"
done

# A campaign that is killed when its first run is finished, and resumed.
cat > plan.toml <<'TOML'
case = "drained-triaxial.toml"
[design]
kind = "sobol"
points = 4
[[variable]]
name = "friction"
key = "grains.material.friction"
from = 0.2
to = 0.8
TOML
"$native" campaign plan.toml -o here-campaign > here.log 2>&1 || { cat here.log; exit 1; }
setsid "${foreign[@]}" campaign plan.toml -o there-campaign > there.log 2>&1 &
campaign=$!
for _ in $(seq 600); do
    if compgen -G 'there-campaign/tests/*/run.json' > /dev/null; then break; fi
    sleep 0.05
done
kill -9 -- "-$campaign" 2> /dev/null || true
wait "$campaign" 2> /dev/null || true
finished=$(ls there-campaign/tests/*/run.json | wc -l)
"${foreign[@]}" resume there-campaign > there.log 2>&1 || { cat there.log; exit 1; }
for test in here-campaign/tests/*; do
    compare "run ${test##*/} of a campaign killed after $finished of 4" "$(digest "$test")" "$(digest "there-${test#here-}")"
done

# Names: the program does it under this very name, or refuses it.
name() {
    local word=refused
    if "${foreign[@]}" run laws.toml -o "$1" --set contact.tangential=no-slip > name.log 2>&1; then
        word=works
        [ -e "$1/run.json" ] || { word="LOST"; failed=1; }
    elif ! grep -q "^error" name.log && ! grep -q "×" name.log; then
        word="NO ERROR"; failed=1
    fi
    printf '%-9s a folder named %.60s\n' "$word" "\"$1\""
    if [ "$word" = refused ]; then head -3 name.log | sed 's/^/          /'; fi
}
for reserved in CON NUL com1 aux.txt 'ends.' 'ends ' 'a:b' 'question?' "$(printf 'long-%.0s' {1..40})/$(printf 'path-%.0s' {1..40})"; do
    name "$reserved"
done

cd - > /dev/null
library "$folder/$target/$built/deps/bcryptprimitives.dll"
cargo test --locked --package granum-simd --lib --target "$target"
exit "$failed"
