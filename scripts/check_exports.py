#!/usr/bin/env python3
"""Opens the files that `granum export` writes in the programs for which they are meant, and compares what those programs read with
granum's own tables: numbers of grains and contacts, places, radii, masses, velocities, forces, the cell and its images.

Needs Python with numpy, and any of vtk, pyvista, ovito, ase, gsd with freud (python3 -m venv env; env/bin/pip install numpy vtk
pyvista ovito ase gsd freud-analysis); LAMMPS as `lmp` is used if it is there. What is not installed is passed over by name.

    python3 scripts/check_exports.py RUN [--granum target/release/granum] [--snapshot end] [--picture PICTURE.png]

Of grains of several pieces check_exports_of_bodies.py does the same.

RUN is a run folder, best one with a sheared cell: granum run --path simple-shear --set grains.count=300 --set grains.spread=0.3
"""
import argparse
import csv
import json
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile

import numpy as np

failures = []


def check(name, gap, limit):
    """Prints and notes one comparison: the largest gap, relative to the scale of the quantity, and its limit."""
    gap = float(gap)
    good = gap <= limit
    print(f"  {'ok  ' if good else 'FAIL'} {name}: {gap:.1e} (limit {limit:.0e})")
    if not good:
        failures.append(name)


def table(path):
    with open(path) as file:
        rows = csv.reader(line for line in file if not line.startswith("#"))
        names = next(rows)
        numbers = np.array([[float(x) if x not in ("true", "false") else x == "true" for x in row] for row in rows])
    return {name: numbers[:, k] for k, name in enumerate(names)}


def three(columns, name):
    return np.stack([columns[f"{name}_{axis}"] for axis in "xyz"], axis=1)


class Own:
    """granum's own numbers: its tables and the cell of its snapshot. Columns of `cell` are the edges."""

    def __init__(self, granum, run, snapshot, folder):
        def export(name, *flags):
            subprocess.run([granum, "export", run, "--snapshot", snapshot, *flags, "-o", folder / name], check=True, capture_output=True)
            return folder / name

        grains = table(export("grains.csv", "--table", "grains"))
        if "pieces" in grains:
            sys.exit(f"{run}: its grains are of several pieces, which check_exports_of_bodies.py compares")
        contacts = table(export("contacts.csv", "--table", "contacts"))
        assembly = json.load(open(pathlib.Path(run) / "snapshots" / f"{snapshot}.json"))["assembly"]
        self.cell = np.array(assembly["cell"])
        self.time = assembly["time"]
        self.gradient = np.array(assembly["velocity_gradient"])
        self.id = grains["id"].astype(int)
        self.place, self.velocity = three(grains, "position"), three(grains, "velocity")
        self.spin, self.force = three(grains, "spin"), three(grains, "force")
        self.radius, self.mass = grains["radius"], grains["mass"]
        self.first, self.second = contacts["first"].astype(int), contacts["second"].astype(int)
        self.branch, self.normal = three(contacts, "branch"), three(contacts, "normal")
        self.overlap = contacts["approach"]
        self.normal_force, self.tangential = contacts["normal_force"], three(contacts, "tangential_force")
        self.files = {ending: export(f"instant.{ending}") for ending in ("vtp", "xyz", "gsd", "data")}

    def scale(self):
        return np.abs(self.cell).max()

    def pairs(self):
        """Contacts of spheres that overlap; those with adhesion last a little longer."""
        return {(min(i, j), max(i, j)) for i, j, overlap in zip(self.first, self.second, self.overlap) if overlap > 0}


def images(own, cell, place):
    """Largest distance of places from granum's, up to edges of the cell."""
    apart = np.linalg.solve(cell, (place - own).T)
    return np.abs(cell @ (apart - np.round(apart))).max()


def relative(one, two):
    return np.abs(np.asarray(one) - np.asarray(two)).max() / max(np.abs(two).max(), 1e-300)


def metric(cell):
    """Lengths and angles of a cell, which no rotation changes, of its shortest edges: cells of one lattice have the same."""
    edges = [np.array(edge) for edge in cell.T]
    changed = True
    while changed:
        changed = False
        for i in range(3):
            for j in range(3):
                if i != j:
                    times = round(float(edges[i] @ edges[j] / (edges[j] @ edges[j])))
                    shorter = edges[i] - times * edges[j]
                    if times and shorter @ shorter < (1 - 1e-12) * (edges[i] @ edges[i]):
                        edges[i], changed = shorter, True
    gram = np.array([[a @ b for b in edges] for a in edges])
    return np.sort(np.diag(gram)), abs(np.linalg.det(cell))


