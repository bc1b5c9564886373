//! granum-nets
