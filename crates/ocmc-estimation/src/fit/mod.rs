//! The inverse: from measurements to the numbers of a study.
//!
//! Estimators take plain columns and return numbers with their intervals; they read and print
//! nothing. The laws of `distribution` carry their own `fit`.

pub mod absorbed;
pub mod analysis_of_variance;
pub mod anderson_darling;
mod autocorrelated;
mod cluster_robust;
mod compensated_sum;
pub mod contrast;
pub mod curve_speed;
mod descent;
pub mod far_rows;
pub mod fleet;
pub mod least_squares;
pub mod mixed_model;
mod nelder_mead;
pub mod operating_cycle;
pub mod p_value;
pub mod profile_interval;
pub mod speed_change;
pub mod study_parameter;
pub mod tobit;
pub mod traffic;
mod traffic_speed;
pub mod weather;
