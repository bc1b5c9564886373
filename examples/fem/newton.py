"""Newton's iteration for cells of grains, damped, with Kratos's elements and forces.

The stiffness of a cell that slides, softens or is torn apart foresees the answer badly or is singular. The matrix of an iteration is therefore that of
the cells and a part of the stiffness at the beginning of the stage (Levenberg 1944, Marquardt 1963). This changes the way to equilibrium and not the equilibrium, since the forces
are those of the cells alone. After a correction that does not make the residual smaller the part is larger, and the correction smaller and more like that of an elastic body.
"""
import numpy

import KratosMultiphysics as K

# Damping after a correction that did not make the residual smaller; 0.02 of the first stiffness becomes at most four times this stiffness.
MORE_DAMPING, MOST_DAMPING = 6.0, 250.0


class Newton:
    """The iteration of one step. Fixed displacements have their values of the end of the step before it begins."""

    def __init__(self, part, strategy, scheme, builder):
        self.part, self.scheme, self.builder = part, scheme, builder
        self.system = strategy.GetSystemMatrix(), strategy.GetSolutionVector(), strategy.GetSystemVector()
        components = [K.DISPLACEMENT_X, K.DISPLACEMENT_Y]
        self.free = [(node, component) for node in part.Nodes for component in components if not node.IsFixed(component)]
        self.places = numpy.array([node.GetDof(component).EquationId for node, component in self.free])

    def _displacements(self):
        return numpy.array([node.GetSolutionStepValue(component, 0) for node, component in self.free])

    def _set(self, displacements):
        for (node, component), displacement in zip(self.free, displacements):
            node.SetSolutionStepValue(component, 0, float(displacement))

    def _evaluate(self):
        """Stiffness and residual forces of the free displacements: one question to each cell."""
        matrix, _, forces = self.system
        self.scheme.InitializeNonLinIteration(self.part, *self.system)
        # Kratos adds to what is there.
        K.UblasSparseSpace().SetToZeroMatrix(matrix)
        forces.fill(0.0)
        self.builder.Build(self.scheme, self.part, matrix, forces)
        self.scheme.FinalizeNonLinIteration(self.part, *self.system)
        rows = numpy.repeat(numpy.arange(matrix.Size1()), numpy.diff(matrix.index1_data()))
        dense = numpy.zeros((matrix.Size1(), matrix.Size2()))
        dense[rows, matrix.index2_data()] = matrix.value_data()
        return dense[numpy.ix_(self.places, self.places)], numpy.array(forces)[self.places]

    def stiffness(self):
        """Stiffness of the present displacements."""
        return self._evaluate()[0]

    def solve(self, limit, most_evaluations, damping):
        """Iterates until the norm of the residual forces is below `limit`, N per m, and leaves the best displacements that were seen. `damping` is the matrix
        that is added to the stiffness, not zero. Returns the norm that was reached and how often the cells were asked."""
        stiffness, residual = self._evaluate()
        best, norm, evaluations = self._displacements(), numpy.linalg.norm(residual), 1
        is_better, factor = True, 1.0
        while is_better and norm > limit and evaluations < most_evaluations:
            is_better = False
            while not is_better and factor <= MOST_DAMPING and evaluations < most_evaluations:
                self._set(best + numpy.linalg.solve(stiffness + factor * damping, residual))
                tried = self._evaluate()
                evaluations += 1
                # A comparison with NaN, the answer of a cell that refuses, is false.
                is_better = numpy.linalg.norm(tried[1]) < norm
                factor = max(1.0, factor / MORE_DAMPING) if is_better else factor * MORE_DAMPING
            if is_better:
                stiffness, residual = tried
                best, norm = self._displacements(), numpy.linalg.norm(residual)
        self._set(best)
        self.builder.CalculateReactions(self.scheme, self.part, *self.system)
        return norm, evaluations
