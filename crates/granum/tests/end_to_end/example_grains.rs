//! Flags of grains within the ranges of the families that come with the program.

/// A sand of which everything that is needed is given.
pub const SAND: [&str; 8] =
    ["--friction", "0.5", "--rolling-friction", "0.1", "--pressure", "100 kPa", "--youngs-modulus", "2 GPa"];

/// A powder of which everything that is needed is given.
pub const POWDER: [&str; 10] = [
    "--friction",
    "0.3",
    "--interface-energy",
    "5 mJ/m2",
    "--diameter",
    "10 um",
    "--pressure",
    "5 kPa",
    "--youngs-modulus",
    "200 MPa",
];

/// A sand of long grains.
pub const LONG_GRAINS: [&str; 8] =
    ["--aspect-ratio", "1.6", "--friction", "0.4", "--pressure", "100 kPa", "--youngs-modulus", "2 GPa"];
