#!/usr/bin/env python3
"""Opens the files that `granum export` writes of grains of several pieces in the programs for which they are meant, as check_exports.py does for
spheres: pieces with their bodies, orientations, masses, velocities, contacts between bodies, and the glyphs of ParaView's library.

Needs Python with numpy and pyarrow, and any of vtk, pyvista, ovito, ase, gsd with freud (python3 -m venv env; env/bin/pip install numpy pyarrow vtk
pyvista ovito ase gsd freud-analysis); LAMMPS with its package RIGID is used as `lmp` if it is there. What is not installed is passed over by name.

    python3 scripts/check_exports_of_bodies.py RUN [--granum target/release/granum] [--snapshot end] [--picture PICTURE.png]

RUN is a run folder, best one with a sheared cell and with grains whose three moments of inertia differ, so that every rotation of their own axes
is seen; the glyphs are looked at where all grains have one shape:

    [grains]
    count = 200
    spread = 0.3
    shape = { kind = "pieces", spheres = [[0, 0, 0, 1], [1, 0, 0, 0.8], [0, 1, 0, 0.6]] }
    ...
    [[stage]]
    path = "simple-shear"
    shear_strain = 0.3
"""
import argparse
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

import numpy as np
import pyarrow.parquet

import check_exports
from check_exports import check, failures, images, relative, same_lattice, table, three


def rotations(quaternions):
    """The matrices of quaternions w, x, y, z."""
    w, x, y, z = np.asarray(quaternions, dtype=float).T
    rows = [[w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z]]
    return np.moveaxis(np.array(rows), 2, 0)


class Own:
    """granum's own numbers: its tables of bodies and contacts, and the pieces of its snapshot. Columns of `cell` are the edges."""

    def __init__(self, granum, run, snapshot, folder):
        def export(name, *flags):
            subprocess.run([granum, "export", run, "--snapshot", snapshot, *flags, "-o", folder / name], check=True, capture_output=True)
            return folder / name

        grains = table(export("grains.csv", "--table", "grains"))
        contacts = table(export("contacts.csv", "--table", "contacts"))
        snapshots = pathlib.Path(run) / "snapshots"
        assembly = json.load(open(snapshots / f"{snapshot}.json"))["assembly"]
        self.cell, self.time = np.array(assembly["cell"]), assembly["time"]
        self.gradient = np.array(assembly["velocity_gradient"])
        self.id, self.count = grains["id"].astype(int), grains["pieces"].astype(int)
        self.place, self.velocity, self.spin = three(grains, "position"), three(grains, "velocity"), three(grains, "spin")
        self.radius, self.mass = grains["radius"], grains["mass"]
        self.orientation = np.stack([grains[f"orientation_{axis}"] for axis in "wxyz"], axis=1)
        self.inertia = np.stack([grains[f"principal_inertia_{k}"] for k in (1, 2, 3)], axis=1)
        pieces = {name: np.array(column) for name, column in pyarrow.parquet.read_table(snapshots / f"{snapshot}.pieces.parquet").to_pydict().items()}
        # The number of each piece's body in the tables above.
        at = {number: k for k, number in enumerate(self.id)}
        self.body = np.array([at[number] for number in pieces["grain"]])
        self.piece_place, self.arm, self.piece_radius = three(pieces, "position"), three(pieces, "arm"), pieces["radius"]
        self.piece_velocity = self.velocity[self.body] + np.cross(self.spin[self.body], self.arm)
        self.whole_velocity = self.piece_velocity + self.place[self.body] @ self.gradient.T
        starts = np.concatenate([[0], np.cumsum(self.count)[:-1]])
        first = starts[[at[int(number)] for number in contacts["first"]]] + contacts["first_piece"].astype(int)
        second = starts[[at[int(number)] for number in contacts["second"]]] + contacts["second_piece"].astype(int)
        self.first, self.second, self.overlap = first, second, contacts["approach"]
        self.normal, self.normal_force = three(contacts, "normal"), contacts["normal_force"]
        self.files = {ending: export(f"instant.{ending}") for ending in ("vtp", "xyz", "gsd", "data", "dump")}
        self.files["bodies"] = export("bodies.vtp", "--to", "vtp-bodies")

    def pairs(self):
        """Pieces of two bodies that overlap, by their numbers from 0."""
        return {(min(i, j), max(i, j)) for i, j, overlap in zip(self.first, self.second, self.overlap) if overlap > 0}

    def sum_of(self, values):
        """The sum over the pieces of each body."""
        sums = np.zeros(len(self.id))
        np.add.at(sums, self.body, values)
        return sums


