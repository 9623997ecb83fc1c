//! The tactical module: from a scenario to the desired speed along the road.
//!
//! The paper's Eq. 1 takes the lowest of five static speeds (sign, curve, bump, stop, traffic) and
//! of their five anticipating versions. Anticipation at constant deceleration is linear in n = v²,
//! so all constraints ahead together are one backward sweep, n_b(x) = min_j [n_j + 2 a (x_j − x)];
//! looking only at the next change, as printed, fails where a low limit follows a mild one closely.
//! A rise of the limit is followed with the driver's acceleration, one forward sweep (or at once,
//! `rise = "paper"`). A standing truck starts because the accelerating branch never lies below the
//! launch speed (launch floor).
//!
//! The printed v' = √(v_{i+1} − 2 a (x_{i+1} − x)) subtracts m²/s² from m/s: v_{i+1} has to be
//! squared.
//!
//! Checked in `tests/it/tactical.rs`: the sweeps equal brute force over all constraints on 30
//! sampled roads, and looking only at the next change would be wrong. The desired speed is
//! continuous but at events and never above the limiter, and the paper's rise jumps.

use crate::crest::crest_speeds;
use crate::driver::speed_change::{AccelerationLaw, Rise};
use crate::lanes::UNBOUNDED;
use crate::operating_cycle::road::point_event::Passage;
use crate::operating_cycle::segments::{Segment, lower};
use crate::study::{Scenario, Study};

/// Desired speed squared of one segment, in m²/s²: the lowest of three branches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedBranch {
    /// Static limit.
    pub limit: f64,
    /// Braking branch at the segment's end; grows by 2 a_dec for each m before it.
    pub backward_end: f64,
    /// Accelerating branch at the segment's start; grows with the driver's acceleration behind it,
    /// and is at least launch².
    pub forward_start: f64,
    /// Whether the static limit is that of a sign or of the truck, not of a curve or of traffic.
    pub by_sign: bool,
    /// Speed to which a truck may coast ahead of the braking branch: unbounded where it may not.
    pub coasts_to: f64,
}

impl SpeedBranch {
    const NONE: Self = Self {
        limit: 0.0,
        backward_end: 0.0,
        forward_start: 0.0,
        by_sign: false,
        coasts_to: UNBOUNDED,
    };
}

/// Desired speed squared along the road: a limit, linear in position on a braking branch, by the
/// driver's law on an accelerating one; stops included.
#[derive(Clone, Debug, Default)]
pub struct SpeedProfile {
    /// The stretches on which everything is constant.
    pub segments: Vec<Segment>,
    /// Runs of segments in which the slope alone changes: the first of each, and their number.
    pub runs: Vec<usize>,
    /// The branches of each segment.
    pub branches: Vec<SpeedBranch>,
    /// Twice the deceleration, in m/s².
    pub twice_deceleration: f64,
    /// The driver's acceleration in the truck as it departs.
    pub acceleration: AccelerationLaw,
    /// Square of the launch speed, in m²/s².
    pub launch: f64,
}

impl SpeedProfile {
    /// Desired speed in segment `i`, `behind_m` behind its start, in m/s.
    pub fn speed_mps(&self, i: usize, behind_m: f64) -> f64 {
        let branch = &self.branches[i];
        let ahead_m = self.segments[i].length_m - behind_m;
        let backward = branch.backward_end + self.twice_deceleration * ahead_m;
        let level = branch.limit.min(backward);
        // `rise = "paper"`: there is none
        if branch.forward_start == f64::INFINITY {
            return level.sqrt();
        }
        let forward = self.acceleration.squared_after(branch.forward_start, behind_m);
        level.min(forward.max(self.launch)).sqrt()
    }
}

/// Plans the speed profile of a scenario into `profile`, whose buffers are reused.
pub fn plan(study: &Study, scenario: &Scenario, profile: &mut SpeedProfile) {
    plan_cut(study, scenario, &[], profile);
}

/// As [`plan`], of a road that is cut.
pub(crate) fn plan_cut(
    study: &Study,
    scenario: &Scenario,
    cuts_m: &[f64],
    profile: &mut SpeedProfile,
) {
    plan_braking(study, scenario, cuts_m, profile);
    match scenario.driver.speed_change.rise {
        Rise::Ramp => forward_sweep(profile),
        // the limit is followed upwards at once, and a stop is left at once, too
        Rise::Paper => {
            for branch in &mut profile.branches {
                branch.forward_start = f64::INFINITY;
            }
        }
    }
}

