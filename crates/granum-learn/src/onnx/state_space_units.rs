//! State-space networks as graphs.

use granum_nets::{
    Differentiable, StateSpace, StateSpaceWeights, TensorSizes, TensorStateSpace, TensorWeights,
};

use super::graph::{OnnxGraph, Value};
use super::unit::{OnnxStep, OnnxUnit, affine, part, parts, transposed};

/// Number of components of a deviator.
const COMPONENTS: usize = 5;
/// Square of the norm that bounded tensors do not reach.
const BOUND: f64 = 16.0;

impl OnnxUnit for StateSpace {
    fn state_values(&self) -> usize {
        self.outputs() + self.internal()
    }

    fn first_state(&self, graph: &mut OnnxGraph, starts: &Value) -> Value {
        let measured = graph.columns(starts, &(0..self.outputs()).collect::<Vec<_>>());
        if self.internal() == 0 {
            return measured;
        }
        let internal = affine(graph, starts, self.parts().first_internal, self.starts(), self.starts());
        graph.beside(&[&measured, &internal])
    }

    fn advance(&self, graph: &mut OnnxGraph, inputs: &Value, state: &Value) -> OnnxStep {
        let StateSpaceWeights { hidden, changes, .. } = self.parts();
        let length = graph.columns(inputs, &[0]);
        let both = graph.beside(&[inputs, state]);
        let neurons = affine(graph, &both, hidden, self.inputs() + self.state_values(), self.inputs());
        let neurons = graph.apply("Tanh", &[&neurons]);
        let rates = affine(graph, &neurons, changes, self.hidden(), 0);
        let change = graph.apply("Mul", &[&length, &rates]);
        let state = graph.apply("Add", &[state, &change]);
        let outputs = graph.columns(&state, &(0..self.outputs()).collect::<Vec<_>>());
        OnnxStep { outputs, state }
    }
}

/// Its deviators are tables of five rows with a column for each tensor, one table for each row of the inputs.
struct Tensors {
    sizes: TensorSizes,
    /// Measured and internal ones.
    count: usize,
    scalars: usize,
}

impl Tensors {
    fn new(sizes: TensorSizes) -> Tensors {
        let count = sizes.tensors + sizes.internal_tensors;
        Tensors { sizes, count, scalars: sizes.scalars + sizes.internal_scalars }
    }

    /// A table in which the first component of each tensor comes first, then the second of each, as tables of tensors.
    fn read(graph: &mut OnnxGraph, table: &Value, count: usize) -> Value {
        graph.shaped(table, &[-1, COMPONENTS as i64, count as i64])
    }

    fn written(graph: &mut OnnxGraph, tensors: &Value, count: usize) -> Value {
        graph.shaped(tensors, &[-1, (COMPONENTS * count) as i64])
    }

    /// The measured tensors and scalars of a state, one after the other.
    fn measured(&self, graph: &mut OnnxGraph, tensors: Option<&Value>, scalars: Option<&Value>) -> Value {
        let mut found = Vec::new();
        if let Some(tensors) = tensors.filter(|_| self.sizes.tensors > 0) {
            let own = some(graph, tensors, &(0..self.sizes.tensors).collect::<Vec<_>>());
            found.push(Tensors::written(graph, &own, self.sizes.tensors));
        }
        found.extend(scalars.and_then(|scalars| part(graph, scalars, 0, self.sizes.scalars)));
        graph.beside(&found.iter().collect::<Vec<_>>())
    }

    /// The tensors and the scalars of a state, if there are any.
    fn divided(&self, graph: &mut OnnxGraph, state: &Value) -> [Option<Value>; 2] {
        let first = COMPONENTS * self.count;
        let tensors = part(graph, state, 0, first).map(|table| Tensors::read(graph, &table, self.count));
        [tensors, part(graph, state, first, self.scalars)]
    }

    fn joined(&self, graph: &mut OnnxGraph, tensors: Option<Value>, scalars: Option<Value>) -> Value {
        let tensors = tensors.map(|tensors| Tensors::written(graph, &tensors, self.count));
        let both: Vec<&Value> = tensors.iter().chain(&scalars).collect();
        graph.beside(&both)
    }
}

/// Tables of tensors side by side.
fn beside(graph: &mut OnnxGraph, tensors: &[Value]) -> Value {
    match tensors {
        [only] => only.clone(),
        _ => graph.apply_with("Concat", &tensors.iter().collect::<Vec<_>>(), &[("axis", 2)]),
    }
}

/// Some of the tensors.
fn some(graph: &mut OnnxGraph, tensors: &Value, chosen: &[usize]) -> Value {
    let chosen: Vec<i64> = chosen.iter().map(|tensor| *tensor as i64).collect();
    let chosen = graph.integers(&chosen);
    graph.apply_with("Gather", &[tensors, &chosen], &[("axis", 2)])
}

