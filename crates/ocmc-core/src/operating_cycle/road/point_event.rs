//! Point events: stop signs, give-way signs, traffic lights and speed bumps, as marked Poisson
//! processes.
//!
//! Gaps are exponential with the intensity of the road type; marks are independent. A Poisson
//! process has no minimum spacing, so of two events closer than the study's spacing the later one
//! is dropped, and the first and last metres of the road stay free. Signals are not coordinated.
//!
//! A share of the junction events carries a turn, R = r₀ + exp(N(ln median, σ²)), over a length R
//! π/2 U(f, 1), because there the truck leaves the road it was on.

use super::curvature::Curve;
use super::road_type::Section;
use crate::distribution::Quantity;
use crate::random::Draws;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_2;

/// Stop signs of one road type.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StopSignModel {
    /// Intensity, per m.
    #[schemars(range(min = 0.0, max = 0.02))]
    pub per_m: f64,
    /// Standstill, in s.
    #[schemars(range(min = 0.0, max = 3600.0))]
    pub standstill_s: Quantity,
    /// Share that carries a junction turn.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub turn_share: f64,
}

/// Give-way signs (roundabouts included) of one road type.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GiveWayModel {
    /// Intensity, per m.
    #[schemars(range(min = 0.0, max = 0.02))]
    pub per_m: f64,
    /// Probability that the truck has to stop.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub stop_probability: f64,
    /// Wait when it stops, in s.
    #[schemars(range(min = 0.0, max = 3600.0))]
    pub wait_s: Quantity,
    /// Speed at which it passes when it does not stop, in m/s.
    #[schemars(range(min = 1.0, max = 40.0))]
    pub pass_speed_mps: Quantity,
    /// Share that carries a junction turn.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub turn_share: f64,
}

/// Traffic lights of one road type.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrafficLightModel {
    /// Intensity, per m.
    #[schemars(range(min = 0.0, max = 0.02))]
    pub per_m: f64,
    /// Probability of red.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub red_probability: f64,
    /// Wait at red, in s.
    #[schemars(range(min = 0.0, max = 3600.0))]
    pub wait_s: Quantity,
    /// Share that carries a junction turn.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub turn_share: f64,
}

/// Speed bumps of one road type.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpeedBumpModel {
    /// Intensity, per m.
    #[schemars(range(min = 0.0, max = 0.02))]
    pub per_m: f64,
    /// Length, in m.
    #[schemars(range(min = 0.1, max = 50.0))]
    pub length_m: Quantity,
    /// Height, in m.
    #[schemars(range(min = 0.005, max = 0.5))]
    pub height_m: Quantity,
}

/// Turns taken at junctions, the same for all road types.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JunctionTurnModel {
    /// Smallest radius r₀, in m.
    #[schemars(range(min = 5.0, max = 200.0))]
    pub turn_radius_m: f64,
    /// Median of R − r₀, in m.
    #[schemars(range(min = 0.1, max = 200.0))]
    pub median_radius_m: f64,
    /// Standard deviation of ln(R − r₀).
    #[schemars(range(min = 0.0, max = 2.0))]
    pub radius_log_sd: f64,
    /// Shortest turn as a share f of a right angle.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub minimum_share: f64,
}

/// What happens at one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EventKind {
    /// A stop sign with its standstill, in s.
    StopSign {
        /// Standstill, in s.
        standstill_s: f64,
    },
    /// A give-way sign at which the truck stops.
    GiveWayStop {
        /// Wait, in s.
        standstill_s: f64,
    },
    /// A give-way sign that is passed slowly.
    GiveWayPass {
        /// Speed, in m/s.
        speed_mps: f64,
    },
    /// A red light.
    RedLight {
        /// Wait, in s.
        standstill_s: f64,
    },
    /// A green light: no constraint.
    GreenLight,
    /// A speed bump.
    SpeedBump {
        /// Length, in m.
        length_m: f64,
        /// Height, in m.
        height_m: f64,
    },
    /// A stop of the mission: unloading, rest.
    MissionStop {
        /// Dwell, in s.
        standstill_s: f64,
    },
}

/// An event at a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointEvent {
    /// Where, in m.
    pub position_m: f64,
    /// What.
    pub kind: EventKind,
    /// Whether the truck turns there into another road.
    pub turns: bool,
}

impl EventKind {
    /// Time at rest, in s; none where the truck need not stop.
    pub fn standstill_s(&self) -> Option<f64> {
        match self {
            Self::StopSign { standstill_s }
            | Self::GiveWayStop { standstill_s }
            | Self::RedLight { standstill_s }
            | Self::MissionStop { standstill_s } => Some(*standstill_s),
            Self::GiveWayPass { .. } | Self::GreenLight | Self::SpeedBump { .. } => None,
        }
    }
}

impl StopSignModel {
    /// Appends the stop signs of one section.
    pub fn sample(&self, section: &Section, draws: &mut Draws, events: &mut Vec<PointEvent>) {
        poisson(self.per_m, section, draws, events, |draws| {
            let kind = EventKind::StopSign { standstill_s: self.standstill_s.sample(draws) };
            (kind, draws.happens(self.turn_share))
        });
    }
}

impl GiveWayModel {
    /// Appends the give-way signs of one section.
    pub fn sample(&self, section: &Section, draws: &mut Draws, events: &mut Vec<PointEvent>) {
        poisson(self.per_m, section, draws, events, |draws| {
            let kind = if draws.happens(self.stop_probability) {
                EventKind::GiveWayStop { standstill_s: self.wait_s.sample(draws) }
            } else {
                EventKind::GiveWayPass { speed_mps: self.pass_speed_mps.sample(draws) }
            };
            (kind, draws.happens(self.turn_share))
        });
    }
}

