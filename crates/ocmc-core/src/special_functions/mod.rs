//! Special functions, with the same bits on every platform.

mod normal_quantile;

pub use normal_quantile::{normal_quantile, normal_quantiles};