/// The inner products of tensors, one with one, or of all with one: a column for each.
fn inner(graph: &mut OnnxGraph, a: &Value, b: &Value) -> Value {
    let products = graph.apply("Mul", &[a, b]);
    let axis = graph.integers(&[1]);
    graph.apply_with("ReduceSum", &[&products, &axis], &[("keepdims", 0)])
}

/// The tables that stand for the deviators of the symmetric products with a tensor (a table of one row): multiplied by the components of another one they
/// give those of the product, `d_kij a_i b_j` with `d_kij = tr(E_k (E_i E_j + E_j E_i)) / 2` for the basis `E` of deviators.
fn products_with(graph: &mut OnnxGraph, tensor: &Value) -> Value {
    let factors: Vec<f64> = (0..COMPONENTS)
        .flat_map(|i| {
            (0..COMPONENTS * COMPONENTS).map(move |kj| factor([kj / COMPONENTS, i, kj % COMPONENTS]))
        })
        .collect();
    let tables = graph.linear(tensor, COMPONENTS, &factors, None);
    graph.shaped(&tables, &[-1, COMPONENTS as i64, COMPONENTS as i64])
}

/// `tr(E_k E_i E_j)`, of which the order of the indices changes nothing.
fn factor(indices: [usize; 3]) -> f64 {
    let (r6, r2) = (6f64.sqrt(), 2f64.sqrt());
    let matrix = |component: usize| {
        let mut c = [0.0; COMPONENTS];
        c[component] = 1.0;
        let [half, other, yz, zx, xy] = [c[0] / r6, c[1] / r2, c[2] / r2, c[3] / r2, c[4] / r2];
        [[2.0 * half, xy, zx], [xy, other - half, yz], [zx, yz, -other - half]]
    };
    let [k, i, j] = indices.map(matrix);
    let sums = |a: usize, b: usize| (0..3).map(|c| i[b][c] * j[c][a]).sum::<f64>();
    (0..3).map(|a| (0..3).map(|b| k[a][b] * sums(a, b)).sum::<f64>()).sum()
}

/// The tensors of which changes are sums, and what the hidden neurons see of them.
struct Invariants {
    basis: Value,
    features: Value,
}

impl Tensors {
    /// From the direction (a table of five columns), the tensors, and the columns that are invariants by themselves.
    fn invariants(
        &self,
        graph: &mut OnnxGraph,
        direction: &Value,
        tensors: Option<&Value>,
        others: Vec<Value>,
    ) -> Invariants {
        let along = Tensors::read(graph, direction, 1);
        let with_direction = products_with(graph, direction);
        let squared = graph.apply("MatMul", &[&with_direction, &along]);
        let (mut basis, mut features) = (vec![along.clone()], others);
        let cubic = inner(graph, &along, &squared);
        let Some(tensors) = tensors else {
            features.push(cubic);
            basis.push(squared);
            return self.together(graph, &basis, &features);
        };
        let [one, per_bound] = [1.0, 1.0 / BOUND].map(|value| graph.number(value));
        let squares = inner(graph, tensors, tensors);
        let squares = graph.apply("Mul", &[&squares, &per_bound]);
        let squares = graph.apply("Add", &[&squares, &one]);
        let norms = graph.apply("Sqrt", &[&squares]);
        let middle = graph.integers(&[1]);
        let norms = graph.apply("Unsqueeze", &[&norms, &middle]);
        let bounded = graph.apply("Div", &[tensors, &norms]);
        let products = graph.apply("MatMul", &[&with_direction, &bounded]);
        let pairs: Vec<[usize; 2]> =
            (0..self.count).flat_map(|i| (i..self.count).map(move |j| [i, j])).collect();
        let [first, second] =
            [0, 1].map(|end| some(graph, &bounded, &pairs.iter().map(|pair| pair[end]).collect::<Vec<_>>()));
        features.push(inner(graph, &bounded, &along));
        features.push(inner(graph, &first, &second));
        features.push(cubic);
        features.push(inner(graph, &bounded, &squared));
        features.push(inner(graph, &bounded, &products));
        basis.extend([bounded, squared, products]);
        self.together(graph, &basis, &features)
    }

    fn together(&self, graph: &mut OnnxGraph, basis: &[Value], features: &[Value]) -> Invariants {
        let basis = beside(graph, basis);
        Invariants { basis, features: graph.beside(&features.iter().collect::<Vec<_>>()) }
    }
}

impl OnnxUnit for TensorStateSpace {
    fn state_values(&self) -> usize {
        let own = Tensors::new(self.sizes());
        COMPONENTS * own.count + own.scalars
    }

