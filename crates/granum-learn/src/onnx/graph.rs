//! A graph of operators on tables of doubles, one row for each state.

use super::messages::*;

/// Version of the operators (`ai.onnx`).
pub const OPSET: i64 = 17;
/// What the number of rows is called.
const ROWS: &str = "rows";

/// A tensor of a graph.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Value(String);

/// The graph of a surrogate. Tensors are tables of doubles with any number of rows; operators are those of `ai.onnx` in the version [`OPSET`].
#[derive(Clone, Debug, Default)]
pub struct OnnxGraph {
    graph: GraphProto,
    metadata: Vec<(String, String)>,
    values: usize,
}

impl OnnxGraph {
    /// An input of so many columns, with what it is.
    pub fn input(&mut self, name: &str, columns: usize, what: &str) -> Value {
        self.graph.input.push(table(name, columns, what));
        Value(name.to_owned())
    }

    /// Gives a table of so many columns as an output.
    pub fn output(&mut self, name: &str, columns: usize, what: &str, value: &Value) {
        self.graph.node.push(node("Identity", &[value], name, Vec::new()));
        self.graph.output.push(table(name, columns, what));
    }

    /// A constant of a shape, in row-major order.
    pub fn constant(&mut self, shape: &[usize], values: &[f64]) -> Value {
        debug_assert_eq!(shape.iter().product::<usize>(), values.len());
        let data = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.initializer(shape, DOUBLE, data)
    }

    /// A number.
    pub fn number(&mut self, value: f64) -> Value {
        self.constant(&[], &[value])
    }

    /// A row of numbers, for operators that act on every row of a table.
    pub fn row(&mut self, values: &[f64]) -> Value {
        self.constant(&[1, values.len()], values)
    }

    /// Integers, such as axes and shapes.
    pub fn integers(&mut self, values: &[i64]) -> Value {
        let data = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.initializer(&[values.len()], INT64, data)
    }

    /// The result of an operator.
    pub fn apply(&mut self, operator: &str, inputs: &[&Value]) -> Value {
        self.apply_with(operator, inputs, &[])
    }

    /// The result of an operator with integers as attributes.
    pub fn apply_with(&mut self, operator: &str, inputs: &[&Value], attributes: &[(&str, i64)]) -> Value {
        let attributes =
            attributes.iter().map(|(name, value)| AttributeProto::integer(name, *value)).collect();
        self.applied(operator, inputs, attributes)
    }

    /// A tensor with its axes in another order.
    pub fn transposed(&mut self, tensor: &Value, axes: &[i64]) -> Value {
        self.applied("Transpose", &[tensor], vec![AttributeProto::integers("perm", axes)])
    }

    fn applied(&mut self, operator: &str, inputs: &[&Value], attributes: Vec<AttributeProto>) -> Value {
        let name = self.next_name();
        self.graph.node.push(node(operator, inputs, &name, attributes));
        Value(name)
    }

    /// A tensor in another shape; the size -1 is the one that is left over.
    pub fn shaped(&mut self, tensor: &Value, shape: &[i64]) -> Value {
        let shape = self.integers(shape);
        self.apply("Reshape", &[tensor, &shape])
    }

    /// The least or the largest value of each row (`ReduceMin`, `ReduceMax`).
    pub fn extreme_of_rows(&mut self, operator: &str, table: &Value) -> Value {
        self.applied(operator, &[table], vec![AttributeProto::integers("axes", &[1])])
    }

    /// Tables one below the other.
    pub fn below(&mut self, tables: &[&Value]) -> Value {
        self.apply_with("Concat", tables, &[("axis", 0)])
    }

    /// The rows of a constant table of so many columns, in row-major order, whose numbers are given.
    pub fn rows_of(&mut self, table: &[f64], columns: usize, numbers: &Value) -> Value {
        let table = self.constant(&[table.len() / columns.max(1), columns], table);
        self.apply_with("Gather", &[&table, numbers], &[("axis", 0)])
    }

