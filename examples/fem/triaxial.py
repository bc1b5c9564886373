"""Drained triaxial compression of one hexahedron in Kratos, with a live cell of granum at each of its eight points.

    python triaxial.py LIBRARY [--law umat|user_mod] [--steps 20] [--strain 2e-3] [--restart] [--threads 1] [--out FOLDER]

The axial displacement is prescribed and the lateral pressure is constant. With --restart the test is interrupted in the middle: Kratos
and granum write their files, and another model goes on from them. Written are curve.csv and states.granum, from which
`cargo run -p granum-c --example replay_points` carries out again, in Rust, what Kratos has accepted.
"""
import argparse
import math
import os
import sys
import time

os.environ.setdefault("OMP_WAIT_POLICY", "passive")
import KratosMultiphysics as K  # noqa: E402
import KratosMultiphysics.GeoMechanicsApplication as G  # noqa: E402
import KratosMultiphysics.StructuralMechanicsApplication  # noqa: E402, F401

from granum_points import Library, name_points_of_kratos  # noqa: E402

K.Logger.GetDefaultOutput().SetSeverity(K.Logger.Severity.WARNING)
variable = K.KratosGlobals.GetVariable
PRESSURE = 100.0e3
VARIABLES = 5
LAWS = {"umat": "SmallStrainUMAT3DLaw", "user_mod": "SmallStrainUDSM3DLaw"}


def material(part, library, law, undrained):
    properties = part.CreateNewProperties(1)
    properties.SetValue(K.CONSTITUTIVE_LAW, K.KratosGlobals.GetConstitutiveLaw(LAWS[law]).Clone())
    for name, value in {
        "UDSM_NAME": library.path,
        "IS_FORTRAN_UDSM": True,
        "UDSM_NUMBER": 1,
        "UMAT_PARAMETERS": K.Vector([1.0]),
        "STATE_VARIABLES": K.Vector([0.0] * VARIABLES),
        "GEO_DRAINAGE_TYPE": "FULLY_COUPLED" if undrained else "CONSTANT_PW_FIELD",
        "RETENTION_LAW": "SaturatedLaw",
        "DENSITY_SOLID": 2650.0,
        "DENSITY_WATER": 1000.0,
        "POROSITY": 0.4,
        "BULK_MODULUS_SOLID": 1.0e12,
        "BULK_MODULUS_FLUID": 2.0e9,
        "DYNAMIC_VISCOSITY": 1.0e-3,
        "BIOT_COEFFICIENT": 1.0,
        "PERMEABILITY_XX": 1e-12,
        "PERMEABILITY_YY": 1e-12,
        "PERMEABILITY_ZZ": 1e-12,
        "PERMEABILITY_XY": 0.0,
        "PERMEABILITY_YZ": 0.0,
        "PERMEABILITY_ZX": 0.0,
        "SATURATED_SATURATION": 1.0,
        "RESIDUAL_SATURATION": 0.0,
    }.items():
        properties.SetValue(variable(name), value)
    return properties


