#!/usr/bin/env python3
"""Least time of the contact stage's instructions on this core; see README.md."""

import argparse
import collections
import os
import re
import subprocess
import sys
import tempfile

FOLLOW = """
import gdb, os, signal, threading, time
gdb.execute("set pagination off")
gdb.execute("starti", to_string=True)
pid = gdb.selected_inferior().pid
def stop():
    time.sleep({seconds})
    os.kill(pid, signal.SIGINT)
threading.Thread(target=stop).start()
gdb.execute("continue", to_string=True)
with open({target!r}, "w") as out:
    for _ in range({steps}):
        gdb.execute("stepi", to_string=True)
        out.write("%x\\n" % (int(gdb.selected_frame().pc())))
gdb.execute("kill")
"""
# Where gdb loads a program that may lie anywhere.
LOADED_AT = 0x555555554000

MAIN = r"""
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
long pass(void *target, void *source, long times);
int main(void) {
    double *from = aligned_alloc(4096, 16384), *to = aligned_alloc(4096, 16384), best = 1e9;
    for (int k = 0; k < 2048; k++) { from[k] = 1.5; to[k] = 1.5; }
    for (int round = 0; round < 100; round++) {
        struct timespec a, b;
        clock_gettime(CLOCK_MONOTONIC, &a);
        if (pass(to, from, 10000) != 0) return 1;
        clock_gettime(CLOCK_MONOTONIC, &b);
        double t = ((b.tv_sec - a.tv_sec) * 1e9 + (b.tv_nsec - a.tv_nsec)) / 10000;
        if (t < best) best = t;
    }
    printf("%g\n", best);
}
"""


