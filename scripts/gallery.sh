#!/usr/bin/env bash
# usage: scripts/gallery.sh GRANUM FOLDER [CASE...]   runs ready cases and copies a figure of each report into docs/src/figures
set -euo pipefail
granum=$(realpath "$1"); folder=$2; shift 2
root=$(cd "$(dirname "$0")/.." && pwd)
figures=$root/docs/src/figures
mkdir -p "$folder" "$figures"
declare -A figure=(
  [paper]='*-stress.svg' [drained-dense]='*-stress.svg' [drained-loose]='*-stress.svg' [undrained-loose]='*-stress-path.svg'
  [undrained-dense]='*-stress-path.svg' [cyclic-undrained]='*-loops.svg' [cyclic-drained]='*-loops.svg'
  [simple-shear]='*-shear.svg' [true-triaxial]='*-deviatoric-plane.svg' [powder-oedometer]='*-compression.svg'
  [wet-grains]='*-stress.svg' [rolling-resistance]='*-stress.svg' [strain-history]='*-stress-path.svg'
)
[ $# -gt 0 ] || set -- $("$granum" --json init --list | tr '{' '\n' | sed -n 's/.*"name":"\([^"]*\)".*/\1/p')
cd "$folder"
for name in "$@"; do
  extra=()
  # The paper's own number of grains and stiffness take some minutes.
  [ "$name" = paper ] && extra=(--set grains.count=1000)
  "$granum" --force init --case "$name" "$name.toml" > /dev/null
  "$granum" --force run "$name.toml" --out "$name" "${extra[@]}"
  "$granum" --force report "$name" > /dev/null
  case $name in
    karlsruhe-dense) test=TMD22 ;;
    karlsruhe-loose) test=TMD2 ;;
    *) test= ;;
  esac
  if [ -n "$test" ]; then
    "$granum" --force compare "$name" "$root/data/lab/karlsruhe-fine-sand-drained.csv" --test "$test" -o "$figures/gallery-$name.svg"
  else
    cp "$(ls "$name"/figures/${figure[$name]} | head -n 1)" "$figures/gallery-$name.svg"
  fi
done
