"""Biaxial compression in scikit-fem with a sample of grains at every quadrature point: the stress and the stiffness of each element are those of
granum, and nothing else is assumed of the material."""

from typing import Any

import granum
import numpy as np
import numpy.typing as npt
import skfem

PRESSURE = 100e3
"""Lateral pressure, Pa."""
STRAIN, STEPS = 4e-3, 8
"""Axial strain at the end, and the number of steps."""
TOLERANCE = 2e-3
"""Largest norm of the residual forces over that of the forces of the lateral pressure."""
CASE = granum.Case(
    grains={"count": 100, "material": {"youngs_modulus": "5 GPa", "interface_energy": 0, "friction": 0.5}},
    preparation={"friction": 0.05, "solid_fraction": "none", "mean_stress": "100 kPa", "unbalanced_force": 1e-3, "inertial_number": 2e-3},
)
PLANE = [0, 1, 5]
"""Places of xx, yy and xy among the six components of granum."""

Numbers = npt.NDArray[np.float64]


# ANCHOR: grains
class Grains:
    """The cells of all quadrature points: a trial begins with the states that were accepted last, which no trial changes."""

    def __init__(self, points: int) -> None:
        # Without relaxation the answer goes to the state itself as the increment goes to zero, which Newton's iteration needs.
        self.material = granum.MaterialPoint(granum.prepare(CASE).simulation(), relaxation=0)
        start = self.material.at_stress(self.material.start, [PRESSURE, PRESSURE, PRESSURE, 0, 0, 0])
        self.accepted = self.trial = [start] * points
        self.strain: Numbers = np.zeros((points, 3))

    def answer(self, strain: Numbers) -> tuple[Numbers, Numbers]:
        """Stress (points, 3) and stiffness (points, 3, 3) for the strain since the start, compression positive."""
        increments = np.zeros((len(strain), 6))
        increments[:, PLANE] = strain - self.strain
        self.trial = self.material.advance_all(self.accepted, increments)
        stress = np.array([state.stress for state in self.trial])[:, PLANE]
        stiffness = np.array([self.material.tangent(state, "secant") for state in self.trial])
        return stress, stiffness[:, PLANE][:, :, PLANE]

    def accept(self, strain: Numbers) -> None:
        """Takes the last trial as accepted."""
        self.accepted, self.strain = self.trial, strain


# ANCHOR_END: grains
def main() -> None:
    """Compresses a field of two by four quadrilaterals between smooth plates and prints the curve."""
    mesh = skfem.MeshQuad.init_tensor(np.linspace(0, 1, 3), np.linspace(0, 2, 5))
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementQuad1()), intorder=2)
    sides = skfem.FacetBasis(mesh, basis.elem, facets=mesh.facets_satisfying(lambda x: np.isclose(x[0], 0) | np.isclose(x[0], 1)))
    elements, quadrature = basis.dx.shape
    grains = Grains(elements * quadrature)

    @skfem.BilinearForm
    def stiffness_form(u: skfem.DiscreteField, v: skfem.DiscreteField, w: Any) -> Numbers:
        return np.asarray(np.einsum("ijep,jep,iep->ep", w["stiffness"], compression(u.grad), compression(v.grad)))

    @skfem.LinearForm
    def inner_forces(v: skfem.DiscreteField, w: Any) -> Numbers:
        # The stress of compression does work on strains of compression.
        return np.asarray(np.einsum("iep,iep->ep", w["stress"], compression(v.grad)))

    @skfem.LinearForm
    def outer_forces(v: skfem.DiscreteField, w: Any) -> Numbers:
        return np.asarray(-PRESSURE * (v[0] * w.n[0] + v[1] * w.n[1]))

    def of_points(values: Numbers) -> Numbers:
        """Values of points as scikit-fem has them, with elements and quadrature points last."""
        return np.moveaxis(values.reshape(elements, quadrature, *values.shape[1:]), (0, 1), (-2, -1))

    outer = outer_forces.assemble(sides)
    bottom, top = basis.get_dofs(lambda x: np.isclose(x[1], 0)), basis.get_dofs(lambda x: np.isclose(x[1], 2))
    # The plates are smooth: one node keeps the field from sliding away.
    corner = basis.nodal_dofs[0, np.flatnonzero(~mesh.p.any(axis=0))]
    fixed = np.concatenate([bottom.all("u^2"), top.all("u^2"), corner])
    free = np.setdiff1d(np.arange(basis.N), fixed)
    scale = np.linalg.norm(outer[free])

    displacement, iterations = basis.zeros(), 0
    last = basis.zeros()
    for step in range(1, STEPS + 1):
        # A step begins with the displacements that the step before foretells.
        before, displacement = displacement, displacement + last
        displacement[top.all("u^2")] = -STRAIN * 2 * step / STEPS
        for _ in range(20):
            gradient = np.asarray(basis.interpolate(displacement).grad)
            strain = np.moveaxis(compression(gradient), 0, -1).reshape(-1, 3)
            stress, stiffness = grains.answer(strain)
            inner = inner_forces.assemble(basis, stress=of_points(stress))
            residual = outer - inner
            iterations += 1
            if np.linalg.norm(residual[free]) < TOLERANCE * scale:
                break
            matrix = stiffness_form.assemble(basis, stiffness=of_points(stiffness))
            displacement = displacement + skfem.solve(*skfem.condense(matrix, residual, D=fixed))
        else:
            raise RuntimeError(f"step {step} does not converge")
        grains.accept(strain)
        last = displacement - before
        axial = inner[top.all("u^2")].sum()
        print(f"strain {STRAIN * step / STEPS:.4f}: axial stress {-1e-3 * axial:.1f} kPa, volume {strain[:, :2].sum(1).mean():.2e}")
    print(f"{STEPS} steps, {iterations} iterations, {len(grains.accepted)} points; lateral stress {1e-3 * stress[:, 0].mean():.2f} kPa")


def compression(gradient: Numbers) -> Numbers:
    """Strains xx, yy and xy of a gradient of displacements, compression positive and the shear strain as an angle."""
    return -np.array([gradient[0][0], gradient[1][1], gradient[0][1] + gradient[1][0]])


if __name__ == "__main__":
    main()
