# Dense packing sheared at constant volume, to time YADE: Hertz-Mindlin (no slip) with friction, E = 70 GPa, nu = 0.3, mu = 0.3.
#
#   PACKING=../../../data/packing-5000.csv yade -j1 -n -x bench.py
#
# Prints "grain-steps per second" of the second run. WARM and STEPS change the numbers of steps (500 and 1000).
import math
import os
import time

packing = os.environ.get("PACKING", "../../../data/packing-5000.csv")
warm, steps = int(os.environ.get("WARM", 500)), int(os.environ.get("STEPS", 1000))

with open(packing) as file:
    box = dict(part.split("=") for part in file.readline().split() if "=" in part)
    file.readline()
    rows = [[float(x) for x in line.split(",")] for line in file if line.strip()]
low = [float(box[k]) for k in ("xlo", "ylo", "zlo")]
high = [float(box[k]) for k in ("xhi", "yhi", "zhi")]

O.materials.append(
    FrictMat(young=70e9, poisson=0.3, density=2650, frictionAngle=math.atan(0.3), label="glass")
)
O.periodic = True
O.cell.setBox(*[h - l for h, l in zip(high, low)])
for _, x, y, z, radius in rows:
    O.bodies.append(sphere((x - low[0], y - low[1], z - low[2]), radius, material="glass"))

O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb()]),
    InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom()],
        [Ip2_FrictMat_FrictMat_MindlinPhys(betan=0.1, betas=0.1)],
        [Law2_ScGeom_MindlinPhys_Mindlin()],
    ),
    NewtonIntegrator(damping=0),
]
O.dt = 3e-8
# Axial compression at 27.5 /s (inertial number 1e-3 at 20 kPa); YADE gives the grains the affine velocities.
O.cell.velGrad = Matrix3(-27.5, 0, 0, 0, 13.75, 0, 0, 0, 13.75)

O.run(warm, True)
start = time.perf_counter()
O.run(steps, True)
seconds = time.perf_counter() - start
stress = getStress()
pressure = -(stress[0, 0] + stress[1, 1] + stress[2, 2]) / 3
real = sum(1 for i in O.interactions if i.isReal)
print(f"pressure {pressure:.0f} Pa, {real} contacts")
print(f"{len(rows) * steps / seconds:.6g} grain-steps per second")
