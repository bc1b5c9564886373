"""Plane strain in Kratos with a user material: a grid of quadrilaterals, stages, and steps that are cut back. Biaxial test, K0 stress and
footing of this folder are made of it."""
import contextlib
import math
import os
import time

os.environ.setdefault("OMP_WAIT_POLICY", "passive")
# The matrices of newton.py are small; one thread is the fastest.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
import KratosMultiphysics as K  # noqa: E402
import KratosMultiphysics.GeoMechanicsApplication as G  # noqa: E402
import KratosMultiphysics.StructuralMechanicsApplication  # noqa: E402, F401

from granum_points import name_points_of_kratos  # noqa: E402
from newton import Newton  # noqa: E402

K.Logger.GetDefaultOutput().SetSeverity(K.Logger.Severity.WARNING)
variable = K.KratosGlobals.GetVariable
# The last two tell what is outside of the training of a surrogate, and whether grains have answered.
VARIABLES = 7
ELASTIC, MOHR_COULOMB, UMAT = "GeoLinearElasticPlaneStrain2DLaw", "GeoMohrCoulombWithTensionCutOff2D", "SmallStrainUMAT2DPlaneStrainLaw"
GRAVITY = 9.81
CORNERS = ((-1, -1), (1, -1), (1, 1), (-1, 1))


def set_material(part, number, law, **more):
    """The properties of a number, with a law. Kratos gives elements new law objects at the beginning of a stage, so that a call between two
    stages changes the law and keeps the stress."""
    properties = part.GetProperties()[number] if part.HasProperties(number) else part.CreateNewProperties(number)
    properties.SetValue(K.CONSTITUTIVE_LAW, K.KratosGlobals.GetConstitutiveLaw(law).Clone())
    # The soil is dry: its water has no pressure and next to no weight.
    values = {
        "GEO_DRAINAGE_TYPE": "CONSTANT_PW_FIELD", "RETENTION_LAW": "SaturatedLaw", "DENSITY_SOLID": 2650.0, "DENSITY_WATER": 1e-6,
        "POROSITY": 0.4, "BULK_MODULUS_SOLID": 1.0e12, "BULK_MODULUS_FLUID": 2.0e9, "DYNAMIC_VISCOSITY": 1.0e-3,
        "BIOT_COEFFICIENT": 1.0, "PERMEABILITY_XX": 1e-12, "PERMEABILITY_YY": 1e-12, "PERMEABILITY_ZZ": 1e-12, "PERMEABILITY_XY": 0.0,
        "PERMEABILITY_YZ": 0.0, "PERMEABILITY_ZX": 0.0, "SATURATED_SATURATION": 1.0, "RESIDUAL_SATURATION": 0.0, "THICKNESS": 1.0,
    }
    for name, value in {**values, **more}.items():
        properties.SetValue(variable(name), value)
    return properties


def set_grains(part, number, library, material=1):
    """Gives elements of a number live cells: material of the configuration of granum's library."""
    set_material(part, number, UMAT, UDSM_NAME=library.path, IS_FORTRAN_UDSM=True, UMAT_PARAMETERS=K.Vector([float(material)]),
                 STATE_VARIABLES=K.Vector([0.0] * VARIABLES))


