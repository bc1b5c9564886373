"""A test of 60 grains in a wheel that was installed alone: that the package works on this machine. Prints the digest of the run."""

import tempfile
import warnings

import granum

with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
    warnings.simplefilter("ignore", granum.RunWarning)
    case = granum.Case(
        grains={"count": 60},
        preparation={"solid_fraction": "none", "unbalanced_force": 0.05},
        shear={"deviator_strain": 0.01, "inertial_number": 0.01},
        recording={"states": 2},
    )
    run = granum.run(case, out=f"{folder}/run")
    print("alone:", run.status, run.series["stress_ratio"], run.digest())
