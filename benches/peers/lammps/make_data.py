"""Turns a packing into a LAMMPS data file: python make_data.py packing.csv packing.data [density, kg/m3]

The packing is a CSV file with the box in its first line and the columns id, x, y, z, radius (m), as
data/packing-5000.csv. Needs nothing but Python.
"""
import csv
import re
import sys

if len(sys.argv) not in (3, 4):
    sys.exit(__doc__)
source, target = sys.argv[1:3]
density = float(sys.argv[3]) if len(sys.argv) > 3 else 2650.0
with open(source) as lines:
    box = dict(re.findall(r"([xyz](?:lo|hi))=(\S+)", next(lines)))
    if len(box) != 6:
        sys.exit(f"{source}: the first line must give xlo, ylo, zlo, xhi, yhi and zhi")
    grains = list(csv.DictReader(lines))
with open(target, "w") as out:
    out.write(f"packing\n\n{len(grains)} atoms\n1 atom types\n\n")
    for axis in "xyz":
        out.write(f"{box[axis + 'lo']} {box[axis + 'hi']} {axis}lo {axis}hi\n")
    out.write("\nAtoms # sphere\n\n")
    for g in grains:
        out.write(f"{g['id']} 1 {2 * float(g['radius']):.17g} {density} {g['x']} {g['y']} {g['z']}\n")
print(f"{target}: {len(grains)} spheres, density {density} kg/m3")