class Grid:
    """Quadrilaterals between lines of x and y. Nodes and elements are numbered along x first."""

    def __init__(self, xs, ys, number_of=lambda i, j: 1):
        self.xs, self.ys = list(map(float, xs)), list(map(float, ys))
        self.model = K.Model()
        self.part = part = self.model.CreateModelPart("soil", 2)
        part.ProcessInfo.SetValue(K.DOMAIN_SIZE, 2)
        for name in (
            "DISPLACEMENT TOTAL_DISPLACEMENT INCREMENTAL_DISPLACEMENT VELOCITY ACCELERATION REACTION VOLUME_ACCELERATION WATER_PRESSURE "
            "REACTION_WATER_PRESSURE DT_WATER_PRESSURE NORMAL_FLUID_FLUX HYDRAULIC_DISCHARGE NORMAL_CONTACT_STRESS "
            "TANGENTIAL_CONTACT_STRESS SURFACE_LOAD LINE_LOAD POINT_LOAD"
        ).split():
            part.AddNodalSolutionStepVariable(variable(name))
        columns = len(self.xs)
        for j, y in enumerate(self.ys):
            for i, x in enumerate(self.xs):
                part.CreateNewNode(1 + i + columns * j, x, y, 0.0)
        self.numbers = set()
        for j in range(len(self.ys) - 1):
            for i in range(columns - 1):
                number, first = number_of(i, j), 1 + i + columns * j
                self.numbers.add(number)
                if not part.HasProperties(number):
                    set_material(part, number, ELASTIC, YOUNG_MODULUS=50e6, POISSON_RATIO=0.3)
                corners = [first, first + 1, first + 1 + columns, first + columns]
                part.CreateNewElement("UPwSmallStrainElement2D4N", 1 + i + (columns - 1) * j, corners, part.GetProperties()[number])
        for node in part.Nodes:
            part.CreateNewCondition("PointLoadCondition2D1N", node.Id, [node.Id], part.GetProperties()[min(self.numbers)])
        tool = K.VariableUtils()
        for axis in "XYZ":
            tool.AddDof(variable("DISPLACEMENT_" + axis), variable("REACTION_" + axis), part)
        tool.AddDof(K.WATER_PRESSURE, variable("REACTION_WATER_PRESSURE"), part)
        for node in part.Nodes:
            node.Fix(K.WATER_PRESSURE)
            node.Fix(K.DISPLACEMENT_Z)
        for name in ("VELOCITY_COEFFICIENT", "DT_PRESSURE_COEFFICIENT"):
            part.ProcessInfo.SetValue(getattr(G, name), 1.0)

    def node(self, i, j):
        """The node in column i and row j; -1 is the last one."""
        columns, rows = len(self.xs), len(self.ys)
        return self.part.Nodes[1 + i % columns + columns * (j % rows)]

    def column(self, i):
        return [self.node(i, j) for j in range(len(self.ys))]

    def row(self, j):
        return [self.node(i, j) for i in range(len(self.xs))]

    @staticmethod
    def lengths(coordinates):
        """The length of an edge that belongs to each node: half of those beside it."""
        gaps = [0.0, *(b - a for a, b in zip(coordinates, coordinates[1:])), 0.0]
        return [0.5 * (a + b) for a, b in zip(gaps, gaps[1:])]

    def at_points(self, quantity):
        """A quantity at the integration points of all elements, as a list for each element."""
        info = self.part.ProcessInfo
        return [[v if isinstance(v, float) else list(v) for v in e.CalculateOnIntegrationPoints(quantity, info)] for e in self.part.Elements]

    def coordinates_of_points(self):
        """Places of the integration points; Kratos's own quantity is zero for these elements."""
        shape = [[0.25 * (1 + a * p) * (1 + b * q) for p, q in CORNERS] for a, b in ((p / 3**0.5, q / 3**0.5) for p, q in CORNERS)]
        places = []
        for element in self.part.Elements:
            nodes = [(node.X0, node.Y0) for node in element.GetNodes()]
            places.append([[sum(n * node[k] for n, node in zip(numbers, nodes)) for k in (0, 1)] for numbers in shape])
        return places

    def state_variable(self, k):
        return self.at_points(variable(f"STATE_VARIABLE_{k}"))

    def name_points(self):
        name_points_of_kratos(self.part, VARIABLES)


