//! The stretches of road between any two changes: where all tracks are constant.

use super::OperatingCycle;
use serde::Serialize;

/// No curve, no event.
const NONE: u32 = u32::MAX;
/// Changes closer than this are one, in m: a segment takes at least this long a way.
const SMALLEST_M: f64 = 1e-3;

/// A stretch on which every track of the operating cycle is constant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Segment {
    /// Where it starts, in m.
    pub start_m: f64,
    /// Its length, in m.
    pub length_m: f64,
    /// Index of the sign.
    pub sign: u32,
    /// Index of the section.
    pub section: u32,
    /// Index of the slope step.
    pub slope: u32,
    /// Index of the roughness block.
    pub roughness: u32,
    /// Index of the weather stretch.
    pub weather: u32,
    /// Index of the traffic stretch.
    pub traffic: u32,
    curve: u32,
    event: u32,
}

impl Segment {
    /// Index of the curve that it lies in.
    pub fn curve(&self) -> Option<usize> {
        (self.curve != NONE).then_some(self.curve as usize)
    }

    /// Index of the event at its start.
    pub fn event(&self) -> Option<usize> {
        (self.event != NONE).then_some(self.event as usize)
    }
}

impl OperatingCycle {
    /// Writes the segments of this cycle, in order and without gaps, into `segments`.
    pub fn segments(&self, segments: &mut Vec<Segment>) {
        segments.clear();
        let road = &self.road;
        let length_m = road.length_m;
        let mut now = Segment {
            start_m: 0.0,
            length_m: 0.0,
            sign: 0,
            section: 0,
            slope: 0,
            roughness: 0,
            weather: 0,
            traffic: 0,
            curve: NONE,
            event: NONE,
        };
        let (mut curve, mut event) = (0, 0);
        loop {
            // what holds from here on
            let here = now.start_m + SMALLEST_M;
            while (now.sign as usize + 1) < road.signs.len()
                && road.signs[now.sign as usize + 1].start_m <= here
            {
                now.sign += 1;
            }
            while road.sections[now.section as usize].end_m <= here
                && (now.section as usize + 1) < road.sections.len()
            {
                now.section += 1;
            }
            while (now.weather as usize + 1) < self.weather.len()
                && self.weather[now.weather as usize + 1].start_m <= here
            {
                now.weather += 1;
            }
            while (now.traffic as usize + 1) < self.traffic.len()
                && self.traffic[now.traffic as usize + 1].start_m <= here
            {
                now.traffic += 1;
            }
            while f64::from(now.slope + 1) * road.slope_step_m <= here
                && (now.slope as usize + 1) < road.slopes.len()
            {
                now.slope += 1;
            }
            while f64::from(now.roughness + 1) * road.roughness_block_m <= here
                && (now.roughness as usize + 1) < road.roughness_m3.len()
            {
                now.roughness += 1;
            }
            while curve < road.curves.len() && road.curves[curve].end_m <= here {
                curve += 1;
            }
            now.event = NONE;
            while event < road.events.len() && road.events[event].position_m <= here {
                now.event = event as u32;
                event += 1;
            }

            // where the next change is
            let mut end_m = length_m;
            let mut ends_at = |position_m: f64| {
                if position_m > here && position_m < end_m {
                    end_m = position_m;
                }
            };
            ends_at(f64::from(now.slope + 1) * road.slope_step_m);
            ends_at(f64::from(now.roughness + 1) * road.roughness_block_m);
            ends_at(road.sections[now.section as usize].end_m);
            if let Some(sign) = road.signs.get(now.sign as usize + 1) {
                ends_at(sign.start_m);
            }
            if let Some(weather) = self.weather.get(now.weather as usize + 1) {
                ends_at(weather.start_m);
            }
            if let Some(traffic) = self.traffic.get(now.traffic as usize + 1) {
                ends_at(traffic.start_m);
            }
            if let Some(event) = road.events.get(event) {
                ends_at(event.position_m);
            }
            now.curve = NONE;
            if let Some(next) = road.curves.get(curve) {
                if next.start_m <= here {
                    now.curve = curve as u32;
                    ends_at(next.end_m);
                } else {
                    ends_at(next.start_m);
                }
            }
            if length_m - end_m < SMALLEST_M {
                end_m = length_m;
            }
            now.length_m = end_m - now.start_m;
            segments.push(now);
            if end_m >= length_m {
                return;
            }
            now.start_m = end_m;
        }
    }
}
