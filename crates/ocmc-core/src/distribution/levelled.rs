//! A law that is drawn at a level of its own, or whose values differ between trucks.
//!
//! x = f exp(s_ln z) + s z, within the range of the law: f a draw of the law, z a standard normal
//! of the truck, s its `truck_sd` and s_ln its `truck_log_sd`, of which a law has one. Between
//! trucks the standard deviation of the means is then about s, or s_ln times the mean; within a
//! truck it is that of the law. The median of the fleet stays where it was.

use super::{Law, RARE};
use crate::random::nesting::Level;
use crate::random::{Draws, Stream, Streams};
use crate::special_functions::normal_quantile;
use serde::Serialize;

/// A law, and how its draws belong to trucks and drivers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LevelledLaw {
    /// The law.
    #[serde(flatten)]
    pub law: Law,
    /// Where it is drawn; none for where the other quantities of its kind are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level: Option<Level>,
    /// Standard deviation between trucks, in the unit of the law.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub truck_sd: Option<f64>,
    /// Standard deviation between trucks of the logarithm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub truck_log_sd: Option<f64>,
}

/// The keys that a law has beside its own.
pub const LEVEL_KEYS: [&str; 3] = ["level", "truck_sd", "truck_log_sd"];

impl LevelledLaw {
    /// One draw from the draws of a stream, which go on behind it as behind a draw of the law.
    pub fn sample(&self, streams: &Streams, stream: Stream, draws: &mut Draws) -> f64 {
        let mut own = self.level.map(|level| streams.open_beside(stream, level, draws));
        let is_moved = self.truck_sd.is_some() || self.truck_log_sd.is_some();
        let z = if is_moved { streams.truck_effect(stream, draws) } else { 0.0 };
        let drawn = self.law.sample(draws);
        self.moved(own.as_mut().map_or(drawn, |own| self.law.sample(own)), z)
    }

    /// A draw of the law as one truck has it, whose standard normal is `z`.
    fn moved(&self, drawn: f64, z: f64) -> f64 {
        let rarest = normal_quantile(1.0 - RARE);
        let z = z.clamp(-rarest, rarest);
        let moved = match (self.truck_sd, self.truck_log_sd) {
            (Some(sd), _) => drawn + sd * z,
            (_, Some(log_sd)) => drawn * libm::exp(log_sd * z),
            _ => return drawn,
        };
        let (low, high) = self.law.support();
        moved.clamp(low, high)
    }

    /// As [`Law::practical_range`], over all trucks.
    pub fn practical_range(&self) -> (f64, f64) {
        let (low, high) = self.law.practical_range();
        let far = f64::INFINITY;
        (
            self.moved(low, -far).min(self.moved(low, far)),
            self.moved(high, -far).max(self.moved(high, far)),
        )
    }

