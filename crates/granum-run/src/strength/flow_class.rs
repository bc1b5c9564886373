//! Classes of the flow of powders by the flow function coefficient `ff_c = sigma_1 / sigma_c`, after Jenike (Storage and flow of
//! solids, Bulletin 123, University of Utah, 1964), with the class "not flowing" that Schulze (Powders and Bulk Solids, 2008) added.

/// The flow function coefficient from which a powder is free-flowing.
pub const FREE_FLOWING: f64 = 10.0;

/// The class of a flow function coefficient.
///
/// ```
/// use granum_run::strength::flow_class;
///
/// assert_eq!((flow_class(0.9), flow_class(1.5), flow_class(3.0)), ("not flowing", "very cohesive", "cohesive"));
/// assert_eq!((flow_class(4.0), flow_class(12.0)), ("easy-flowing", "free-flowing"));
/// ```
pub fn flow_class(coefficient: f64) -> &'static str {
    match coefficient {
        ff if ff < 1.0 => "not flowing",
        ff if ff < 2.0 => "very cohesive",
        ff if ff < 4.0 => "cohesive",
        ff if ff < FREE_FLOWING => "easy-flowing",
        _ => "free-flowing",
    }
}
