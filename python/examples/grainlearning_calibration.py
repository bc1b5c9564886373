"""GrainLearning's own Bayesian calibration (https://grainlearning.readthedocs.io) with granum as its simulator.

The measured curve is that of a simulation with a friction of 0.1, which GrainLearning finds again from the ratio of stresses.
"""

import warnings

import granum
import numpy as np
from grainlearning import BayesianCalibration
from grainlearning.dynamic_systems import DynamicSystem

TRUTH = 0.1
CASE = granum.Case(
    grains={"count": 300, "spread": 0.3},
    preparation={"solid_fraction": "none", "friction": 0.2, "unbalanced_force": 5e-3, "inertial_number": 2e-3},
    shear={"deviator_strain": 0.05, "inertial_number": 5e-4},
    recording={"states": 8},
)


def main() -> None:
    """Calibrates and prints what was found."""
    # Those of other packages; what granum has to say of a run is not hidden.
    warnings.simplefilter("ignore")
    warnings.simplefilter("default", granum.RunWarning)

    def curve(friction: float) -> granum.Table:
        # Proposals of later rounds may lie outside of the range.
        return granum.run(CASE.with_values({"grains.material.friction": max(0.02, float(friction))})).series

    def simulate(calibration: BayesianCalibration) -> None:
        """Gives the curves of all proposed frictions, as GrainLearning wants them: proposals, observations, states."""
        system = calibration.system
        system.set_sim_data([np.array([curve(friction)["stress_ratio"]]) for (friction,) in system.param_data])

    measured = curve(TRUTH)
    calibration = BayesianCalibration.from_dict(
        {
            "num_iter": 2,
            "callback": simulate,
            "save_fig": -1,
            "system": {
                "system_type": DynamicSystem,
                "param_names": ["friction"],
                "param_min": [0.02],
                "param_max": [0.3],
                "num_samples": 8,
                "obs_data": [measured["stress_ratio"].tolist()],
                "obs_names": ["stress_ratio"],
                "ctrl_data": measured["deviator_strain"].tolist(),
                "ctrl_name": "deviator_strain",
                "sim_name": "granum",
                "sigma_tol": 0.01,
            },
            "inference": {"Bayes_filter": {"ess_target": 0.3}, "sampling": {"max_num_components": 1, "random_state": 0}},
        }
    )
    calibration.run()
    (found,) = calibration.get_most_prob_params()
    print(f"friction {found:.3f}; the simulation that was measured had {TRUTH}")


if __name__ == "__main__":
    main()