impl TrafficLightModel {
    /// Appends the traffic lights of one section.
    pub fn sample(&self, section: &Section, draws: &mut Draws, events: &mut Vec<PointEvent>) {
        poisson(self.per_m, section, draws, events, |draws| {
            let kind = if draws.happens(self.red_probability) {
                EventKind::RedLight { standstill_s: self.wait_s.sample(draws) }
            } else {
                EventKind::GreenLight
            };
            (kind, draws.happens(self.turn_share))
        });
    }
}

impl SpeedBumpModel {
    /// Appends the speed bumps of one section.
    pub fn sample(&self, section: &Section, draws: &mut Draws, events: &mut Vec<PointEvent>) {
        poisson(self.per_m, section, draws, events, |draws| {
            let length_m = self.length_m.sample(draws);
            let height_m = self.height_m.sample(draws);
            (EventKind::SpeedBump { length_m, height_m }, false)
        });
    }
}

impl JunctionTurnModel {
    /// The turn that begins at `position_m`.
    pub fn sample(&self, position_m: f64, draws: &mut Draws) -> Curve {
        let radius_m = self.turn_radius_m
            + self.median_radius_m * libm::exp(self.radius_log_sd * draws.normal());
        let angle = FRAC_PI_2 * draws.uniform_between(self.minimum_share, 1.0);
        let left = draws.happens(0.5);
        Curve { start_m: position_m, end_m: position_m + angle * radius_m, radius_m, left }
    }
}

/// A marked Poisson process on one section.
fn poisson(
    per_m: f64,
    section: &Section,
    draws: &mut Draws,
    events: &mut Vec<PointEvent>,
    mark: impl Fn(&mut Draws) -> (EventKind, bool),
) {
    if per_m <= 0.0 {
        return;
    }
    let mut position_m = section.start_m;
    loop {
        position_m += draws.exponential() / per_m;
        if position_m >= section.end_m {
            return;
        }
        let (kind, turns) = mark(draws);
        events.push(PointEvent { position_m, kind, turns });
    }
}

/// Puts events in order, keeps the ends of the road free, and drops the later one of two events
/// that are closer than the spacing. A mission stop between the ends is never dropped; what else
/// stands too close to it is.
pub fn space_out(events: &mut Vec<PointEvent>, length_m: f64, spacing_m: f64, free_end_m: f64) {
    events.retain(|e| e.position_m >= free_end_m && e.position_m <= length_m - free_end_m);
    events.sort_by(|a, b| a.position_m.total_cmp(&b.position_m));
    let mut kept: Vec<PointEvent> = Vec::with_capacity(events.len());
    let of_mission = |event: &PointEvent| matches!(event.kind, EventKind::MissionStop { .. });
    for event in events.drain(..) {
        let close = kept.last().filter(|last| event.position_m - last.position_m < spacing_m);
        match close {
            Some(_) if !of_mission(&event) => continue,
            Some(last) if !of_mission(last) => kept.truncate(kept.len() - 1),
            _ => {}
        }
        kept.push(event);
    }
    *events = kept;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;

    #[test]
    fn mission_stops_stay_and_push_others_away() {
        let event = |position_m: f64, kind| PointEvent { position_m, kind, turns: false };
        let stop = |at_m| event(at_m, EventKind::MissionStop { standstill_s: 60.0 });
        let sign = |at_m| event(at_m, EventKind::StopSign { standstill_s: 2.0 });
        let mut events =
            vec![stop(5.0), sign(460.0), stop(500.0), stop(560.0), sign(600.0), sign(700.0)];
        space_out(&mut events, 1000.0, 100.0, 20.0);
        assert_eq!(events, [stop(500.0), stop(560.0), sign(700.0)]);
    }

    #[test]
    fn counts_and_marks_within_four_standard_errors() {
        let model = GiveWayModel {
            per_m: 0.5e-3,
            stop_probability: 0.3,
            wait_s: Quantity::Law(crate::distribution::Law::Exponential { mean: 6.0 }),
            pass_speed_mps: Quantity::Law(crate::distribution::Law::Uniform {
                lower: 5.5,
                upper: 7.0,
            }),
            turn_share: 0.25,
        };
        let section = Section { start_m: 0.0, end_m: 1.0e7, road_type: 0 };
        for seed in 1..=3 {
            let mut events = Vec::new();
            model.sample(&section, &mut Draws::new(seed, 0, Stream::GiveWay), &mut events);
            let n = events.len() as f64;
            assert!((n - 5000.0).abs() < 4.0 * 5000f64.sqrt());
            let waits: Vec<f64> = events.iter().filter_map(|e| e.kind.standstill_s()).collect();
            let m = waits.len() as f64;
            assert!((m / n - 0.3).abs() < 4.0 * (0.21 / n).sqrt());
            let mean = waits.iter().sum::<f64>() / m;
            assert!((mean - 6.0).abs() < 4.0 * 6.0 / m.sqrt());
            let turns = events.iter().filter(|e| e.turns).count() as f64;
            assert!((turns / n - 0.25).abs() < 4.0 * (0.1875 / n).sqrt());
        }
    }

    #[test]
    fn the_later_of_two_close_events_goes() {
        let at = |position_m| PointEvent { position_m, kind: EventKind::GreenLight, turns: false };
        let mut events = vec![at(10.0), at(100.0), at(120.0), at(131.0), at(990.0)];
        space_out(&mut events, 1000.0, 30.0, 30.0);
        let places: Vec<f64> = events.iter().map(|e| e.position_m).collect();
        assert_eq!(places, [100.0, 131.0]);
    }
}
