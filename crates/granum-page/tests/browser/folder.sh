#!/usr/bin/env bash
# folder.sh PROGRAM FOLDER: a folder with small runs, one of them broken off, a campaign, a surrogate and a calibration's results.
set -euo pipefail
granum=$1
mkdir -p "$2"
cd "$2"
cat > case.toml << 'CASE'
[grains]
count = 60
[preparation]
friction = 0.1
solid_fraction = "none"
inertial_number = 1e-2
unbalanced_force = 2e-2
[shear]
deviator_strain = 0.03
inertial_number = 1e-2
[recording]
states = 12
observations_per_state = 2
CASE
"$granum" run case.toml --out runs/loose > /dev/null
"$granum" run case.toml --set preparation.seed=2 --out runs/other-seed > /dev/null
"$granum" run case.toml --set grains.material.friction=0.2 --out "runs/a name with spaces & <signs>" > /dev/null
cat > plan.toml << 'PLAN'
case = "case.toml"
[design]
kind = "full-factorial"
[[variable]]
name = "friction"
key = "grains.material.friction"
values = [0.2, 0.5]
[[variable]]
name = "seed"
key = "preparation.seed"
values = [1, 2]
PLAN
"$granum" campaign plan.toml --out campaign > /dev/null
"$granum" train runs/loose runs/other-seed --input solid_fraction --output stress_ratio --coordinate deviator_strain --method ridge --out study > /dev/null
mkdir -p fit/figures
"$granum" compare runs/loose runs/other-seed -o fit/figures/curves.svg > /dev/null
# What `granum calibrate` writes in the end, in small.
cat > fit/calibration.json << 'RESULT'
{
  "method": "emulator", "found_by": "4 chains of 1000 draws", "tests": ["TMD1", "TMD2"], "granum_version": "0.1.0",
  "parameters": [
    {"name": "friction", "unit": "", "mean": 0.31, "standard_deviation": 0.04, "quantile_5": 0.25, "median": 0.31, "quantile_95": 0.38},
    {"name": "youngs_modulus", "unit": "Pa", "mean": 2.1e9, "standard_deviation": 4e8, "quantile_5": 1.5e9, "median": 2.0e9, "quantile_95": 2.9e9}
  ],
  "against_the_posterior": ["the interval of friction ends at its prior"], "remarks": ["the interval of friction ends at its prior"]
}
RESULT
