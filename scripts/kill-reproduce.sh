#!/bin/bash
# Reproduces the paper's case at quick size once in one go and once killed (SIGKILL) again and again at random moments, and
# compares every file that both left (report, summary, figures, runs, networks) but those that hold times. Prints what differs
# and ends with 1 if anything does.
#
#   scripts/kill-reproduce.sh target/release/granum [longest seconds between kills]
set -u
granum=$(realpath "$1")
longest=${2:-10}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 2
"$granum" --json reproduce --quick --out straight > straight.log 2>&1 || { cat straight.log; exit 2; }
kills=0
while true; do
    "$granum" --json reproduce --quick --out killed --checkpoint-every 1 > killed.log 2>&1 &
    process=$!
    sleep "$((RANDOM % longest)).$((RANDOM % 10))5"
    if kill -9 "$process" 2> /dev/null; then
        kills=$((kills + 1))
        wait "$process" 2> /dev/null
    else
        wait "$process" || { cat killed.log; exit 2; }
        break
    fi
done
list() {
    (cd "$1" && find . -type f ! -name seconds.json ! -name speed.html ! -name .granum-lock \
        ! -name checkpoint.previous ! -name checkpoint.refused | sort)
}
status=0
diff <(list straight) <(list killed) || status=1
for file in $(list straight); do
    cmp "straight/$file" "killed/$file" || status=1
done
echo "$kills kills, $(list straight | wc -l) files compared, status $status"
exit $status
