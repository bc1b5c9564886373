//! granum-hybrid