    /// Fault of the law: (parameter, value, what is allowed).
    pub fn fault(&self) -> Option<(&'static str, f64, &'static str)> {
        if let Some(fault) = self.law.fault() {
            return Some(fault);
        }
        for (name, sd) in [("truck_sd", self.truck_sd), ("truck_log_sd", self.truck_log_sd)] {
            if let Some(sd) = sd
                && !(0.0..=f64::MAX).contains(&sd)
            {
                return Some((name, sd, "0 or more"));
            }
        }
        match (self.truck_sd, self.truck_log_sd) {
            (Some(_), Some(log_sd)) => {
                Some(("truck_log_sd", log_sd, "one of `truck_sd` and `truck_log_sd`"))
            }
            (_, Some(log_sd)) if self.law.support().0 < 0.0 => {
                Some(("truck_log_sd", log_sd, "a law without negative values, or `truck_sd`"))
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distribution::Quantity;
    use crate::random::nesting::{Drivers, Nesting};

    const PAYLOAD: &str = r#"{"distribution":"mixture","weights":[0.2,0.8],
        "components":[0.0,{"distribution":"beta","alpha":4.0,"beta":2.0,"scale":20000.0}]"#;

    fn quantity(text: &str) -> Quantity {
        serde_json::from_str(text).expect("a law")
    }

    fn nesting(trips_per_truck: u64) -> Nesting {
        Nesting { trips_per_truck, ..Nesting::NONE }
    }

    fn draw(law: &Quantity, nesting: &Nesting, cycle_id: u64) -> f64 {
        let streams = Streams { nesting, ..Streams::new(1, cycle_id) };
        law.sample_once(&streams, Stream::Payload, &mut streams.open(Stream::Payload))
    }

    #[test]
    fn a_level_is_read_and_written_beside_the_law() {
        let text = format!(r#"{PAYLOAD},"level":"truck"}}"#);
        let law = quantity(&text);
        let Quantity::Levelled(levelled) = &law else { panic!("{law:?}") };
        assert_eq!(levelled.level, Some(Level::Truck));
        let written = serde_json::to_value(&law).expect("a value");
        assert_eq!(written, serde_json::from_str::<serde_json::Value>(&text).expect("a value"));
        assert!(matches!(quantity(&format!("{PAYLOAD}}}")), Quantity::Law(_)));
        for wrong in [r#","level":"lorry"}"#, r#","truck_sd":"x"}"#, r#","trucks_sd":1}"#] {
            let read = serde_json::from_str::<Quantity>(&format!("{PAYLOAD}{wrong}"));
            assert!(read.is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_truck_keeps_what_is_drawn_for_trucks() {
        let (own, shared) = (quantity(&format!("{PAYLOAD}}}")), format!("{PAYLOAD},\"level\":"));
        let of_truck = quantity(&format!(r#"{shared}"truck"}}"#));
        let of_driver = quantity(&format!(r#"{shared}"driver"}}"#));
        let ten = &nesting(10);
        let two = &Nesting { drivers: Drivers::OfTruck(2), ..nesting(10) };
        for truck in 0..20 {
            let value = |law, nesting, trip| draw(law, nesting, 10 * truck + trip);
            assert!((1..10).all(|trip| value(&of_truck, ten, trip) == value(&of_truck, ten, 0)));
            assert!(
                (2..10)
                    .all(|trip| value(&of_driver, two, trip) == value(&of_driver, two, trip - 2))
            );
            assert!((1..10).any(|trip| value(&own, ten, trip) != value(&own, ten, 0)));
            // a truck of one trip: whatever the level, the draw is the cycle's
            let alone = draw(&own, &Nesting::NONE, truck);
            assert!(draw(&of_truck, &Nesting::NONE, truck) == alone);
            assert!(value(&of_truck, ten, 0) == alone && value(&own, ten, 0) == alone);
        }
    }

    #[test]
    fn the_next_quantity_of_the_stream_does_not_notice_a_level() {
        let gamma = r#"{"distribution":"gamma","mean":3.0,"shape":0.7"#;
        let (plain, other) =
            (quantity(&format!("{gamma}}}")), quantity(&format!(r#"{gamma},"level":"trip"}}"#)));
        let nesting = &nesting(7);
        for cycle_id in 0..50 {
            let streams = Streams { nesting, ..Streams::new(3, cycle_id) };
            let next = |law: &Quantity| {
                let mut draws = streams.open(Stream::Vehicle);
                law.sample_once(&streams, Stream::Vehicle, &mut draws);
                draws.uniform()
            };
            assert!(next(&plain) == next(&other));
        }
    }

    #[test]
    fn spread_between_and_within_trucks_is_what_was_set() {
        // x = 10 + 2 z_truck + 3 z_trip: means of 50 trips have the variance 4 + 9/50
        const TRIPS: u64 = 50;
        const TRUCKS: u64 = 4000;
        let law = quantity(r#"{"distribution":"normal","mean":10.0,"sd":3.0,"truck_sd":2.0}"#);
        let nesting = &nesting(TRIPS);
        let (mut between, mut within) = (0.0, 0.0);
        for truck in 0..TRUCKS {
            let values: Vec<f64> =
                (0..TRIPS).map(|trip| draw(&law, nesting, truck * TRIPS + trip)).collect();
            let mean = values.iter().sum::<f64>() / TRIPS as f64;
            between += (mean - 10.0) * (mean - 10.0) / TRUCKS as f64;
            within += values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>()
                / ((TRIPS - 1) * TRUCKS) as f64;
        }
        // relative standard error of a variance of n values: √(2/n)
        let near = |estimate: f64, known: f64, n: f64| {
            assert!((estimate / known - 1.0).abs() < 4.0 * (2.0 / n).sqrt(), "{estimate} {known}");
        };
        near(between, 4.0 + 9.0 / TRIPS as f64, TRUCKS as f64);
        near(within, 9.0, ((TRIPS - 1) * TRUCKS) as f64);
    }

    #[test]
    fn a_factor_of_the_truck_keeps_empty_trips_empty_and_loads_within_the_law() {
        let law = quantity(&format!(r#"{PAYLOAD},"truck_log_sd":0.5}}"#));
        let plain = quantity(&format!("{PAYLOAD}}}"));
        let nesting = &nesting(40);
        for cycle_id in 0..2000 {
            let (moved, drawn) = (draw(&law, nesting, cycle_id), draw(&plain, nesting, cycle_id));
            assert_eq!(moved == 0.0, drawn == 0.0);
            assert!((0.0..=20_000.0).contains(&moved));
        }
    }

    #[test]
    fn faults_are_named() {
        let fault = |text: &str| {
            let Quantity::Levelled(law) = quantity(text) else { panic!("{text}") };
            law.fault().map(|(name, ..)| name)
        };
        let normal = r#"{"distribution":"normal","mean":10.0,"sd":3.0"#;
        assert_eq!(fault(&format!(r#"{normal},"truck_sd":-1.0}}"#)), Some("truck_sd"));
        assert_eq!(fault(&format!(r#"{normal},"truck_log_sd":0.1}}"#)), Some("truck_log_sd"));
        let both = format!(r#"{normal},"lower":0.0,"truck_sd":1.0,"truck_log_sd":0.1}}"#);
        assert_eq!(fault(&both), Some("truck_log_sd"));
        assert_eq!(fault(&format!(r#"{normal},"truck_sd":1.0}}"#)), None);
    }
}