class Stage:
    """A stage: Newton's iteration, steps of a load that goes from 0 to 1, and what they cost.

    `apply(share)` sets forces and prescribed displacements for a share of the load. A step begins with the displacements that the step before
    foretells. It has converged when the norm of the residual forces is below `tolerance` times the force that `force()` gives at the end of
    the step before, N per m of thickness; if it has not after `most_iterations`, it is tried with half its size.

    With `damping` it is the iteration of newton.py, and without it that of Kratos. A step that cannot be made smaller is taken all the same if its residual is below `accepted`
    times the force; the residual stays in the balance of the next step, and `costs()` says how many steps there were of this kind.
    """

    def __init__(self, grid, apply, force, tolerance=1e-3, most_iterations=20, damping=None, accepted=0.0):
        self.damping, self.accepted, self.first_stiffness = damping, accepted, None
        self.grid, self.part, self.apply, self.force, self.tolerance, self.most_iterations = grid, grid.part, apply, force, tolerance, most_iterations
        for node in self.part.Nodes:
            for step in (0, 1):
                node.SetSolutionStepValue(K.DISPLACEMENT, step, [0.0, 0.0, 0.0])
        self.freedoms = sum(1 for node in self.part.Nodes for axis in "XY" if not node.IsFixed(variable("DISPLACEMENT_" + axis)))
        self.strategy = self._newton()
        self.strategy.Initialize()
        self.reached, self.last = 0.0, None
        self.begin_to_count()

    def _newton(self):
        # Kratos divides the norm by the number of freedoms; its criterion cannot be changed later.
        criterion = K.ResidualCriteria(1e-12, self.tolerance * self.force() / self.freedoms)
        self.scheme, self.builder = G.GeoStaticScheme(), K.ResidualBasedBlockBuilderAndSolver(K.SkylineLUFactorizationSolver())
        strategy = K.ResidualBasedNewtonRaphsonStrategy(
            self.part, self.scheme, criterion, self.builder, self.most_iterations, True, False, False,
        )
        strategy.SetEchoLevel(0)
        return strategy

    def _displacements(self, step):
        return [[x for x in node.GetSolutionStepValue(K.DISPLACEMENT, step)] for node in self.part.Nodes]

    def _foretell(self, share):
        """Displacements of free nodes as if the last step went on."""
        if not self.last:
            return
        increments, size = self.last
        factor = (share - self.reached) / size
        for node, increment in zip(self.part.Nodes, increments):
            for k, axis in enumerate("XY"):
                component = variable("DISPLACEMENT_" + axis)
                if not node.IsFixed(component):
                    node.SetSolutionStepValue(component, 0, node.GetSolutionStepValue(component, 1) + factor * increment[k])

    def _try(self, share, is_least=False):
        self._foretell(share)
        self.apply(share)
        self.strategy.InitializeSolutionStep()
        self.strategy.Predict()
        if self.damping is None:
            converged = self.strategy.SolveSolutionStep()
            iterations = self.part.ProcessInfo[K.NL_ITERATION_NUMBER]
        else:
            converged, iterations = self._damped(is_least)
        self.iterations += iterations
        if converged and all(math.isfinite(x) for e in self.grid.at_points(K.CAUCHY_STRESS_VECTOR) for s in e for x in s):
            return True
        self.lost_iterations += iterations
        for node in self.part.Nodes:
            node.SetSolutionStepValue(K.DISPLACEMENT, 0, node.GetSolutionStepValue(K.DISPLACEMENT, 1))
        return False

    def _damped(self, is_least):
        newton = Newton(self.part, self.strategy, self.scheme, self.builder)
        if self.first_stiffness is None:
            self.first_stiffness = newton.stiffness()
        force = self.force()
        residual, evaluations = newton.solve(self.tolerance * force, self.most_iterations, self.damping * self.first_stiffness)
        if residual > self.tolerance * force and is_least and residual <= self.accepted * force:
            self.loose.append(residual / force)
            return True, evaluations
        return residual <= self.tolerance * force, evaluations

    def _begin_step(self):
        self.part.CloneTimeStep(self.part.ProcessInfo[K.TIME] + 1.0)
        self.part.ProcessInfo[K.STEP] += 1
        # Another strategy, whose criterion has the force of now; the elements go on.
        self.strategy = self._newton()
        self.strategy.SetInitializePerformedFlag(True)

    def settle(self):
        """A step without further load: live cells are brought to the stress of the stage before, and what they miss of it is balanced."""
        with self._timed():
            self._begin_step()
            converged = self._try(self.reached)
            if converged:
                self.strategy.FinalizeSolutionStep()
            return converged

    def advance(self, goal, least=1e-6):
        """Goes on to a share of the load. False if steps smaller than `least` do not converge either."""
        with self._timed():
            size = goal - self.reached
            while self.reached < goal:
                self._begin_step()
                trial = min(goal, self.reached + size)
                while not self._try(trial, size < 2.0 * least):
                    self.cut += 1
                    size = 0.5 * (trial - self.reached)
                    trial = self.reached + size
                    if size < least:
                        return False
                self.strategy.FinalizeSolutionStep()
                now, before = self._displacements(0), self._displacements(1)
                self.last = ([[a - b for a, b in zip(u, v)] for u, v in zip(now, before)], trial - self.reached)
                self.reached = trial
                self.steps += 1
            return True

    @contextlib.contextmanager
    def _timed(self):
        began, busy = time.perf_counter(), time.process_time()
        try:
            yield
        finally:
            self.seconds += time.perf_counter() - began
            self.processor_seconds += time.process_time() - busy

    def begin_to_count(self):
        """From here on steps, iterations and time are counted: without what it took to get to the initial stress."""
        self.steps = self.cut = self.iterations = self.lost_iterations = 0
        self.loose = []
        self.seconds = self.processor_seconds = 0.0

    def costs(self):
        loose = f"; {len(self.loose)} steps taken with residuals of up to {max(self.loose):.4f} of the force" if self.loose else ""
        each = f", {self.iterations / self.steps:.1f} iterations and {self.processor_seconds / self.steps:.2f} s of processor time each" if self.steps else ""
        return (f"{self.steps} steps{each}; {self.cut} tries cut back, {self.lost_iterations} of {self.iterations} iterations in them; "
                f"{self.processor_seconds:.1f} s of processor time in {self.seconds:.1f} s{loose}")