def shapes(name, own, cell, place, quaternions, limit):
    """The pieces of each body, in the axes of the orientation that a program read, are those of granum: arms and orientation fit together."""
    first = np.concatenate([[0], np.cumsum(own.count)[:-1]])[own.body]
    apart = np.linalg.solve(cell, (place - place[first]).T)
    arms = (cell @ (apart - np.round(apart))).T
    middle = np.zeros((len(own.id), 3))
    np.add.at(middle, own.body, arms)
    arms -= (middle / own.count[:, None])[own.body]
    wanted = np.zeros((len(own.id), 3))
    np.add.at(wanted, own.body, own.arm)
    own_arms = own.arm - (wanted / own.count[:, None])[own.body]
    inside = np.einsum("kji,kj->ki", rotations(quaternions), arms)
    wanted = np.einsum("kji,kj->ki", rotations(own.orientation)[own.body], own_arms)
    check(f"{name}: pieces in the axes of their body", relative(inside, wanted), limit)


def overlapping(own, cell, place, pairs):
    """Of pairs of pieces those of two bodies that overlap, but for what rounding decides."""
    found, known = set(), own.pairs()
    for a, b in pairs:
        pair = (min(a, b), max(a, b))
        if own.body[a] == own.body[b] or pair in found:
            continue
        apart = np.linalg.solve(cell, place[b] - place[a])
        distance = np.linalg.norm(cell @ (apart - np.round(apart)))
        reach = own.piece_radius[a] + own.piece_radius[b]
        if distance < reach * (1 - 1e-6) or (distance < reach * (1 + 1e-6) and pair in known):
            found.add(pair)
    return found


def with_vtk(own, picture):
    import vtk
    vtk.vtkLogger.SetStderrVerbosity(vtk.vtkLogger.VERBOSITY_ERROR)
    from vtk.util.numpy_support import vtk_to_numpy

    def read(file):
        reader = vtk.vtkXMLPolyDataReader()
        reader.SetFileName(str(file))
        reader.Update()
        data = reader.GetOutput()
        named = {kind: {of.GetArrayName(k): vtk_to_numpy(of.GetArray(k)) for k in range(of.GetNumberOfArrays())}
                 for kind, of in (("cells", data.GetCellData()), ("points", data.GetPointData()))}
        return data, named, vtk_to_numpy(data.GetPoints().GetData())

    print("vtk", vtk.vtkVersion.GetVTKVersion(), "reads", own.files["vtp"].name, "and", own.files["bodies"].name)
    data, named, points = read(own.files["vtp"])
    n, cells = len(own.body), named["cells"]
    check("vertices are pieces", abs(data.GetNumberOfVerts() - n), 0)
    check("bodies of pieces", np.abs(cells["body"][:n] - own.id[own.body]).max(), 0)
    check("bodies of the points of pieces", np.abs(named["points"]["body"][:n] - own.id[own.body]).max(), 0)
    check("places of pieces", images(own.piece_place, own.cell, points[:n]) / np.abs(own.cell).max(), 1e-15)
    check("radii of pieces", relative(cells["radius"][:n], own.piece_radius), 1e-15)
    check("masses of bodies as sums over pieces", relative(own.sum_of(cells["mass"][:n]), own.mass), 1e-13)
    check("masses of bodies", relative(cells["body_mass"][:n], own.mass[own.body]), 1e-15)
    # Less the field of the cell at the centre of the body, as that of the body itself.
    check("velocities of pieces", relative(cells["velocity"][:n], own.piece_velocity), 1e-12)
    check("spins", relative(cells["angular_velocity"][:n], own.spin[own.body]), 1e-15)
    lines = {(min(i, j) - 1, max(i, j) - 1) for i, j in zip(cells["first"][n:].astype(int), cells["second"][n:].astype(int))}
    contacts = {(min(i, j), max(i, j)) for i, j in zip(own.first, own.second)}
    check(f"lines that are none of {len(contacts)} contacts of pieces, or the other way round", len(lines ^ contacts), 0)
    bodies, named, points = read(own.files["bodies"])
    about = named["points"]
    check("points are bodies", abs(bodies.GetNumberOfPoints() - len(own.id)), 0)
    check("ids of bodies", np.abs(about["id"] - own.id).max(), 0)
    check("centres of bodies", relative(points, own.place), 1e-15)
    for name, wanted in (("orientation", own.orientation), ("mass", own.mass), ("principal_inertia", own.inertia), ("velocity", own.velocity),
                         ("angular_velocity", own.spin), ("radius", own.radius), ("pieces", own.count)):
        check(f"{name} of bodies", relative(about[name], wanted), 1e-15)
    glyphs(vtk, own, bodies, picture)


