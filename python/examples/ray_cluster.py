"""The runs of a campaign over a cluster of Ray, with the results of the campaign.

Here the cluster is this machine; `ray.init("auto")` finds one that is running. Ray repeats a task whose worker is lost (`max_retries`).
"""

import os
import pathlib
import tempfile

# Ray counts processors for tasks, and tells about itself where it is not asked.
os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")

import granum
import ray

CASE = granum.Case(
    grains={"count": 300, "spread": 0.3},
    preparation={"solid_fraction": "none", "friction": 0.2, "unbalanced_force": 5e-3, "inertial_number": 2e-3},
    shear={"deviator_strain": 0.05, "inertial_number": 5e-4},
    recording={"states": 10},
)


@ray.remote(max_retries=2)
def stress_ratios(case: granum.Case) -> list[float]:
    """The ratios q/p of the test of a case."""
    # One thread each: the workers share the processors.
    return granum.run(case, threads=1).series["stress_ratio"].tolist()


def main() -> None:
    """Compares runs over the cluster with those of the campaign."""
    with tempfile.TemporaryDirectory() as kept:
        campaign = granum.Campaign(CASE, pathlib.Path(kept) / "study", friction=[0.1, 0.3, 0.5])
        ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
        found = ray.get([stress_ratios.remote(campaign.case_of(name)) for name in campaign.names])
        ray.shutdown()
        campaign.run(workers=2)
        print(len(found), "runs; the numbers of the campaign:", found == [campaign[name].series["stress_ratio"].tolist() for name in campaign.names])


if __name__ == "__main__":
    main()