def k0_stress(grid, k0, surcharge):
    """Stress of the soil's own weight and of a surcharge on its surface, with a ratio K0 of horizontal to vertical: a stage with an elastic law, after
    which Kratos's K0 procedure corrects the horizontal stresses. Bottom and sides must be fixed before. The next stage begins from this stress."""
    for number in grid.numbers:
        set_material(grid.part, number, ELASTIC, YOUNG_MODULUS=50e6, POISSON_RATIO=0.3, K0_NC=k0, K0_MAIN_DIRECTION=1)
    weigh(grid, surcharge)
    procedure = G.ApplyK0ProcedureProcess(grid.model, K.Parameters('{"model_part_name": "soil", "use_standard_procedure": false}'))
    procedure.ExecuteInitialize()
    stage = Stage(grid, lambda share: None, lambda: max(surcharge, 1e3), tolerance=1e-6)
    if not stage.advance(1.0):
        raise RuntimeError("the stage of the own weight does not converge")
    procedure.ExecuteFinalizeSolutionStep()
    procedure.ExecuteFinalize()


def weigh(grid, surcharge):
    """Weight of the soil, and a vertical surcharge on its surface."""
    for node in grid.part.Nodes:
        for step in (0, 1):
            node.SetSolutionStepValue(variable("VOLUME_ACCELERATION"), step, [0.0, -GRAVITY, 0.0])
    for node, length in zip(grid.row(-1), Grid.lengths(grid.xs)):
        for step in (0, 1):
            node.SetSolutionStepValue(variable("POINT_LOAD"), step, [0.0, -surcharge * length, 0.0])
