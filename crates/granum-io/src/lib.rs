//! granum-io