/// As [`plan_cut`] without the accelerating branches: the step function rises from what was driven.
pub(crate) fn plan_braking(
    study: &Study,
    scenario: &Scenario,
    cuts_m: &[f64],
    profile: &mut SpeedProfile,
) {
    let offset_m = scenario.driver.speed_limit.sign_offset_m;
    let SpeedProfile { segments, runs, .. } = profile;
    scenario.cycle.segments_cut(offset_m, cuts_m, segments, runs);
    let change = &scenario.driver.speed_change;
    profile.twice_deceleration = 2.0 * change.deceleration_mps2;
    let rated_power_w = study.vehicle().rated_power_w;
    profile.acceleration = change.acceleration(rated_power_w, scenario.vehicle.mass_kg);
    profile.launch = change.launch_speed_mps * change.launch_speed_mps;
    let look_ahead = &study.model().driver.look_ahead;
    let crests = if look_ahead.predictive_cruise {
        let mut limits = StaticLimits::new(study, scenario);
        let limits: Vec<_> = profile.segments.iter().map(|s| limits.of_segment(s)).collect();
        crest_speeds(study, scenario, &profile.segments, &limits)
    } else {
        Vec::new()
    };
    let limits = StaticLimits::new(study, scenario);
    backward_sweep(profile, limits, &crests, look_ahead.coasting);
}

/// The static speeds of a scenario, in order along the road in either direction.
struct StaticLimits<'a> {
    study: &'a Study,
    scenario: &'a Scenario,
    /// Sign, traffic and section that hold now, and the lowest of their speeds, in m/s.
    rules: (u32, u32, u32),
    rules_mps: f64,
    /// Whether the sign's is the lowest of them.
    sign_rules: bool,
    /// Curve that the road is in now, and the lower of its speed and that of the rules, in m/s.
    curve: Option<usize>,
    speed_mps: f64,
    /// Whether it is that of the sign.
    by_sign: bool,
}

impl<'a> StaticLimits<'a> {
    fn new(study: &'a Study, scenario: &'a Scenario) -> Self {
        let nowhere = (u32::MAX, u32::MAX, u32::MAX);
        Self {
            study,
            scenario,
            rules: nowhere,
            rules_mps: 0.0,
            sign_rules: false,
            curve: None,
            speed_mps: 0.0,
            by_sign: false,
        }
    }

    /// Lowest static speed of a segment, squared: sign, curve, traffic; and whether it is the
    /// sign's.
    #[inline(always)]
    fn of_segment(&mut self, segment: &Segment) -> (f64, bool) {
        // they hold over many segments
        let rules = (segment.sign, segment.traffic, segment.section);
        if (rules, segment.curve()) != (self.rules, self.curve) {
            self.update(rules, segment.curve());
        }
        (self.speed_mps * self.speed_mps, self.by_sign)
    }

    #[inline(never)]
    fn update(&mut self, rules: (u32, u32, u32), curve: Option<usize>) {
        if rules != self.rules {
            let (sign_mps, flow_mps) = self.speeds_of_rules(rules);
            (self.rules_mps, self.sign_rules) = (sign_mps.min(flow_mps), sign_mps <= flow_mps);
        }
        (self.rules, self.curve) = (rules, curve);
        let curve_mps = curve.map_or(f64::INFINITY, |k| self.speed_of_curve(k));
        self.speed_mps = self.rules_mps.min(curve_mps);
        self.by_sign = self.sign_rules && self.rules_mps <= curve_mps;
    }

    /// Speed that the sign allows, and that of the traffic, in m/s.
    fn speeds_of_rules(&self, (sign, traffic, section): (u32, u32, u32)) -> (f64, f64) {
        let (cycle, model) = (&self.scenario.cycle, self.study.operating_cycle());
        let sign_mps = cycle.road.signs[sign as usize].speed_mps;
        let road_type = cycle.road.sections[section as usize].road_type;
        let legal_mps = model.road().legal_mps(road_type);
        let density = cycle.traffic[traffic as usize].density_per_m;
        let flow = if density > 0.0 {
            model.traffic().speed_mps(density, sign_mps)
        } else {
            f64::INFINITY
        };
        (self.scenario.driver.speed_limit.sign_speed_mps(sign_mps, legal_mps), flow)
    }