def same_lattice(name, own, cell, limit):
    lengths, volume = metric(own.cell)
    other, other_volume = metric(cell)
    check(f"{name}: volume of the cell", abs(other_volume / volume - 1), limit)
    check(f"{name}: edges of the reduced cell", relative(other, lengths), 3 * limit)


def distances(name, own, cell, place, order, limit):
    """Lengths of the branches of granum's contacts, from the places and the cell that another program read."""
    at = {number: k for k, number in enumerate(order)}
    i, j = ([at[number] for number in numbers] for numbers in (own.first, own.second))
    apart = np.linalg.solve(cell, (place[j] - place[i]).T)
    best = np.full(len(i), np.inf)
    base = apart - np.round(apart)
    for n in range(27):
        shift = np.array([n % 3, n // 3 % 3, n // 9])[:, None] - 1.0
        best = np.minimum(best, np.linalg.norm(cell @ (base + shift), axis=0))
    check(f"{name}: lengths of {len(i)} branches across faces and inside", relative(best, np.linalg.norm(own.branch, axis=1)), limit)


def with_vtk(own, picture):
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy

    print("vtk", vtk.vtkVersion.GetVTKVersion(), "reads", own.files["vtp"].name)
    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(str(own.files["vtp"]))
    reader.Update()
    data = reader.GetOutput()
    arrays = {data.GetCellData().GetArrayName(k): vtk_to_numpy(data.GetCellData().GetArray(k)) for k in range(data.GetCellData().GetNumberOfArrays())}
    points = vtk_to_numpy(data.GetPoints().GetData())
    n = len(own.id)
    check("grains and vertices", abs(data.GetNumberOfVerts() - n), 0)
    check("ids", np.abs(arrays["id"][:n] - own.id).max(), 0)
    check("places", relative(points[:n], own.place), 1e-15)
    for name, wanted in (("radius", own.radius), ("mass", own.mass), ("velocity", own.velocity), ("angular_velocity", own.spin), ("force_on_grain", own.force)):
        check(name, relative(arrays[name][:n], wanted), 1e-15)
    lines = np.array([[data.GetCell(n + k).GetPointId(0), data.GetCell(n + k).GetPointId(1)] for k in range(data.GetNumberOfLines())])
    inside = np.linalg.solve(own.cell, points[lines.ravel()].T)
    check("ends of lines outside the cell", max(-inside.min(), inside.max() - 1, 0), 1e-9)
    first, second = arrays["first"][n:].astype(int), arrays["second"][n:].astype(int)
    step = points[lines[:, 1]] - points[lines[:, 0]]
    sums = {}
    for i, j, vector in zip(first, second, step):
        sums[i, j] = sums.get((i, j), 0) + vector
    check("contacts", len(set(sums) ^ set(zip(own.first, own.second))), 0)
    check("branches as sums of their pieces", max(np.abs(sums[i, j] - l).max() for i, j, l in zip(own.first, own.second, own.branch)) / own.scale(), 1e-14)
    print(f"  {data.GetNumberOfLines()} lines for {len(own.first)} contacts")
    forces = dict(zip(zip(own.first, own.second), own.normal_force))
    check("normal forces", max(abs(f - forces[i, j]) for f, i, j in zip(arrays["normal_force"][n:], first, second)), 0)
    field = data.GetFieldData()
    cell = vtk_to_numpy(field.GetArray("cell")).reshape(3, 3).T
    check("cell in the field data", np.abs(cell - own.cell).max(), 0)
    check("time", abs(vtk_to_numpy(field.GetArray("TimeValue"))[0] - own.time), 0)
    if picture:
        draw(vtk, data, arrays, own, picture)


def draw(vtk, data, arrays, own, picture):
    """Grains as spheres and force chains as tubes, as a reader of the book would draw them in ParaView."""
    renderer = vtk.vtkRenderer()
    renderer.SetBackground(1, 1, 1)

    def add(source, color=None, array=None, top=None, opacity=1.0):
        mapper = vtk.vtkPolyDataMapper()
        mapper.SetInputConnection(source.GetOutputPort())
        actor = vtk.vtkActor()
        actor.SetMapper(mapper)
        actor.GetProperty().SetOpacity(opacity)
        if color:
            mapper.ScalarVisibilityOff()
            actor.GetProperty().SetColor(*color)
        else:
            mapper.SetScalarModeToUsePointFieldData()
            mapper.SelectColorArray(array)
            mapper.SetScalarRange(0, top)
        renderer.AddActor(actor)

    parts = {}
    for name, low in (("grains", -0.5), ("lines", 0.5)):
        threshold = vtk.vtkThreshold()
        threshold.SetInputData(data)
        threshold.SetInputArrayToProcess(0, 0, 0, 1, "is_contact")
        threshold.SetLowerThreshold(low)
        threshold.SetUpperThreshold(low + 1)
        parts[name] = vtk.vtkGeometryFilter()
        parts[name].SetInputConnection(threshold.GetOutputPort())
    ball = vtk.vtkSphereSource()
    ball.SetRadius(1.0)
    ball.SetThetaResolution(20)
    ball.SetPhiResolution(20)
    glyph = vtk.vtkGlyph3D()
    glyph.SetInputConnection(parts["grains"].GetOutputPort())
    glyph.SetSourceConnection(ball.GetOutputPort())
    glyph.SetInputArrayToProcess(0, 0, 0, 0, "radius")
    glyph.SetScaleModeToScaleByScalar()
    glyph.SetScaleFactor(1.0)
    add(glyph, color=(0.55, 0.65, 0.8), opacity=0.25)
    tube = vtk.vtkTubeFilter()
    tube.SetInputConnection(parts["lines"].GetOutputPort())
    tube.SetInputArrayToProcess(0, 0, 0, 0, "normal_force")
    tube.SetVaryRadiusToVaryRadiusByAbsoluteScalar()
    tube.SetNumberOfSides(12)
    calculator = vtk.vtkArrayCalculator()
    calculator.SetInputConnection(parts["lines"].GetOutputPort())
    calculator.AddScalarArrayName("normal_force")
    largest = own.normal_force.max()
    calculator.SetFunction(f"{0.5 * own.radius.mean() / largest}*normal_force")
    calculator.SetResultArrayName("thickness")
    tube.SetInputConnection(calculator.GetOutputPort())
    tube.SetInputArrayToProcess(0, 0, 0, 0, "thickness")
    add(tube, array="normal_force", top=0.6 * largest)
    points, order = vtk.vtkPoints(), [0, 1, 3, 2, 6, 7, 5, 4]
    for n in range(8):
        points.InsertNextPoint(own.cell @ np.array([n % 2, n // 2 % 2, n // 4]))
    edges = vtk.vtkCellArray()
    for a in range(8):
        for bit in (1, 2, 4):
            if not a & bit:
                line = vtk.vtkLine()
                line.GetPointIds().SetId(0, a)
                line.GetPointIds().SetId(1, a | bit)
                edges.InsertNextCell(line)
    frame = vtk.vtkPolyData()
    frame.SetPoints(points)
    frame.SetLines(edges)
    box = vtk.vtkTrivialProducer()
    box.SetOutput(frame)
    add(box, color=(0, 0, 0))
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetSize(900, 700)
    window.AddRenderer(renderer)
    renderer.GetActiveCamera().SetPosition(0.6, 0.5, 3)
    renderer.ResetCamera()
    window.Render()
    image = vtk.vtkWindowToImageFilter()
    image.SetInput(window)
    writer = vtk.vtkPNGWriter()
    writer.SetFileName(picture)
    writer.SetInputConnection(image.GetOutputPort())
    writer.Write()
    print("  wrote", picture)


def with_ovito(own):
    import ovito
    from ovito.io import import_file
    from ovito.modifiers import CreateBondsModifier

    exact = {"xyz": 1e-15, "gsd": 3e-7, "data": 1e-14}
    for ending, limit in exact.items():
        print("ovito", ovito.version_string, "reads", own.files[ending].name)
        flags = {"atom_style": "sphere"} if ending == "data" else {}
        data = import_file(str(own.files[ending]), **flags).compute()
        particles = data.particles
        check("number of grains", abs(particles.count - len(own.id)), 0)
        ids = np.array(particles["Particle Identifier"]) if "Particle Identifier" in particles else own.id
        order = np.argsort(ids)
        cell = np.array(data.cell[:, :3])
        check("periodic on all sides", 3 - sum(data.cell.pbc), 0)
        same_lattice("cell", own, cell, max(limit, 1e-14))
        if ending == "xyz":
            check("edges of the cell", relative(cell, own.cell), 1e-15)
        place = np.array(particles.positions)[order]
        distances("places", own, cell, place, np.sort(ids), max(10 * limit, 1e-13))
        # OVITO holds radii in single precision.
        check("radii", relative(np.array(particles["Radius"])[order], own.radius), 3e-7)
        if "Mass" in particles:
            check("masses", relative(np.array(particles["Mass"])[order], own.mass), max(limit, 1e-13))
        speed = np.linalg.norm(np.array(particles["Velocity"])[order], axis=1)
        whole = own.velocity + (own.gradient @ own.place.T).T if ending == "data" else own.velocity
        check("speeds", relative(speed, np.linalg.norm(whole, axis=1)), max(limit, 1e-12))
        if ending == "xyz":
            check("velocities", relative(np.array(particles["Velocity"])[order], own.velocity), 1e-15)
            check("forces", relative(np.array(particles["Force"])[order], own.force), 1e-15)
        # Spheres that overlap are its own search over the periodic cell.
        numbers = np.sort(ids)
        bonds = bond_pairs(CreateBondsModifier, data, order, numbers, own)
        check(f"pairs of spheres that overlap and are none of granum's {len(own.pairs())}, or the other way round", len(bonds ^ own.pairs()), 0)


def bond_pairs(modifier, data, order, numbers, own):
    data.apply(modifier(cutoff=float(2.001 * own.radius.max())))
    bonds = data.particles.bonds
    topology, image = np.array(bonds.topology), np.array(bonds["Periodic Image"])
    cell, place = np.array(data.cell[:, :3]), np.array(data.particles.positions)
    apart = place[topology[:, 1]] - place[topology[:, 0]] + (cell @ image.T).T
    back = np.argsort(order)
    pairs = set()
    for (a, b), distance in zip(topology, np.linalg.norm(apart, axis=1)):
        i, j = numbers[back[a]], numbers[back[b]]
        known = (min(i, j), max(i, j))
        reach = own.radius[i - 1] + own.radius[j - 1]
        # Single precision may lose a touch of less than a millionth of a diameter.
        if distance < reach * (1 - 1e-6) or (distance < reach * (1 + 1e-6) and known in own.pairs()):
            pairs.add(known)
    return pairs


def with_gsd(own):
    import gsd
    import gsd.hoomd

    print("gsd", gsd.version.version, "reads", own.files["gsd"].name)
    with gsd.hoomd.open(str(own.files["gsd"]), "r") as file:
        frame = file[0]
        check("number of instants", abs(len(file) - 1), 0)
    lx, ly, lz, xy, xz, yz = [float(x) for x in frame.configuration.box]
    cell = np.array([[lx, xy * ly, xz * lz], [0, ly, yz * lz], [0, 0, lz]])
    same_lattice("cell", own, cell, 3e-7)
    place = np.array(frame.particles.position, dtype=float)
    check("places outside the box", max(np.abs(np.linalg.solve(cell, place.T)).max() - 0.5, 0), 1e-6)
    distances("places", own, cell, place, own.id, 3e-6)
    check("diameters", relative(frame.particles.diameter / 2, own.radius), 1e-7)
    check("masses", relative(frame.particles.mass, own.mass), 1e-7)
    check("speeds", relative(np.linalg.norm(frame.particles.velocity, axis=1), np.linalg.norm(own.velocity, axis=1)), 1e-6)
    return frame


def with_freud(own):
    import freud

    print("freud", freud.__version__, "takes the frame of gsd")
    frame = with_gsd(own)
    box = freud.box.Box.from_box(frame.configuration.box)
    check("volume", abs(box.volume / abs(np.linalg.det(own.cell)) - 1), 1e-6)
    query = freud.locality.AABBQuery(box, frame.particles.position)
    found = query.query(frame.particles.position, {"r_max": float(2.001 * own.radius.max()), "exclude_ii": True}).toNeighborList()
    radius = np.array(frame.particles.diameter, dtype=float) / 2
    pairs = set()
    for a, b, distance in zip(found.query_point_indices, found.point_indices, found.distances):
        known = (min(own.id[a], own.id[b]), max(own.id[a], own.id[b]))
        reach = radius[a] + radius[b]
        if distance < reach * (1 - 1e-6) or (distance < reach * (1 + 1e-6) and known in own.pairs()):
            pairs.add(known)
    check(f"pairs of spheres that overlap and are none of granum's {len(own.pairs())}, or the other way round", len(pairs ^ own.pairs()), 0)


def with_ase(own):
    import ase
    import ase.io

    print("ase", ase.__version__, "reads", own.files["xyz"].name)
    atoms = ase.io.read(own.files["xyz"])
    check("number of grains", abs(len(atoms) - len(own.id)), 0)
    check("edges of the cell", relative(np.array(atoms.cell).T, own.cell), 1e-15)
    check("places", relative(atoms.positions, own.place), 1e-15)
    check("radii", relative(atoms.arrays["radius"], own.radius), 1e-15)
    check("forces", relative(atoms.arrays["force"], own.force), 1e-15)


def with_pyvista(own):
    import pyvista

    print("pyvista", pyvista.__version__, "reads", own.files["vtp"].name)
    mesh = pyvista.read(own.files["vtp"])
    check("vertices", abs(mesh.n_verts - len(own.id)), 0)
    check("lines less than contacts", max(len(own.first) - mesh.n_lines, 0), 0)
    check("time", abs(float(mesh.field_data["TimeValue"][0]) - own.time), 0)


def with_lammps(own, folder):
    script = f"""
units si
atom_style sphere
boundary p p p
box tilt large
read_data {own.files["data"].name}
neighbor {0.2 * own.radius.max()} bin
pair_style zero {2.1 * own.radius.max()}
pair_coeff * *
comm_modify vel yes
variable d atom 2*radius
compute each all property/atom radius
compute r all reduce max c_each
thermo_style custom atoms vol xy xz yz lx ly lz c_r
run 0
print "GRANUM $(atoms) $(vol:%.17g) $(lx:%.17g) $(ly:%.17g) $(lz:%.17g) $(xy:%.17g) $(xz:%.17g) $(yz:%.17g) $(c_r:%.17g)"
write_dump all custom read.dump id radius mass x y z vx vy vz omegax omegay omegaz modify sort id format float %.17g
"""
    (folder / "in.read").write_text(script)
    done = subprocess.run(["lmp", "-in", "in.read", "-log", "none"], cwd=folder, capture_output=True, text=True)
    line = next((line for line in done.stdout.splitlines() if line.startswith("GRANUM")), None)
    print("lmp reads", own.files["data"].name)
    if line is None:
        print(done.stdout[-1500:])
        failures.append("lmp")
        return
    atoms, volume, lx, ly, lz, xy, xz, yz, radius = [float(x) for x in line.split()[1:]]
    cell = np.array([[lx, xy, xz], [0, ly, yz], [0, 0, lz]])
    check("number of atoms", abs(atoms - len(own.id)), 0)
    same_lattice("cell", own, cell, 1e-14)
    check("largest radius", abs(radius / own.radius.max() - 1), 1e-15)
    rows = (folder / "read.dump").read_text().splitlines()
    start = next(k for k, line in enumerate(rows) if line.startswith("ITEM: ATOMS"))
    numbers = np.array([[float(x) for x in row.split()] for row in rows[start + 1 :]])
    distances("places", own, cell, numbers[:, 3:6], own.id, 1e-13)
    check("masses", relative(numbers[:, 2], own.mass), 1e-14)
    whole = own.velocity + (own.gradient @ own.place.T).T
    check("speeds", relative(np.linalg.norm(numbers[:, 6:9], axis=1), np.linalg.norm(whole, axis=1)), 1e-13)
    check("spins", relative(np.linalg.norm(numbers[:, 9:12], axis=1), np.linalg.norm(own.spin, axis=1)), 1e-13)


def with_each(readers):
    """Lets each reader check whose module is installed, and names the others."""
    for module, use in readers:
        try:
            __import__(module)
        except ImportError as error:
            print(f"{module} is not used: {error}")
            continue
        use()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run")
    parser.add_argument("--granum", default="granum")
    parser.add_argument("--snapshot", default="end")
    parser.add_argument("--picture", help="also draw the VTP file, off screen, to this PNG file")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        own = Own(options.granum, options.run, options.snapshot, folder)
        print(f"{len(own.id)} grains, {len(own.first)} contacts, cell\n{own.cell}")
        with_each((
            ("vtk", lambda: with_vtk(own, options.picture)),
            ("pyvista", lambda: with_pyvista(own)),
            ("ase", lambda: with_ase(own)),
            ("ovito", lambda: with_ovito(own)),
            ("freud", lambda: with_freud(own)),
        ))
        if shutil.which("lmp"):
            with_lammps(own, folder)
        else:
            print("lmp is not there")
    print("all agree" if not failures else f"{len(failures)} comparisons failed: {', '.join(failures)}")
    sys.exit(bool(failures))


if __name__ == "__main__":
    main()