def cube(model, library, law, undrained):
    """A unit cube of one hexahedron, rollers at x = y = z = 0; its lateral faces are loaded through their nodes, whose forces a restart file
    keeps (the pressure conditions of Kratos 10.4.4 crash when they are read)."""
    part = model.CreateModelPart("cube", 2)
    part.ProcessInfo.SetValue(K.DOMAIN_SIZE, 3)
    for name in (
        "DISPLACEMENT TOTAL_DISPLACEMENT INCREMENTAL_DISPLACEMENT VELOCITY ACCELERATION REACTION VOLUME_ACCELERATION WATER_PRESSURE "
        "REACTION_WATER_PRESSURE DT_WATER_PRESSURE NORMAL_FLUID_FLUX HYDRAULIC_DISCHARGE NORMAL_CONTACT_STRESS "
        "TANGENTIAL_CONTACT_STRESS SURFACE_LOAD LINE_LOAD POINT_LOAD"
    ).split():
        part.AddNodalSolutionStepVariable(variable(name))
    corners = [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    for k, corner in enumerate(corners):
        part.CreateNewNode(k + 1, *map(float, corner))
    properties = material(part, library, law, undrained)
    part.CreateNewElement("UPwSmallStrainElement3D8N", 1, list(range(1, 9)), properties)
    for node in part.Nodes:
        part.CreateNewCondition("PointLoadCondition3D1N", node.Id, [node.Id], properties)
    tool = K.VariableUtils()
    for axis in "XYZ":
        tool.AddDof(variable("DISPLACEMENT_" + axis), variable("REACTION_" + axis), part)
    tool.AddDof(K.WATER_PRESSURE, variable("REACTION_WATER_PRESSURE"), part)
    load(part, undrained)
    return part


def load(part, undrained):
    """Fixes what is fixed and loads the faces x = 1 and y = 1; a quarter of each face belongs to each of its nodes."""
    for node in part.Nodes:
        if not undrained:
            node.Fix(K.WATER_PRESSURE)
        if node.X0 == 0:
            node.Fix(K.DISPLACEMENT_X)
        if node.Y0 == 0:
            node.Fix(K.DISPLACEMENT_Y)
        node.Fix(K.DISPLACEMENT_Z)
        node.SetSolutionStepValue(variable("POINT_LOAD"), 0, [-0.25 * PRESSURE * node.X0, -0.25 * PRESSURE * node.Y0, 0.0])


def solver(part, tolerance, undrained):
    # The static scheme of Kratos leaves the pressure of the pore water as it is.
    scheme = G.BackwardEulerQuasistaticUPwScheme() if undrained else G.GeoStaticScheme()
    strategy = K.ResidualBasedNewtonRaphsonStrategy(
        part,
        scheme,
        K.ResidualCriteria(tolerance, 0.25e-3 * PRESSURE),
        K.ResidualBasedBlockBuilderAndSolver(K.SkylineLUFactorizationSolver()),
        60,
        True,
        False,
        False,
    )
    strategy.SetEchoLevel(0)
    return strategy


def points(part, what):
    return part.Elements[1].CalculateOnIntegrationPoints(what, part.ProcessInfo)


def restarted(model, library, folder, part):
    """The files of Kratos and of granum, and a new model from them. Displacements count from zero, as in every next stage of Kratos."""
    path = os.path.join(folder, "kratos_restart")
    K.FileSerializer(path, K.SerializerTraceType.SERIALIZER_NO_TRACE).Save("Model", model)
    library.save(os.path.join(folder, "restart.granum"))
    model = K.Model()
    K.FileSerializer(path, K.SerializerTraceType.SERIALIZER_NO_TRACE).Load("Model", model)
    library.load(os.path.join(folder, "restart.granum"))
    part = model.GetModelPart("cube")
    return model, part


def new_stage(part, tolerance, undrained):
    for node in part.Nodes:
        for step in (0, 1):
            node.SetSolutionStepValue(K.DISPLACEMENT, step, [0.0, 0.0, 0.0])
    strategy = solver(part, tolerance, undrained)
    strategy.Initialize()
    return strategy


def attempted(part, strategy, strain):
    """Tries a strain since the last stage; if it does not converge, displacements are those of the step before. What the library refuses is
    NaN, with which Newton's iteration does not converge; granum's state is that of the step before in any case."""
    for node in part.Nodes:
        node.SetSolutionStepValue(K.DISPLACEMENT_Z, 0, -strain if node.Z0 == 1 else 0.0)
    strategy.InitializeSolutionStep()
    strategy.Predict()
    converged = strategy.SolveSolutionStep()
    if converged and all(math.isfinite(x) for stress in points(part, K.CAUCHY_STRESS_VECTOR) for x in stress):
        return True
    for node in part.Nodes:
        for quantity in (K.DISPLACEMENT, K.WATER_PRESSURE):
            node.SetSolutionStepValue(quantity, 0, node.GetSolutionStepValue(quantity, 1))
    return False


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("shared_object", metavar="library")
    arguments.add_argument("--configuration", default=os.path.join(os.path.dirname(__file__), "granum-materials.toml"))
    arguments.add_argument("--law", choices=sorted(LAWS), default="umat")
    arguments.add_argument("--steps", type=int, default=20)
    arguments.add_argument("--strain", type=float, default=2e-3)
    arguments.add_argument("--tolerance", type=float, default=1e-3)
    arguments.add_argument("--undrained", action="store_true", help="coupled with pore water that cannot flow out; umat or user_mod")
    arguments.add_argument("--stage", action="store_true", help="a new stage in the middle, without files")
    arguments.add_argument("--restart", action="store_true")
    arguments.add_argument("--threads", type=int, default=1)
    arguments.add_argument("--out", default=".")
    options = arguments.parse_args()
    os.makedirs(options.out, exist_ok=True)
    K.ParallelUtilities.SetNumThreads(options.threads)
    library = Library(options.shared_object, options.configuration)
    began = time.perf_counter()

    model = K.Model()
    part = cube(model, library, options.law, options.undrained)
    for name in ("VELOCITY_COEFFICIENT", "DT_PRESSURE_COEFFICIENT"):
        part.ProcessInfo.SetValue(getattr(G, name), 1.0)
    G.ApplyInitialUniformStressField(
        part, K.Parameters('{"value": [%f, %f, %f, 0.0, 0.0, 0.0]}' % ((-PRESSURE,) * 3))
    ).ExecuteInitialize()
    strategy = solver(part, options.tolerance, options.undrained)
    strategy.Initialize()
    name_points_of_kratos(part, VARIABLES)

    rows, settled, reached, iterations, cuts, attempts = [], 0.0, 0.0, 0, 0, 0
    for step in range(1, options.steps + 1):
        if (options.restart or options.stage) and step == options.steps // 2 + 1:
            if options.restart:
                model, part = restarted(model, library, options.out, part)
            strategy = new_stage(part, options.tolerance, options.undrained)
            settled = reached
        goal = options.strain * step / options.steps
        while reached < goal:
            attempts += 1
            part.CloneTimeStep(float(attempts))
            part.ProcessInfo[K.STEP] += 1
            load(part, options.undrained)
            trial = goal
            while not attempted(part, strategy, trial - settled):
                iterations += part.ProcessInfo[K.NL_ITERATION_NUMBER]
                cuts += 1
                trial = reached + 0.5 * (trial - reached)
                if trial - reached < 1e-3 * options.strain / options.steps:
                    sys.exit(f"step {step} does not converge; granum: {library.message or 'no refusal'}")
            iterations += part.ProcessInfo[K.NL_ITERATION_NUMBER]
            strategy.FinalizeSolutionStep()
            reached = trial
        each = points(part, K.CAUCHY_STRESS_VECTOR)
        # The mean of the eight points balances the loads; the points differ, since a sample of few grains is not isotropic.
        stress = [sum(one[k] for one in each) / len(each) for k in range(6)]
        state = [points(part, variable(f"STATE_VARIABLE_{k}"))[0] for k in range(1, VARIABLES + 1)]
        lateral = part.Nodes[2].GetSolutionStepValue(K.DISPLACEMENT_X)
        water = sum(node.GetSolutionStepValue(K.WATER_PRESSURE) for node in part.Nodes) / 8
        rows.append([step, options.strain * step / options.steps, *stress, lateral, *state, water])
    library.save(os.path.join(options.out, "states.granum"))
    with open(os.path.join(options.out, "curve.csv"), "w") as file:
        file.write("step,axial_strain,mean_xx,mean_yy,mean_zz,mean_xy,mean_yz,mean_xz,lateral_displacement,name,ticket,void_ratio,coordination_number,noise,water_pressure\n")
        for row in rows:
            file.write(",".join(repr(float(x)) for x in row) + "\n")
    last = rows[-1]
    print(
        f"{options.steps} steps, {cuts} cut back, {iterations} iterations, {time.perf_counter() - began:.1f} s: "
        f"mean szz {last[4]:.1f} Pa, sxx {last[2]:.1f} Pa, water {last[-1]:.1f} Pa, "
        f"ticket of the first point {last[10]:.0f}"
    )


if __name__ == "__main__":
    main()