def glyphs(vtk, own, bodies, picture):
    """One grain as glyph, turned by the quaternions of the file and scaled by its radii, gives the picture of all pieces as spheres."""
    scaled = np.einsum("kji,kj->ki", rotations(own.orientation)[own.body], own.arm) / own.radius[own.body, None]
    form = np.concatenate([scaled, (own.piece_radius / own.radius[own.body])[:, None]], axis=1)
    starts = np.concatenate([[0], np.cumsum(own.count)[:-1]])
    if len(set(own.count)) > 1 or max(np.abs(form[s : s + own.count[0]] - form[: own.count[0]]).max() for s in starts) > 1e-6:
        print("  the grains are of several shapes: one glyph does not show them")
        return

    def ball(centre, radius):
        source = vtk.vtkSphereSource()
        source.SetCenter(*centre)
        source.SetRadius(radius)
        source.SetThetaResolution(24)
        source.SetPhiResolution(24)
        return source

    def balls(rows):
        together = vtk.vtkAppendPolyData()
        for x, y, z, radius in rows:
            source = ball((x, y, z), radius)
            source.Update()
            together.AddInputData(source.GetOutput())
        return together

    def picture_of(mapper):
        actor = vtk.vtkActor()
        actor.SetMapper(mapper)
        # Flat white on black: the picture is where grains are, which no facet of a sphere changes by much.
        actor.GetProperty().SetColor(1, 1, 1)
        actor.GetProperty().SetLighting(0)
        actor.GetProperty().SetColor(1, 1, 1)
        renderer = vtk.vtkRenderer()
        renderer.SetBackground(0, 0, 0)
        renderer.AddActor(actor)
        window = vtk.vtkRenderWindow()
        window.SetOffScreenRendering(1)
        window.SetMultiSamples(0)
        window.SetSize(700, 700)
        window.AddRenderer(renderer)
        middle, reach = own.cell.sum(axis=1) / 2, np.linalg.norm(own.cell.sum(axis=1))
        camera = renderer.GetActiveCamera()
        camera.SetFocalPoint(*middle)
        camera.SetPosition(*(middle + reach * np.array([0.4, -1.6, 0.7])))
        camera.SetViewUp(0, 0, 1)
        renderer.ResetCameraClippingRange()
        window.Render()
        image = vtk.vtkWindowToImageFilter()
        image.SetInput(window)
        image.ReadFrontBufferOff()
        image.Update()
        from vtk.util.numpy_support import vtk_to_numpy

        return image, vtk_to_numpy(image.GetOutput().GetPointData().GetScalars())[:, 0] > 127

    # A thin sample, so that grains are seen one by one and not as one silhouette.
    shown = np.arange(len(own.id)) % max(len(own.id) // 20, 1) == 0
    few = vtk.vtkPolyData()
    points, keep = vtk.vtkPoints(), vtk.vtkIdList()
    points.SetDataTypeToDouble()
    data = few.GetPointData()
    data.CopyAllocate(bodies.GetPointData())
    for k in np.flatnonzero(shown):
        data.CopyData(bodies.GetPointData(), int(k), points.InsertNextPoint(bodies.GetPoint(int(k))))
    few.SetPoints(points)
    mapper = vtk.vtkGlyph3DMapper()
    mapper.SetInputData(few)
    glyph = balls(form[: own.count[0]])
    mapper.SetSourceConnection(glyph.GetOutputPort())
    mapper.SetOrientationArray("orientation")
    mapper.SetOrientationModeToQuaternion()
    mapper.SetScaleArray("radius")
    mapper.SetScaleModeToScaleByMagnitude()
    mapper.ScalingOn()
    mapper.ScalarVisibilityOff()
    image, turned = picture_of(mapper)
    whole = vtk.vtkPolyDataMapper()
    on = shown[own.body]
    places = own.place[own.body][on] + own.arm[on]
    pieces = balls(np.concatenate([places, own.piece_radius[on][:, None]], axis=1))
    whole.SetInputConnection(pieces.GetOutputPort())
    whole.ScalarVisibilityOff()
    _, spheres = picture_of(whole)
    different = np.count_nonzero(turned != spheres) / max(np.count_nonzero(spheres), 1)
    check(f"glyphs of {shown.sum()} bodies, share of {np.count_nonzero(spheres)} pixels that differ", different, 2e-2)
    if picture:
        writer = vtk.vtkPNGWriter()
        writer.SetFileName(picture)
        writer.SetInputConnection(image.GetOutputPort())
        writer.Write()
        print("  wrote", picture)


def with_ovito(own):
    import ovito
    from ovito.io import import_file
    from ovito.modifiers import CreateBondsModifier

    exact = {"dump": 1e-14, "xyz": 1e-15, "gsd": 3e-7, "data": 1e-14}
    for ending, limit in exact.items():
        print("ovito", ovito.version_string, "reads", own.files[ending].name)
        flags = {"atom_style": "sphere"} if ending == "data" else {}
        data = import_file(str(own.files[ending]), **flags).compute()
        particles = data.particles
        check("number of pieces", abs(particles.count - len(own.body)), 0)
        if particles.count != len(own.body):
            continue
        order = np.argsort(np.array(particles["Particle Identifier"])) if "Particle Identifier" in particles else np.arange(particles.count)
        cell = np.array(data.cell[:, :3])
        check("periodic on all sides", 3 - sum(data.cell.pbc), 0)
        same_lattice("cell", own, cell, max(limit, 1e-14))
        place = np.array(particles.positions)[order]
        # OVITO holds radii in single precision.
        check("radii", relative(np.array(particles["Radius"])[order], own.piece_radius), 3e-7)
        names = {"Molecule Identifier": own.id[own.body], "granum_body": own.id[own.body]}
        bodies = next((name for name in names if name in particles), None)
        if bodies is None and ending != "data":
            check("bodies: there is no property of them", 1, 0)
        elif bodies is not None:
            check(f"bodies ({bodies})", np.abs(np.array(particles[bodies])[order] - names[bodies]).max(), 0)
        if "Mass" in particles:
            check("masses of bodies as sums over pieces", relative(own.sum_of(np.array(particles["Mass"])[order]), own.mass), max(limit, 1e-13))
        if "Orientation" in particles:
            # In single precision as radii.
            x, y, z, w = np.array(particles["Orientation"])[order].T
            shapes("orientations", own, cell, place, np.stack([w, x, y, z], axis=1), max(30 * limit, 1e-6))
        elif ending != "data":
            check("orientations: there is no property of them", 1, 0)
        data.apply(CreateBondsModifier(cutoff=float(2.001 * own.piece_radius.max())))
        back = np.argsort(order)
        found = overlapping(own, cell, place, [(int(back[a]), int(back[b])) for a, b in np.array(data.particles.bonds.topology)])
        check(f"pairs of pieces of two bodies that overlap and are none of granum's {len(own.pairs())}, or the other way round", len(found ^ own.pairs()), 0)


def with_gsd(own):
    import gsd
    import gsd.hoomd

    print("gsd", gsd.version.version, "reads", own.files["gsd"].name)
    with gsd.hoomd.open(str(own.files["gsd"]), "r") as file:
        frame = file[0]
    lx, ly, lz, xy, xz, yz = [float(x) for x in frame.configuration.box]
    cell = np.array([[lx, xy * ly, xz * lz], [0, ly, yz * lz], [0, 0, lz]])
    same_lattice("cell", own, cell, 3e-7)
    particles, place = frame.particles, np.array(frame.particles.position, dtype=float)
    check("number of pieces", abs(len(place) - len(own.body)), 0)
    check("numbers of bodies", np.abs(particles.body - own.body).max(), 0)
    check("ids of bodies", np.abs(frame.log["particles/granum_body"] - own.id[own.body]).max(), 0)
    check("diameters", relative(particles.diameter / 2, own.piece_radius), 1e-7)
    check("masses of bodies as sums over pieces", relative(own.sum_of(particles.mass), own.mass), 3e-7)
    shapes("orientations", own, cell, place, particles.orientation, 1e-5)
    return frame, cell, place


def with_freud(own):
    import freud

    print("freud", freud.__version__, "takes the frame of gsd")
    frame, cell, place = with_gsd(own)
    query = freud.locality.AABBQuery(freud.box.Box.from_box(frame.configuration.box), frame.particles.position)
    near = query.query(frame.particles.position, {"r_max": float(2.001 * own.piece_radius.max()), "exclude_ii": True}).toNeighborList()
    found = overlapping(own, cell, place, zip(near.query_point_indices, near.point_indices))
    check(f"pairs of pieces of two bodies that overlap and are none of granum's {len(own.pairs())}, or the other way round", len(found ^ own.pairs()), 0)


def with_ase(own):
    import ase
    import ase.io

    print("ase", ase.__version__, "reads", own.files["xyz"].name)
    atoms = ase.io.read(own.files["xyz"])
    check("number of pieces", abs(len(atoms) - len(own.body)), 0)
    check("places", images(own.piece_place, own.cell, atoms.positions) / np.abs(own.cell).max(), 1e-15)
    check("bodies", np.abs(atoms.arrays["molecule"] - own.id[own.body]).max(), 0)
    check("radii", relative(atoms.arrays["radius"], own.piece_radius), 1e-15)
    check("masses of bodies", relative(atoms.arrays["body_mass"], own.mass[own.body]), 1e-15)
    shapes("orientations", own, own.cell, atoms.positions, atoms.arrays["orientation"][:, [3, 0, 1, 2]], 1e-12)


def with_pyvista(own):
    import pyvista

    print("pyvista", pyvista.__version__, "reads", own.files["vtp"].name, "and", own.files["bodies"].name)
    mesh = pyvista.read(own.files["vtp"])
    check("vertices", abs(mesh.n_verts - len(own.body)), 0)
    bodies = pyvista.read(own.files["bodies"])
    check("orientations", relative(bodies.point_data["orientation"], own.orientation), 1e-15)


def with_lammps(own, folder):
    script = f"""
units si
atom_style sphere
atom_modify map array
boundary p p p
box tilt large
fix body all property/atom mol ghost yes
read_data {own.files["data"].name} fix body NULL Molecules
neighbor {0.2 * own.piece_radius.max()} bin
neigh_modify exclude molecule/intra all
pair_style zero {2.1 * own.piece_radius.max()}
pair_coeff * *
comm_modify vel yes
fix move all rigid/small molecule
thermo_style custom step atoms
run 0
print "GRANUM $(atoms)"
write_dump all custom read.dump id mol radius mass x y z xu yu zu vx vy vz modify sort id format float %.17g
"""
    (folder / "in.read").write_text(script)
    done = subprocess.run(["lmp", "-in", "in.read", "-log", "none"], cwd=folder, capture_output=True, text=True)
    print("lmp reads", own.files["data"].name)
    if "GRANUM" not in done.stdout:
        print(done.stdout[-1500:])
        failures.append("lmp")
        return
    bodies = next(line.split()[0] for line in done.stdout.splitlines() if "rigid bodies with" in line)
    check("bodies of fix rigid/small", abs(int(bodies) - len(own.id)), 0)
    rows = (folder / "read.dump").read_text().splitlines()
    start = next(k for k, line in enumerate(rows) if line.startswith("ITEM: ATOMS"))
    numbers = np.array([[float(x) for x in row.split()] for row in rows[start + 1 :]])
    check("number of pieces", abs(len(numbers) - len(own.body)), 0)
    check("bodies", np.abs(numbers[:, 1] - own.id[own.body]).max(), 0)
    check("radii", relative(numbers[:, 2], own.piece_radius), 1e-14)
    check("masses of bodies as sums over pieces", relative(own.sum_of(numbers[:, 3]), own.mass), 1e-13)
    # By its image flags each body hangs together.
    apart = np.zeros(len(own.body))
    starts = np.concatenate([[0], np.cumsum(own.count)[:-1]])[own.body]
    wanted = np.linalg.norm(own.arm - own.arm[starts], axis=1)
    apart = np.linalg.norm(numbers[:, 7:10] - numbers[starts, 7:10], axis=1)
    check("distances of the unwrapped pieces of a body", relative(apart, wanted), 1e-12)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run")
    parser.add_argument("--granum", default="granum")
    parser.add_argument("--snapshot", default="end")
    parser.add_argument("--picture", help="also write the picture of the glyphs to this PNG file")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        own = Own(options.granum, options.run, options.snapshot, folder)
        print(f"{len(own.id)} bodies of {len(own.body)} pieces, {len(own.first)} contacts, cell\n{own.cell}")
        check_exports.with_each((
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