    /// Conditions or numbers as integers, or as doubles.
    pub fn cast(&mut self, values: &Value, to_integers: bool) -> Value {
        let to = if to_integers { INT64 } else { DOUBLE };
        self.apply_with("Cast", &[values], &[("to", i64::from(to))])
    }

    /// Tables side by side.
    pub fn beside(&mut self, tables: &[&Value]) -> Value {
        match tables {
            [only] => (*only).clone(),
            _ => self.apply_with("Concat", tables, &[("axis", 1)]),
        }
    }

    /// Some columns of a table.
    pub fn columns(&mut self, table: &Value, columns: &[usize]) -> Value {
        let places: Vec<i64> = columns.iter().map(|column| *column as i64).collect();
        let places = self.integers(&places);
        self.apply_with("Gather", &[table, &places], &[("axis", 1)])
    }

    /// The sum of each row.
    pub fn sum_of_rows(&mut self, table: &Value) -> Value {
        let axis = self.integers(&[1]);
        self.apply("ReduceSum", &[table, &axis])
    }

    /// `table matrix + bias`, the matrix of `rows` rows in row-major order.
    pub fn linear(&mut self, table: &Value, rows: usize, matrix: &[f64], bias: Option<&[f64]>) -> Value {
        let columns = matrix.len() / rows.max(1);
        let matrix = self.constant(&[rows, columns], matrix);
        let product = self.apply("MatMul", &[table, &matrix]);
        match bias {
            None => product,
            Some(bias) => {
                let bias = self.row(bias);
                self.apply("Add", &[&product, &bias])
            }
        }
    }

    /// `factor (table - before) + after`, with a number for each column.
    pub fn scaled(&mut self, table: &Value, before: &[f64], factor: &[f64], after: &[f64]) -> Value {
        let [before, factor, after] = [before, factor, after].map(|numbers| self.row(numbers));
        let difference = self.apply("Sub", &[table, &before]);
        let product = self.apply("Mul", &[&difference, &factor]);
        self.apply("Add", &[&product, &after])
    }

    /// States a fact about the graph in its metadata.
    pub fn state(&mut self, key: &str, value: impl Into<String>) {
        self.metadata.push((key.to_owned(), value.into()));
    }

    /// What has been stated.
    pub fn metadata(&self) -> &[(String, String)] {
        &self.metadata
    }

    pub(crate) fn message(&self, name: &str) -> GraphProto {
        GraphProto { name: Some(name.to_owned()), ..self.graph.clone() }
    }

    fn initializer(&mut self, shape: &[usize], data_type: i32, data: Vec<u8>) -> Value {
        let name = self.next_name();
        self.graph.initializer.push(TensorProto {
            dims: shape.iter().map(|size| *size as i64).collect(),
            data_type: Some(data_type),
            name: Some(name.clone()),
            raw_data: Some(data),
        });
        Value(name)
    }

    /// A name that no column has: columns do not begin with a sign.
    fn next_name(&mut self) -> String {
        self.values += 1;
        format!("#{}", self.values)
    }
}

fn node(operator: &str, inputs: &[&Value], output: &str, attribute: Vec<AttributeProto>) -> NodeProto {
    NodeProto {
        input: inputs.iter().map(|value| value.0.clone()).collect(),
        output: vec![output.to_owned()],
        op_type: Some(operator.to_owned()),
        attribute,
    }
}

fn table(name: &str, columns: usize, what: &str) -> ValueInfoProto {
    let rows = DimensionProto { dim_value: None, dim_param: Some(ROWS.into()) };
    let columns = DimensionProto { dim_value: Some(columns as i64), dim_param: None };
    let shape = TensorShapeProto { dim: vec![rows, columns] };
    let tensor = TensorTypeProto { elem_type: Some(DOUBLE), shape: Some(shape) };
    ValueInfoProto {
        name: Some(name.to_owned()),
        r#type: Some(TypeProto { tensor_type: Some(tensor) }),
        doc_string: Some(what.to_owned()),
    }
}
