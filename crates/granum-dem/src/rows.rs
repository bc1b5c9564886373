//! Rows of numbers in a checkpoint, written as one flat list without field names, which makes the checkpoint smaller.

macro_rules! flat {
    ($name:ident, $row:ident, $width:literal) => {
        pub(crate) mod $name {
            use granum_simd::$row;
            use serde::{Deserialize, Deserializer, Serializer, de::Error};

            pub(crate) fn serialize<S: Serializer>(rows: &[$row], to: S) -> Result<S::Ok, S::Error> {
                to.collect_seq(rows.iter().flat_map(|r| r.0))
            }

            pub(crate) fn deserialize<'d, D: Deserializer<'d>>(from: D) -> Result<Vec<$row>, D::Error> {
                let flat = Vec::<f64>::deserialize(from)?;
                let (rows, rest) = flat.as_chunks::<$width>();
                if !rest.is_empty() {
                    return Err(D::Error::custom("rows are not whole"));
                }
                Ok(rows.iter().map(|r| $row(*r)).collect())
            }
        }
    };
}
flat!(eight, Row8, 8);
flat!(four, Row4, 4);
