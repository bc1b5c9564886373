//! The members of a table, from which mini-batches and validation rows are chosen: sequences, or observations if there are
//! no sequences.

use std::ops::Range;

use crate::table::data::Data;
use crate::table::data_error::DataError;
use crate::table::sequences::Sequences;

impl Data {
    /// Number of members, the units that a mini-batch is made of: sequences, or observations if there are no sequences.
    pub fn members(&self) -> usize {
        self.sequences.as_ref().map_or(self.rows / self.points, Sequences::len)
    }

    /// The chosen members in the given order, with the weights of their rows and without validation rows.
    ///
    /// # Errors
    /// If none is chosen, or one does not exist.
    pub fn only_members(&self, chosen: &[usize]) -> Result<Data, DataError> {
        if chosen.is_empty() {
            return Err(DataError::Shape("a part of a table needs at least one of its members".into()));
        }
        if let Some(member) = chosen.iter().find(|&&member| member >= self.members()) {
            let members = self.members();
            return Err(DataError::Shape(format!("there is no member {member} of {members}, from 0")));
        }
        let ranges: Vec<Range<usize>> = match &self.sequences {
            Some(sequences) => {
                let all = sequences.ranges();
                chosen.iter().map(|&member| all[member].clone()).collect()
            }
            None => chosen.iter().map(|&member| member * self.points..(member + 1) * self.points).collect(),
        };
        let gather = |values: &[f64], columns: usize| -> Vec<f64> {
            let part = |rows: &Range<usize>| &values[rows.start * columns..rows.end * columns];
            ranges.iter().flat_map(part).copied().collect()
        };
        let weights = self.weights.as_ref().map(|weights| gather(weights, 1));
        let rows = ranges.iter().map(ExactSizeIterator::len).sum();
        let blocks = match self.blocks.is_empty() {
            true => Vec::new(),
            false => ranges.iter().flat_map(|rows| rows.clone().step_by(self.points)).collect(),
        };
        Ok(Data {
            rows,
            inputs: gather(&self.inputs, self.input_columns),
            targets: gather(&self.targets, self.target_columns),
            observations: weights
                .as_ref()
                .map_or((rows / self.points) as f64, |weights| weights.iter().sum()),
            weights,
            blocks: blocks.into_iter().map(|row| self.blocks[row / self.points]).collect(),
            sequences: self.sequences.as_ref().map(|sequences| sequences.chosen(chosen)),
            validation: None,
            ..*self
        })
    }

    /// Number of the block (run) of each member: that of its first row, or the number of the member if blocks were not set.
    fn block_of_members(&self) -> Vec<usize> {
        let first_rows: Vec<usize> = match &self.sequences {
            Some(sequences) => sequences.ranges().iter().map(|rows| rows.start).collect(),
            None => (0..self.members()).collect(),
        };
        let block = |(member, &row): (usize, &usize)| self.blocks.get(row).copied().unwrap_or(member);
        first_rows.iter().enumerate().map(block).collect()
    }

    /// Uses all rows of the given blocks (runs) as validation rows, so that training stops before it fits what is peculiar
    /// to the other blocks.
    ///
    /// ```
    /// use granum_nets::Data;
    ///
    /// let data = Data::new((0..6).map(f64::from).collect(), 1, vec![0.5; 6])?.with_blocks(vec![0, 0, 1, 1, 2, 2])?;
    /// let data = data.with_validation_blocks(&[1])?;
    /// assert_eq!((data.rows(), data.validation().unwrap().inputs()), (4, &[2.0, 3.0][..]));
    /// # Ok::<(), granum_nets::DataError>(())
    /// ```
    ///
    /// # Errors
    /// If no row, or no other row, belongs to these blocks.
    pub fn with_validation_blocks(self, blocks: &[usize]) -> Result<Data, DataError> {
        let members = self.block_of_members();
        let (kept, others): (Vec<usize>, Vec<usize>) =
            (0..members.len()).partition(|&member| !blocks.contains(&members[member]));
        let validation = self.only_members(&others)?;
        self.only_members(&kept)?.with_validation(validation)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn members_are_sequences_or_observations() {
        let inputs: Vec<f64> = (0..12).map(f64::from).collect();
        let data = Data::new(inputs, 2, (0..6).map(f64::from).collect()).unwrap();
        let part = data.only_members(&[4, 0]).unwrap();
        assert_eq!((part.inputs(), part.targets()), (&[8.0, 9.0, 0.0, 1.0][..], &[4.0, 0.0][..]));

        let sequences = Sequences::new(vec![1, 3, 2]).unwrap().with_starts(vec![0.1, 0.2, 0.3], 1).unwrap();
        let sequences = data.clone().with_weights(vec![1.0; 6]).unwrap().with_sequences(sequences).unwrap();
        assert_eq!((data.members(), sequences.members()), (6, 3));
        let part = sequences.only_members(&[2, 1]).unwrap();
        assert_eq!(part.targets(), [4.0, 5.0, 1.0, 2.0, 3.0]);
        assert_eq!(part.sequences().unwrap().lengths(), [2, 3]);
        assert_eq!(part.sequences().unwrap().starts(), [0.3, 0.2]);
        assert_eq!((part.observations(), part.weights()), (5.0, Some(&[1.0; 5][..])));
        assert!(sequences.only_members(&[3]).unwrap_err().to_string().contains("no member 3 of 3"));
        assert!(sequences.only_members(&[]).is_err());
        assert!(data.clone().with_sequences(Sequences::new(vec![5]).unwrap()).is_err());

        let points = Data::new((0..6).map(f64::from).collect(), 1, vec![0.0; 6]).unwrap();
        let points = points.with_points(2).unwrap().with_blocks(vec![7, 8, 7]).unwrap();
        let part = points.only_members(&[2, 1]).unwrap();
        assert_eq!((part.inputs(), part.blocks()), (&[4.0, 5.0, 2.0, 3.0][..], &[7, 8][..]));
        assert_eq!(part.observations(), 2.0);
    }

    #[test]
    fn whole_blocks_are_held_out() {
        let data = Data::new((0..6).map(f64::from).collect(), 1, vec![0.0; 6]).unwrap();
        let held = |data: Data, blocks: &[usize]| {
            let data = data.with_validation_blocks(blocks)?;
            Ok::<_, DataError>((data.inputs().to_vec(), data.validation().unwrap().inputs().to_vec()))
        };
        let blocks = data.clone().with_blocks(vec![3, 3, 5, 5, 5, 9]).unwrap();
        assert_eq!(held(blocks.clone(), &[5]).unwrap(), (vec![0.0, 1.0, 5.0], vec![2.0, 3.0, 4.0]));
        assert!(held(blocks.clone(), &[3, 5, 9]).is_err() && held(blocks, &[4]).is_err());
        // Without blocks, each sequence is one.
        let sequences = data.with_sequences(Sequences::new(vec![2, 4]).unwrap()).unwrap();
        assert_eq!(held(sequences, &[0]).unwrap(), (vec![2.0, 3.0, 4.0, 5.0], vec![0.0, 1.0]));
    }
}
