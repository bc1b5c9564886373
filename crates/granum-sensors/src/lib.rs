//! granum-sensors
