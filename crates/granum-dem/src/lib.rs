//! granum-dem
