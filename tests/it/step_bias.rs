//! Effect of the default's long steps on a fleet's energies.

use crate::common::{run, study};
use ocmc_core::energy::Carrier;

#[test]
fn the_default_steps_are_near_steps_of_a_few_milliseconds() {
    // steps of 5 ms instead of 1 ms, so that it takes seconds: steps of 200 ms have a bias of 0.007
    // %
    let cycles = 32;
    let default = run(&study("field-truck", &[]), cycles);
    let short = run(&study("field-truck", &["simulation.step_s=0.005"]), cycles);
    let bias = |of: fn(&ocmc_core::record::Record) -> f64| {
        let pairs = default.iter().zip(&short);
        pairs.map(|(a, b)| (of(a) / of(b) - 1.0).abs()).sum::<f64>() / cycles as f64
    };
    let (wheel, fuel) =
        (bias(|r| r.wheel_energy_j), bias(|r| r.amount(Carrier::LiquidFuel).unwrap()));
    // fuel: since drivers follow rises with feed-forward some shifts come a step later
    // (docs/src/theory/simulation.md)
    assert!(wheel <= 5e-4 && fuel <= 8e-4, "{wheel} {fuel}");
}