def run(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def follow(binary, law, folder):
    """Addresses of the instructions that the benchmark goes through, in their order."""
    target, script = os.path.join(folder, "addresses"), os.path.join(folder, "follow.py")
    with open(script, "w") as f:
        f.write(FOLLOW.format(seconds=6, steps=60000, target=target))
    bench = [binary, "bench", "--only", "dem", "--law", law, "--grains", "5000"]
    bench += ["--seconds", "60", "--threads", "1", "--isa", "avx512"]
    run("gdb", "-q", "-batch", "-x", script, "--args", *bench)
    return [int(line, 16) - LOADED_AT for line in open(target)]


def one_pass(binary, addresses):
    """Mnemonics and operands of the most usual pass of the loop: from one execution of a division to the next."""
    low, high = min(addresses), max(a for a in addresses if a < 1 << 40) + 16
    listing = run("objdump", "-d", "--no-show-raw-insn", f"--start-address={low}", f"--stop-address={high}", binary)
    known = {}
    for line in listing.splitlines():
        m = re.match(r"\s*([0-9a-f]+):\s+(\S+)\s*([^#<]*)", line)
        if m:
            known[int(m[1], 16)] = (m[2], m[3].strip())
    passed = [known.get(a, ("?", "")) for a in addresses]
    divisions = collections.Counter(a for a, p in zip(addresses, passed) if p[0] == "vdivpd" and "zmm" in p[1])
    if not divisions:
        sys.exit("no pass of the contact stage was seen: is this a release build, and has the processor AVX-512?")
    marker = divisions.most_common(1)[0][0]
    at = [k for k, a in enumerate(addresses) if a == marker]
    usual = collections.Counter(b - a for a, b in zip(at, at[1:])).most_common(1)[0][0]
    start = [a for a, b in zip(at, at[1:]) if b - a == usual][-1]
    return passed[start : start + usual]


def kind(m, o):
    """What an instruction is."""
    memory, vector = "(" in o, m[0] == "v"
    if re.match("vf?n?m(add|sub)|vfn?m|vmul", m):
        return "multiplications, fused or not"
    for name, pattern in [("divisions", "vdiv"), ("roots", "vsqrt"), ("comparisons", "vp?cmp|vucom"), ("shuffles", "vunpck|vshuf|vperm|vinsert|vextract")]:
        if re.match(pattern, m):
            return name
    if re.match("vmov", m) and memory:
        return "stores" if o.startswith("%") else "loads"
    if re.match("vp?broadcast", m):
        return "loads"
    if re.match("vmov", m) and "{%k" not in o:
        return "copies of registers"
    if vector:
        return "additions, blends, logic"
    if m[0] == "k":
        return "masks"
    return "jumps" if m[0] == "j" else "whole numbers and addresses"


ARITHMETIC = ["multiplications, fused or not", "divisions", "roots", "comparisons", "additions, blends, logic", "shuffles"]


class Writer:
    """Writes an instruction of the same kind that waits for no other."""

    def __init__(self):
        self.turns = collections.Counter()

    def turn(self, what, count):
        self.turns[what] = (self.turns[what] + 1) % count
        return self.turns[what]

    def line(self, m, o, number):
        memory, mask = "(" in o, "{%k7}" if "{%k" in o else ""
        source, other = f"%zmm{number % 8}", f"%zmm{(number + 3) % 8}"
        into = 8 + self.turn("vector", 24)
        load = f"{64 * self.turn('load', 128)}(%rsi)"
        store = f"{64 * self.turn('store', 128)}(%rdi)"
        k, whole = f"%k{1 + self.turn('mask', 6)}", f"%r{8 + self.turn('whole', 4)}"
        vector = load if memory else source
        if m in ("vmovapd", "vmovupd", "vmovaps", "vmovups"):
            if memory and o.startswith("%"):
                return f"vmovapd {source}, {store}"
            return f"vmovapd {load if memory else source}, %zmm{into}{mask}" if "zmm" in o else f"vmovapd {load}, %ymm{into}"
        if re.match(r"v(add|sub|mul|div|max|min|xor|and|or|unpcklpd|unpckhpd|blendm|fn?m(add|sub))", m) and "zmm" in o:
            return f"{m} {vector}, {other}, %zmm{into}{mask}"
        if m in ("vpsubq", "vpaddq", "vpandq", "vpmuludq", "vpermt2pd"):
            return f"{m} {source}, {other}, %zmm{into}"
        if m in ("vshuff64x2", "vshufpd", "vinsertf64x4"):
            return f"{m} $1, {source.replace('z', 'y') if m == 'vinsertf64x4' else source}, {other}, %zmm{into}"
        if m.startswith("vsqrt"):
            return f"vsqrtpd {source}, %zmm{into}"
        if m.startswith("vcmp"):
            return f"vcmpltpd {vector}, {other}, {k}"
        if m == "vpcmpleud":
            return f"vpcmpleud {load}, %ymm2, {k}"
        if re.match("vp?broadcast", m):
            return f"vbroadcastsd {load}, %zmm{into}"
        if re.match("vps[rl]l", m):
            return f"{m} $1, {source}, %zmm{into}"
        if m.startswith("vadd") and "ymm" in o:
            return f"vaddpd {load if memory else '%ymm1'}, %ymm2, %ymm{into}"
        if m[0] == "v":
            return f"vaddpd %xmm1, %xmm2, %xmm{8 + into % 8}"
        if m[0] == "k" and memory:
            return f"kmovw %k1, {store}" if o.startswith("%k") else f"kmovw {load}, {k}"
        if m.startswith("kmov"):
            return "kmovd %k1, %eax"
        if m.startswith("kortest"):
            return "kortestb %k1, %k1"
        if m[0] == "k":
            return f"knotb %k1, {k}" if m.startswith("knot") else f"{m} %k1, %k2, {k}"
        if m.startswith("prefetch"):
            return f"prefetcht0 {load}"
        if m[0] == "j":
            # Never taken, as nearly all of them.
            return "jo 9f"
        return f"mov {load}, {whole}" if memory else f"lea 8(%rbx), {whole}"


def least(instructions, folder):
    """Nanoseconds of a pass of these instructions when none waits for another."""
    writer = Writer()
    lines = [writer.line(m, o, n) for n, (m, o) in enumerate(instructions)]
    head = [".section .note.GNU-stack,\"\",@progbits", ".text", ".globl pass", "pass:", "push %rbx", "xor %ebx, %ebx", "kxnorb %k7, %k7, %k7"]
    head += [f"vbroadcastsd (%rsi), %zmm{k}" for k in range(32)] + ["1:"]
    tail = ["dec %rdx", "jnz 1b", "9: mov %rdx, %rax", "pop %rbx", "vzeroupper", "ret", ""]
    source, main, program = (os.path.join(folder, name) for name in ("pass.s", "main.c", "pass"))
    with open(source, "w") as f:
        f.write("\n".join(head + lines + tail))
    with open(main, "w") as f:
        f.write(MAIN)
    run("gcc", "-O1", "-o", program, main, source)
    return float(run(program))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--granum", default="target/release/granum")
    parser.add_argument("--law", default="jkr,mindlin-deresiewicz", help="contact laws that are compiled into the loop")
    options = parser.parse_args()
    binary = options.granum
    with tempfile.TemporaryDirectory() as folder:
        passed = one_pass(binary, follow(binary, options.law, folder))
        count = collections.Counter(kind(m, o) for m, o in passed)
        print(f"{len(passed)} instructions for two batches of eight contacts; for one batch:")
        for name, number in count.most_common():
            print(f"  {number / 2:6.1f} {name}")
        arithmetic = [p for p in passed if kind(*p) in ARITHMETIC]
        print(f"at best {least(passed, folder) / 2:.1f} ns a batch, of the arithmetic alone {least(arithmetic, folder) / 2:.1f} ns")


main()
