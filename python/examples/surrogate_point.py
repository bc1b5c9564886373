"""A surrogate in place of grains behind a material point, and many points of it at once."""

import granum
import numpy as np

STRAINS = ["axial_strain", "lateral_strain_2", "lateral_strain_3", "shear_strain_yz", "shear_strain_zx", "shear_strain_xy"]
STRESSES = ["stress_11", "stress_22", "stress_33", "stress_23", "stress_13", "stress_12"]


def run(seed: int) -> granum.Table:
    """A made-up body that is stiffer where its void ratio is smaller, along a straight line of strain."""
    random = np.random.default_rng(seed)
    strain = np.linspace(0, 1, 20)[:, None] * random.normal(size=6) * 1e-2
    void_ratio = random.uniform(0.6, 0.8)
    stress = 100e3 * np.array([1, 1, 1, 0, 0, 0]) + 10e6 / void_ratio * strain
    columns = dict(zip(STRAINS, strain.T)) | dict(zip(STRESSES, stress.T))
    return granum.Table(columns | {"sample.void_ratio": np.full(20, void_ratio)}, units=dict.fromkeys(STRESSES, "Pa"))


# ANCHOR: point
data = granum.Dataset({f"run {seed}": run(seed) for seed in range(20)})
surrogate = granum.surrogates.fit(data, [*STRAINS, "sample.void_ratio"], STRESSES, method="path-tensor")
point = granum.MaterialPoint.from_surrogate(surrogate, {"sample.void_ratio": 0.7})
state = point.start
for step in range(5):
    state = point.advance(state, [5e-4, 0, 0, 0, 0, 0])
print(state.stress / 1e3, state.noise / 1e3, state.outside)
stiffness = point.tangent(state, "probes")
# The points of a mesh: each from its own state, on all processors.
states = point.advance_all([state] * 1000, np.random.default_rng(1).normal(size=(1000, 6)) * 3e-4)
# ANCHOR_END: point
exact = 100e3 + 10e6 / 0.7 * 2.5e-3
print(f"axial stress {state.stress[0] / 1e3:.0f} kPa, that of the body {exact / 1e3:.0f} kPa; {len(states)} points")
