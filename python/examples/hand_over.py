"""Grains and contacts in the hands of others: freud analyses them, OVITO and PyVista read and show them.

Each of the three is shown if it is installed, and otherwise named as missing.
"""

import importlib.util
import pathlib
import tempfile

import granum
import numpy as np

CASE = granum.Case(
    grains={"count": 300, "spread": 0.3},
    preparation={"solid_fraction": "none", "friction": 0.2, "unbalanced_force": 5e-3, "inertial_number": 2e-3},
    shear={"deviator_strain": 0.05, "inertial_number": 5e-4},
    recording={"states": 5},
)


def with_freud(assembly: granum.Assembly) -> None:
    """The contacts as the neighbours of freud, and bond-orientational order over them."""
    import freud

    box = freud.box.Box.from_matrix(assembly.cell)
    # The cell of granum has a corner at the origin, that of freud its middle.
    positions = box.wrap(assembly.positions - assembly.cell.sum(axis=1) / 2)
    first, second = assembly.contacts.T
    # Each contact is a bond from either grain; freud wants them in order.
    i, j = np.concatenate([first, second]), np.concatenate([second, first])
    vectors = np.concatenate([assembly.branches, -assembly.branches])
    order = np.lexsort((j, i))
    grains = len(positions)
    neighbours = freud.locality.NeighborList.from_arrays(grains, grains, i[order], j[order], vectors[order].astype(np.float32))
    touching = np.unique(i)
    steinhardt = freud.order.Steinhardt(l=6).compute((box, positions), neighbors=neighbours)
    print(
        f"freud: {neighbours.neighbor_counts.mean():.4f} contacts of a grain, granum counts {2 * len(assembly.contacts) / grains:.4f}; "
        f"q6 of the contacts {steinhardt.particle_order[touching].mean():.3f}"
    )


def with_ovito(assembly: granum.Assembly, folder: pathlib.Path) -> None:
    """A file of extended XYZ, which OVITO reads with cell and radii; no window is opened."""
    from ovito.io import import_file

    granum.write(folder / "grains.xyz", assembly)
    data = import_file(str(folder / "grains.xyz")).compute()
    radii = np.sort(np.asarray(data.particles["Radius"]))
    print(
        f"OVITO: {data.particles.count} grains, the same radii {bool(np.allclose(radii, np.sort(assembly.radii), rtol=1e-6))}, "
        f"the same volume {bool(np.isclose(data.cell.volume, assembly.volume, rtol=1e-6))}"
    )


def with_pyvista(assembly: granum.Assembly, folder: pathlib.Path) -> None:
    """A file of VTK, which PyVista reads with all quantities of the grains; or arrays as they are."""
    import pyvista

    granum.write(folder / "grains.vtp", assembly)
    read = pyvista.read(folder / "grains.vtp")
    points = pyvista.PolyData(np.ascontiguousarray(assembly.positions))
    points["radius"] = np.ascontiguousarray(assembly.radii)
    spheres = points.glyph(scale="radius", orient=False, geom=pyvista.Sphere(radius=1, theta_resolution=8, phi_resolution=8))
    print(f"PyVista: {read.n_verts} grains and {read.n_lines} lines of contacts; {spheres.n_cells} triangles of spheres")


def main() -> None:
    """Hands the last state of a test to each."""
    assembly = granum.run(CASE).snapshot()
    with tempfile.TemporaryDirectory() as kept:
        folder = pathlib.Path(kept)
        for package, show in (
            ("freud", lambda: with_freud(assembly)),
            ("ovito", lambda: with_ovito(assembly, folder)),
            ("pyvista", lambda: with_pyvista(assembly, folder)),
        ):
            if importlib.util.find_spec(package) is None:
                print(f"{package} is not installed")
            else:
                show()


if __name__ == "__main__":
    main()
