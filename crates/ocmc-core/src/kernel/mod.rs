//! The closed loop: one step of trucks side by side (`step`), what happens to a truck at places of
//! its trip (`trip`), and how lanes are filled and driven (`drive`). Each room imports those before
//! it alone.
//!
//! Checked: the mean absolute bias of the default study is below 0.05 % (`tests/it/step_bias.rs`).
//! The balance of 200 cycles of each built-in study closes to 1e-9, and a trace sums up to its
//! record exactly (`tests/it/energy_balance.rs`). Constant speed equals the closed form to 1e-6,
//! with second order on a smooth case (`tests/it/closed_form.rs`). No cycle of 10,000 of the
//! default study stalls (`tests/it/closed_loop.rs`). Each part that is turned off changes the
//! records in the right direction and leaves all other draws alone (`tests/it/parts.rs`). Bytes are
//! the same for 1, 2 and 8 threads, five chunk sizes and all CPU levels
//! (`tests/it/determinism.rs`).

pub mod drive;
pub mod step;
pub mod trip;
