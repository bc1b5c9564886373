//! The sizes of a gated recurrent unit and the places of its weights.

/// Numbers of inputs, start values, hidden neurons and outputs, from which the places of the weights follow.
///
/// All weights of a neuron are stored together, with its bias between the weights of the inputs and those of the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct GruShape {
    pub inputs: usize,
    pub starts: usize,
    pub hidden: usize,
    pub outputs: usize,
}

impl GruShape {
    /// Number of weights of a neuron of the gates: inputs, bias, state.
    pub fn gate_row(&self) -> usize {
        self.inputs + 1 + self.hidden
    }

    /// Number of weights of a neuron that receives the state: bias, state.
    pub fn state_row(&self) -> usize {
        1 + self.hidden
    }

    /// First weight of the part of the candidate that receives the inputs; before it are those of the reset gates and the
    /// update gates.
    pub fn candidate_inputs(&self) -> usize {
        2 * self.hidden * self.gate_row()
    }

    /// First weight of the part of the candidate that receives the state.
    pub fn candidate_state(&self) -> usize {
        self.candidate_inputs() + self.hidden * (self.inputs + 1)
    }

    /// First weight of the read-out.
    pub fn read_out(&self) -> usize {
        self.candidate_state() + self.hidden * self.state_row()
    }

    /// First weight of the first state, whose neurons have the weights of the start values and then the bias.
    pub fn first_state(&self) -> usize {
        self.read_out() + self.outputs * self.state_row()
    }

    /// Number of weights.
    pub fn weights(&self) -> usize {
        self.first_state() + self.hidden * (self.starts + 1)
    }
}