    fn speed_of_curve(&self, k: usize) -> f64 {
        let curve = &self.scenario.cycle.road.curves[k];
        let z = self.scenario.curve_residuals[k];
        self.scenario.driver.curve_speed.speed_mps(curve.radius_m, curve.left, z)
    }

    /// Speed that an event allows at its place, squared.
    #[inline(never)]
    fn of_event(&self, k: usize) -> f64 {
        match self.scenario.passage(k) {
            Passage::Stop { .. } => 0.0,
            Passage::Slow { speed_mps } => speed_mps * speed_mps,
            Passage::Free => f64::INFINITY,
            Passage::Bump { length_m, height_m } => {
                let speed = self.scenario.driver.speed_limit.bump_speed_mps(length_m, height_m);
                speed * speed
            }
        }
    }
}

/// From the end, where the truck stops, to the start. A branch is cut down to the limit that comes
/// next only where that is lower than the limit here: it then tells from how far the next ramp can
/// be seen.
///
/// `crests`: what predictive cruise control allows at the start of each segment, squared; none
/// where it is off. `coasts`: whether a truck coasts before all lower speeds, not only before
/// crests.
fn backward_sweep(
    profile: &mut SpeedProfile,
    mut limits: StaticLimits,
    crests: &[f64],
    coasts: bool,
) {
    let slope = profile.twice_deceleration;
    let SpeedProfile { segments, runs, branches, .. } = profile;
    // all are written anew
    branches.resize(segments.len(), SpeedBranch::NONE);
    let mut node: f64 = 0.0;
    let mut next_limit = f64::INFINITY;
    let to = |squared: f64| if coasts { squared } else { UNBOUNDED };
    let mut coasts_to = to(0.0);
    for run in runs.windows(2).rev() {
        let (first, end) = (run[0], run[1]);
        let (segments, branches) = (&segments[first..end], &mut branches[first..end]);
        let (limit, by_sign) = limits.of_segment(&segments[0]);
        // what the next run allows
        let highest = if next_limit < limit { lower(node, next_limit) } else { node };
        coasts_to = if highest < node { to(next_limit) } else { coasts_to };
        node = highest;
        next_limit = limit;
        // at once, where nothing but the ramp changes
        let at_once = if crests.is_empty() { segments.len() } else { 1 };
        for i in (0..segments.len()).step_by(at_once).rev() {
            let of_all = SpeedBranch { limit, by_sign, coasts_to, ..SpeedBranch::NONE };
            let (segments, branches) = (&segments[i..i + at_once], &mut branches[i..i + at_once]);
            node = sweep_ramp(segments, branches, of_all, slope, node);
            if i == 0
                && let Some(event) = segments[0].event()
            {
                // what the start of the segment allows
                let start = node;
                node = lower(start, limits.of_event(event));
                coasts_to = if node < start { to(node) } else { coasts_to };
            }
            if let Some(&crest) = crests.get(first + i)
                && crest < node
            {
                (node, coasts_to) = (crest, crest);
            }
        }
    }
}

/// Writes the branches of segments from their end, where `node` is allowed; returns what their
/// start allows.
fn sweep_ramp(
    segments: &[Segment],
    branches: &mut [SpeedBranch],
    of_all: SpeedBranch,
    slope: f64,
    mut node: f64,
) -> f64 {
    for (segment, branch) in segments.iter().zip(branches).rev() {
        *branch = SpeedBranch { backward_end: node, ..of_all };
        node += slope * segment.length_m;
    }
    node
}

/// From the start, where the truck stands, to the end. What a place allows is in the braking branch
/// that ends there.
fn forward_sweep(profile: &mut SpeedProfile) {
    let acceleration = profile.acceleration;
    let mut node = 0.0;
    for (segment, branch) in profile.segments.iter().zip(&mut profile.branches) {
        branch.forward_start = node;
        // what is really reached: no branch may lie above the others at the node. The launch speed
        // is a floor under the whole branch wherever it is read; a floor at the nodes, too, would
        // make the ramp depend on where nodes lie.
        let level = lower(branch.backward_end, branch.limit);
        // a branch that has come to the limit stays there
        node = if node < level {
            lower(acceleration.squared_after(node, segment.length_m), level)
        } else {
            level
        };
    }
}