    fn first_state(&self, graph: &mut OnnxGraph, starts: &Value) -> Value {
        let (own, sizes) = (Tensors::new(self.sizes()), self.sizes());
        let TensorWeights { first_tensors, first_scalars, .. } = self.parts();
        let measured = part(graph, starts, 0, COMPONENTS * sizes.tensors);
        let mut tensors: Vec<Value> =
            measured.iter().map(|measured| Tensors::read(graph, measured, sizes.tensors)).collect();
        if sizes.internal_tensors > 0 {
            tensors.push(match tensors.first() {
                Some(measured) => {
                    let weights = transposed(first_tensors, sizes.tensors);
                    graph.linear(measured, sizes.tensors, &weights, None)
                }
                // Sums of no tensors.
                None => {
                    let first = graph.columns(starts, &[0]);
                    let zeros = graph.row(&vec![0.0; COMPONENTS * sizes.internal_tensors]);
                    let zeros = graph.apply("Mul", &[&first, &zeros]);
                    Tensors::read(graph, &zeros, sizes.internal_tensors)
                }
            });
        }
        let tensors = (!tensors.is_empty()).then(|| beside(graph, &tensors));
        let start_scalars = part(graph, starts, COMPONENTS * sizes.tensors, sizes.start_scalars);
        let mut scalars = Vec::new();
        if let Some(starts) = start_scalars {
            scalars.extend(part(graph, &starts, 0, sizes.scalars));
            if sizes.internal_scalars > 0 {
                scalars.push(affine(graph, &starts, first_scalars, sizes.start_scalars, sizes.start_scalars));
            }
        } else if sizes.internal_scalars > 0 {
            // Sums of no scalars: the biases.
            let first = graph.columns(starts, &[0]);
            let zeros = graph.row(&vec![0.0; sizes.internal_scalars]);
            let zeros = graph.apply("Mul", &[&first, &zeros]);
            let biases = graph.row(first_scalars);
            scalars.push(graph.apply("Add", &[&zeros, &biases]));
        }
        let scalars = (!scalars.is_empty()).then(|| graph.beside(&scalars.iter().collect::<Vec<_>>()));
        own.joined(graph, tensors, scalars)
    }

    fn advance(&self, graph: &mut OnnxGraph, inputs: &Value, state: &Value) -> OnnxStep {
        let (own, sizes) = (Tensors::new(self.sizes()), self.sizes());
        let TensorWeights { hidden, coefficients, decays, .. } = self.parts();
        let [length, direction] = parts(graph, inputs, [1, COMPONENTS]);
        let further = part(graph, inputs, 1 + COMPONENTS, sizes.further);
        let [tensors, scalars] = own.divided(graph, state);
        let others = further.into_iter().chain(scalars.clone()).collect();
        let Invariants { basis, features } = own.invariants(graph, &direction, tensors.as_ref(), others);
        let width = hidden.len() / sizes.hidden - 1;
        let neurons = affine(graph, &features, hidden, width, width);
        let neurons = graph.apply("Tanh", &[&neurons]);
        let coefficients = affine(graph, &neurons, coefficients, sizes.hidden, 0);
        let elements = 2 * own.count + 2;
        let (tensor_decays, scalar_decays) = decays.split_at(own.count);
        let of_tensors = part(graph, &coefficients, 0, own.count * elements);
        let tensors = tensors.zip(of_tensors).map(|(before, own_coefficients)| {
            let factors = graph.shaped(&own_coefficients, &[-1, own.count as i64, elements as i64]);
            // The basis times the transposed coefficients: the transposed product of the coefficients and the transposed basis.
            let basis = graph.transposed(&basis, &[0, 2, 1]);
            let change = graph.apply("MatMul", &[&factors, &basis]);
            let change = graph.transposed(&change, &[0, 2, 1]);
            let decays = graph.row(tensor_decays);
            let lost = graph.apply("Mul", &[&before, &decays]);
            let rate = graph.apply("Sub", &[&change, &lost]);
            let last = graph.integers(&[2]);
            let length = graph.apply("Unsqueeze", &[&length, &last]);
            let change = graph.apply("Mul", &[&length, &rate]);
            graph.apply("Add", &[&before, &change])
        });
        let of_scalars = part(graph, &coefficients, own.count * elements, own.scalars);
        let scalars = scalars.zip(of_scalars).map(|(before, rates)| {
            let decays = graph.row(scalar_decays);
            let lost = graph.apply("Mul", &[&before, &decays]);
            let rate = graph.apply("Sub", &[&rates, &lost]);
            let change = graph.apply("Mul", &[&length, &rate]);
            graph.apply("Add", &[&before, &change])
        });
        let outputs = own.measured(graph, tensors.as_ref(), scalars.as_ref());
        OnnxStep { outputs, state: own.joined(graph, tensors, scalars) }
    }
}
