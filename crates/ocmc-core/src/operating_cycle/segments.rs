//! The stretches of road between any two changes: where all tracks are constant.

use super::OperatingCycle;
use serde::Serialize;

/// No curve, no event.
const NONE: u32 = u32::MAX;
/// Changes closer than this are one, in m: a segment has at least this length.
const SMALLEST_M: f64 = 1e-3;

/// A stretch on which every track of the operating cycle is constant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
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

/// The lower of two numbers, neither of them NaN: one instruction, where [`f64::min`] takes six.
#[inline]
pub fn lower(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// Where each track changes next, in m; infinite where it does not.
struct NextChanges {
    sign: f64,
    section: f64,
    slope: f64,
    roughness: f64,
    weather: f64,
    traffic: f64,
    curve: f64,
    event: f64,
    cut: f64,
}

impl NextChanges {
    /// The first change of any track but the slope.
    fn first_but_slope(&self) -> f64 {
        let rules = lower(self.sign, self.section);
        let clock = lower(self.weather, self.traffic);
        let marks = lower(self.curve, self.event);
        lower(lower(self.roughness, rules), lower(lower(clock, marks), self.cut))
    }
}

impl OperatingCycle {
    /// Writes the segments of this cycle, in order and without gaps, into `segments`: as a driver
    /// takes them for whom each sign but the first stands so far behind its place. Within a run the
    /// slope alone changes, and an event stands at its start only; `runs` has the number of the
    /// first segment of each, and that of all segments.
    pub fn segments(&self, sign_offset_m: f64, segments: &mut Vec<Segment>, runs: &mut Vec<usize>) {
        self.segments_cut(sign_offset_m, &[], segments, runs);
    }

    /// The same of a road that is cut at places in order, in m: there a truck can halt, or its
    /// driver decides. Behind a cut all is as before it.
    pub fn segments_cut(
        &self,
        sign_offset_m: f64,
        cuts_m: &[f64],
        segments: &mut Vec<Segment>,
        runs: &mut Vec<usize>,
    ) {
        segments.clear();
        runs.clear();
        let road = &self.road;
        let length_m = road.length_m;
        let mut now = Segment { curve: NONE, event: NONE, ..Segment::default() };
        let sign = |k: u32| road.signs.get(k as usize).map(|sign| sign.start_m + sign_offset_m);
        // neither begins at the end of the road, be something a hair before it
        let slopes = road.slopes.len() as u32;
        let slope = |k: u32| (k < slopes).then(|| f64::from(k) * road.slope_step_m);
        let blocks = road.roughness_m3.len() as u32;
        let block = |k: u32| (k < blocks).then(|| f64::from(k) * road.roughness_block_m);
        let section = |k: u32| road.sections.get(k as usize).map(|section| section.start_m);
        let weather = |k: u32| self.weather.get(k as usize).map(|weather| weather.start_m);
        let traffic = |k: u32| self.traffic.get(k as usize).map(|traffic| traffic.start_m);
        let mut next = NextChanges {
            sign: start_of(sign(1)),
            section: start_of(section(1)),
            slope: start_of(slope(1)),
            roughness: start_of(block(1)),
            weather: start_of(weather(1)),
            traffic: start_of(traffic(1)),
            curve: start_of(road.curves.first().map(|curve| curve.start_m)),
            event: start_of(road.events.first().map(|event| event.position_m)),
            cut: start_of(cuts_m.first().copied()),
        };
        let (mut curve, mut event, mut cut) = (0, 0, 0);
        loop {
            // every track that changes here, or within the shortest segment
            let here = now.start_m + SMALLEST_M;
            pass(&mut now.slope, &mut next.slope, here, slope);
            pass(&mut now.roughness, &mut next.roughness, here, block);
            pass(&mut now.sign, &mut next.sign, here, sign);
            pass(&mut now.section, &mut next.section, here, section);
            pass(&mut now.weather, &mut next.weather, here, weather);
            pass(&mut now.traffic, &mut next.traffic, here, traffic);
            now.event = NONE;
            while next.event <= here {
                now.event = event as u32;
                event += 1;
                next.event = start_of(road.events.get(event).map(|event| event.position_m));
            }
            while next.cut <= here {
                cut += 1;
                next.cut = start_of(cuts_m.get(cut).copied());
            }
            while next.curve <= here {
                // the end of the curve that the road is in, or the start of the next one
                if now.curve == NONE {
                    now.curve = curve as u32;
                    next.curve = road.curves[curve].end_m;
                } else {
                    now.curve = NONE;
                    curve += 1;
                    next.curve = start_of(road.curves.get(curve).map(|curve| curve.start_m));
                }
            }

            // where the slope alone changes
            runs.push(segments.len());
            let other_m = next.first_but_slope();
            let last_m = lower(other_m, length_m) - SMALLEST_M;
            while next.slope < last_m {
                now.length_m = next.slope - now.start_m;
                segments.push(now);
                now.event = NONE;
                now.start_m = next.slope;
                now.slope += 1;
                next.slope = start_of(slope(now.slope + 1));
            }

            let mut end_m = lower(next.slope, other_m);
            if length_m - end_m < SMALLEST_M {
                end_m = length_m;
            }
            now.length_m = end_m - now.start_m;
            segments.push(now);
            if end_m >= length_m {
                runs.push(segments.len());
                return;
            }
            now.start_m = end_m;
        }
    }
}

/// Steps a track on to what holds at a place; `start_m`: where what has a number begins, if it
/// does.
#[inline(always)]
fn pass(number: &mut u32, next_m: &mut f64, here_m: f64, start_m: impl Fn(u32) -> Option<f64>) {
    while *next_m <= here_m {
        *number += 1;
        *next_m = start_of(start_m(*number + 1));
    }
}

/// A position, or infinity where there is none.
fn start_of(position_m: Option<f64>) -> f64 {
    position_m.unwrap_or(f64::INFINITY)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::operating_cycle::road::Road;

    #[test]
    fn a_cut_a_millimetre_before_the_end_begins_no_slope_behind_it() {
        let road = Road {
            length_m: 25.0,
            slopes: vec![0.01],
            slope_step_m: 25.0,
            roughness_m3: vec![1e-6],
            roughness_block_m: 25.0,
            ..Road::default()
        };
        let cycle = OperatingCycle { road, ..OperatingCycle::default() };
        let (mut segments, mut runs) = (Vec::new(), Vec::new());
        // rounded, the cut is a whole segment before the end, and the end one behind the cut
        let cut_m = 25.0 - SMALLEST_M;
        assert!(25.0 - cut_m >= SMALLEST_M && cut_m + SMALLEST_M >= 25.0);
        cycle.segments_cut(0.0, &[cut_m], &mut segments, &mut runs);
        let last = segments.last().expect("one");
        assert_eq!(segments.len(), 2);
        assert_eq!((last.slope, last.roughness), (0, 0));
        let length_m: f64 = segments.iter().map(|segment| segment.length_m).sum();
        assert!((length_m - 25.0).abs() < 1e-12);
    }
}
