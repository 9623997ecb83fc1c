//! Samples of the default study, against the laws that its file and the guide state: each sampled
//! quantity that has no test beside its model. Freezing a factor or turning a part off changes
//! nothing else.

mod drawn_part;
mod driver;
mod mission;
mod point_event;
mod railway_crossing;
mod road;
mod switches;
mod weather;

use ocmc_core::random::Streams;

/// Cycles of a seed whose draws are compared with a law.
const CYCLES: u64 = 20_000;

/// The streams of each cycle of a seed.
fn cycles(seed: u64) -> impl Iterator<Item = Streams<'static>> {
    (0..CYCLES).map(move |cycle_id| Streams::new(seed, cycle_id))
}
