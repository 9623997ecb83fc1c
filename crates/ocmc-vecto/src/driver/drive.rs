//! The drive: second by second along the nodes, or by what is decided on the way, with what engine
//! and gearbox can do.

use super::ahead::{Ahead, Situation, Wish};
use super::clutch::{ENGAGING_W, closed_gear, slips};
use super::correction::{Correction, correction};
use super::gears::{GearChoice, GearMemory};
use super::mission::{Mission, Nodes};
use super::truck::{Motion, Truck};
use super::{Plan, PlannedSecond, VectoDriver, sine};
use ocmc_core::powertrain::GearOrder;

/// Factor by which a speed is multiplied until the engine has the power; in single precision, whose
/// rounding shows after hundreds of steps.
const CUT: f32 = 0.9999;
/// Most of these steps: the speed is then a hundred-thousandth.
const MOST_CUTS: usize = 120_000;
/// Speed below which distances are not corrected, in m/s.
const CORRECTED_FROM_MPS: f64 = 1.0;
/// Speed below which a truck rests, in m/s.
const REST_MPS: f64 = 1e-4;
/// Seconds that have to be left for a correction.
const LEFT_FOR_CORRECTION: usize = 3;
/// Seconds at rest, away from a stop, after which a truck does not get away.
const STUCK_S: u32 = 60;
/// Most seconds of a mission that is decided on the way.
const MOST_SECONDS: usize = 10_000_000;

/// The drive of a truck along a mission.
pub(super) struct Drive<'a> {
    mission: &'a Mission,
    truck: &'a Truck<'a>,
    driver: &'a VectoDriver,
    choice: GearChoice<'a>,
    auxiliary_w: f64,
    /// Where in a second the slope holds that it is driven on, as a share of its way.
    slope_share: f64,
    memory: GearMemory,
    /// The gear that was engaged last, and the seconds since then.
    engaged: Option<usize>,
    since_engaged_s: f64,
    shifting: Option<Shift>,
    /// Power that the engine gave in the last second without that for auxiliaries, in W.
    engine_w: f64,
    distance_m: f64,
}

/// A shift on its way.
#[derive(Clone, Copy, Debug)]
struct Shift {
    /// Gear that it leads to.
    gear: usize,
    /// Seconds that its gap lasts from here, this one included. In the second after it the gear is
    /// engaged whatever is wanted.
    open_s: u32,
}

/// Conditions of a second.
#[derive(Clone, Copy, Debug)]
struct Conditions {
    /// Whether it is the first one.
    first: bool,
    start_mps: f64,
    auxiliary_w: f64,
    /// The speed above which the brakes act in a gap, too, in m/s.
    most_mps: f64,
    /// Whether the truck rolls in a gap, also where it was to slow more.
    rolls: bool,
}

/// A second as it could be driven.
#[derive(Clone, Copy, Debug)]
struct Attempt {
    end_mps: f64,
    gradient: f64,
    /// The gear that is engaged, none with an open clutch.
    gear: Option<usize>,
    engine_radps: f64,
    /// Power wanted of the engine, in W.
    engine_w: f64,
    slips: bool,
    /// Whether the engine has that power.
    able: bool,
}

impl<'a> Drive<'a> {
    pub(super) fn new(
        mission: &'a Mission,
        truck: &'a Truck<'a>,
        driver: &'a VectoDriver,
        auxiliary_w: f64,
    ) -> Self {
        let memory = GearMemory { since_other_s: f64::INFINITY, ..GearMemory::default() };
        Self {
            mission,
            truck,
            driver,
            choice: GearChoice::new(truck, driver),
            auxiliary_w,
            slope_share: 1.0,
            memory,
            engaged: None,
            since_engaged_s: 0.0,
            shifting: None,
            engine_w: 0.0,
            distance_m: 0.0,
        }
    }

    /// Drives to the end of the nodes.
    pub(super) fn run(mut self, mut nodes: Nodes) -> Plan {
        let way_m = nodes.way_m.clone();
        let (mut way_node, mut corrected) = (0, false);
        let mut speed_mps = vec![nodes.speed_mps[0]];
        let mut seconds = Vec::with_capacity(nodes.seconds());
        let mut second = 0;
        while second < nodes.seconds() {
            let start_mps = speed_mps[second];
            let wish = Wish {
                end_mps: self.limited(start_mps, nodes.speed_mps[second + 1]),
                most_mps: f64::INFINITY,
                rolls: false,
                target_mps: nodes.mean_target_mps(second),
                auxiliary_w: nodes.auxiliary_w[second],
            };
            let (planned, end_mps) = self.second(second == 0, start_mps, &wish);
            seconds.push(planned);
            speed_mps.push(end_mps);
            let mean_mps = 0.5 * (start_mps + end_mps);
            self.distance_m += mean_mps;
            let left = nodes.seconds() - (second + 1);
            let keeps = corrected || left < LEFT_FOR_CORRECTION;
            let correction = if keeps || mean_mps <= CORRECTED_FROM_MPS {
                Correction::None
            } else {
                correction(&way_m, way_node, self.distance_m, planned.target_mps)
            };
            match correction {
                Correction::None => way_node += 1,
                Correction::Repeat => nodes.repeat(second + 1),
                Correction::Drop => {
                    nodes.drop(second + 1);
                    way_node += 2;
                }
            }
            corrected = correction != Correction::None;
            second += 1;
        }
        Plan { speed_mps, seconds }
    }

    /// Drives to the end of a mission by what is decided on the way; a truck that does not get away
    /// ends it.
    pub(super) fn run_ahead(mut self, mut ahead: Ahead) -> Plan {
        self.slope_share = 0.5;
        let mut speed_mps = vec![ahead.start_mps()];
        let (mut seconds, mut stuck_s) = (Vec::new(), 0);
        while !ahead.ends(self.distance_m) && stuck_s < STUCK_S && seconds.len() < MOST_SECONDS {
            let start_mps = speed_mps[seconds.len()];
            let motion = self.motion_at(start_mps, start_mps, self.auxiliary_w);
            let wish = ahead.wish(&Situation {
                way_m: self.distance_m,
                speed_mps: start_mps,
                gear: self.memory.gear,
                slope: motion.slope,
                auxiliary_w: self.auxiliary_w,
            });
            // braking follows the road, whatever the table says of a whole second
            let end_mps = self.limited(start_mps, wish.end_mps).min(wish.most_mps);
            let (planned, end_mps) =
                self.second(seconds.is_empty(), start_mps, &Wish { end_mps, ..wish });
            let stuck = start_mps == 0.0 && end_mps == 0.0 && !ahead.stands();
            stuck_s = if stuck { stuck_s + 1 } else { 0 };
            seconds.push(planned);
            speed_mps.push(end_mps);
            self.distance_m += 0.5 * (start_mps + end_mps);
        }
        Plan { speed_mps, seconds }
    }

    /// Drives one second; what is planned of it, and the speed at its end in m/s.
    fn second(&mut self, first: bool, start_mps: f64, wish: &Wish) -> (PlannedSecond, f64) {
        let auxiliary_w = self.auxiliary_w + wish.auxiliary_w;
        let Wish { most_mps, rolls, .. } = *wish;
        let conditions = Conditions { first, start_mps, auxiliary_w, most_mps, rolls };
        let (mut done, cut) = self.strongest(&conditions, wish.end_mps);
        self.shifting = self.shift(done.gear);
        if let Some(shift) = self.shifting {
            done = self.gap(&conditions, &done, cut, shift.gear);
            if done.gear.is_some() {
                self.shifting = None;
            }
        }
        // a gap counts as the gear that it leads to
        let held = self.shifting.map(|shift| shift.gear).or(done.gear);
        self.count(held);
        self.memory = GearMemory {
            gear: held,
            engine_radps: Some(done.engine_radps),
            slipped: done.slips,
            ..self.memory
        };
        let drag_w = self.truck.drag_w(done.engine_radps);
        self.engine_w = done.engine_w.max(drag_w) - auxiliary_w;
        let planned = PlannedSecond {
            gradient: done.gradient,
            gear: done.gear.map_or(GearOrder::Open, GearOrder::Engaged),
            target_mps: wish.target_mps,
            auxiliary_w,
        };
        (planned, done.end_mps)
    }

    /// Counts the seconds since another gear; an open clutch at rest or before a stall is none.
    fn count(&mut self, held: Option<usize>) {
        let memory = &mut self.memory;
        memory.since_other_s += 1.0;
        memory.since_shift_s += 1.0;
        self.since_engaged_s += 1.0;
        match (memory.gear, held) {
            (Some(before), Some(gear)) if before != gear => {
                (memory.last_up, memory.since_shift_s) = (Some(gear > before), 0.0);
            }
            (_, None) => memory.last_up = None,
            _ => {}
        }
        if let Some(gear) = held {
            if self.engaged.is_some_and(|before| before != gear) {
                memory.since_other_s = self.since_engaged_s + 1.0;
            }
            self.engaged = Some(gear);
            self.since_engaged_s = 0.0;
        }
    }

    /// The shift that the next second is part of.
    fn shift(&self, wanted: Option<usize>) -> Option<Shift> {
        if let Some(Shift { gear, open_s }) = self.shifting {
            (open_s > 1).then_some(Shift { gear, open_s: open_s - 1 })
        } else {
            let (last, gear) = (self.memory.gear?, wanted?);
            let open_s = self.driver.gap_s;
            (last != gear && open_s > 0).then_some(Shift { gear, open_s })
        }
    }

    /// A wanted speed within what the table allows.
    fn limited(&self, start_mps: f64, wanted_mps: f64) -> f64 {
        let table = &self.driver.acceleration;
        let change = wanted_mps - start_mps;
        let mean_mps = 0.5 * (start_mps + wanted_mps);
        let most = |most_mps2: &dyn Fn(f64) -> f64| {
            let mut end_mps = wanted_mps;
            for _ in 0..30 {
                end_mps = start_mps + most_mps2(0.5 * (start_mps + end_mps));
            }
            end_mps.max(0.0)
        };
        if change > table.acceleration_mps2(mean_mps) {
            most(&|v| table.acceleration_mps2(v)).min(wanted_mps)
        } else if change < table.deceleration_mps2(mean_mps) {
            most(&|v| table.deceleration_mps2(v)).max(wanted_mps)
        } else {
            wanted_mps
        }
    }

    /// The fastest attempt that the engine can carry, and whether the wanted speed had to be cut
    /// for it. It is cut again and again, with the gear chosen anew each time; cuts are made many
    /// at once as long as the gear is the same and the engine still has not the power.
    fn strongest(&self, conditions: &Conditions, wanted_mps: f64) -> (Attempt, bool) {
        let mut attempt = self.attempt(conditions, wanted_mps);
        let (mut cuts, mut step, mut grows) = (0, 1, true);
        while !attempt.able && cuts < MOST_CUTS {
            let further = self.attempt(conditions, cut_mps(attempt.end_mps, step));
            let same = !further.able && further.gear == attempt.gear;
            if !same && step > 1 {
                (step, grows) = (step / 2, false);
                continue;
            }
            attempt = further;
            cuts += step;
            // in another gear all begins anew
            grows = grows || !same;
            step = if !same {
                1
            } else if grows {
                2 * step
            } else {
                (step / 2).max(1)
            };
        }
        (attempt, cuts > 0)
    }

    /// One second to a speed at its end, in the gear that is chosen for it.
    fn attempt(&self, conditions: &Conditions, end_mps: f64) -> Attempt {
        let motion = self.motion(conditions, end_mps);
        let resting = self.memory.gear.is_none() && conditions.start_mps < REST_MPS;
        let gear = if let Some(shift) = self.shifting {
            shift.gear
        } else if resting && !conditions.first {
            self.choice.start(motion.slope, conditions.auxiliary_w, self.memory.engine_radps)
        } else {
            self.choice.next(&motion, &self.memory)
        };
        self.attempt_in(conditions, end_mps, gear)
    }

    fn motion(&self, conditions: &Conditions, end_mps: f64) -> Motion {
        self.motion_at(conditions.start_mps, end_mps, conditions.auxiliary_w)
    }

    fn motion_at(&self, start_mps: f64, end_mps: f64, auxiliary_w: f64) -> Motion {
        let speed_mps = 0.5 * (start_mps + end_mps);
        Motion {
            speed_mps,
            acceleration_mps2: end_mps - start_mps,
            slope: sine(self.gradient(speed_mps)),
            auxiliary_w,
        }
    }

    /// The gradient that holds in a second of a mean speed in m/s.
    fn gradient(&self, speed_mps: f64) -> f64 {
        self.mission.gradient(self.distance_m + self.slope_share * speed_mps)
    }

    /// One second to a speed at its end, in a gear.
    fn attempt_in(&self, conditions: &Conditions, end_mps: f64, gear: usize) -> Attempt {
        let (truck, motion) = (self.truck, self.motion(conditions, end_mps));
        let gradient = self.gradient(motion.speed_mps);
        let wheel_w = truck.wheel_w(&motion);
        let resting = motion.speed_mps < REST_MPS;
        let closed = if resting { None } else { closed_gear(truck, gear, &motion, wheel_w) };
        let Some(gear) = closed else {
            return self.open(conditions, end_mps);
        };
        let turns_radps = truck.speed_radps(gear, motion.speed_mps);
        let slips = slips(truck, turns_radps, wheel_w, &motion);
        let engine_radps = if slips { truck.slipping_radps(turns_radps) } else { turns_radps };
        let last_radps = self.memory.engine_radps;
        let spin_w = last_radps.map_or(0.0, |last| truck.spin_w(last, engine_radps));
        let engine_w = truck.gearbox_w(gear, &motion) + conditions.auxiliary_w + spin_w;
        Attempt {
            end_mps,
            gradient,
            gear: Some(gear),
            engine_radps,
            engine_w,
            slips,
            able: engine_w <= truck.full_w(engine_radps),
        }
    }

    /// One second with an open clutch.
    fn open(&self, conditions: &Conditions, end_mps: f64) -> Attempt {
        let truck = self.truck;
        let speed_mps = 0.5 * (conditions.start_mps + end_mps);
        let last_radps = self.memory.engine_radps.unwrap_or(truck.idle_radps);
        let engine_radps = if speed_mps < REST_MPS {
            truck.idle_radps
        } else {
            truck.released_radps(last_radps, self.engine_w)
        };
        Attempt {
            end_mps,
            gradient: self.gradient(speed_mps),
            gear: None,
            engine_radps,
            engine_w: conditions.auxiliary_w + truck.spin_w(last_radps, engine_radps),
            slips: false,
            able: true,
        }
    }

    /// The second of a shift: the truck rolls, unless it is to slow more than that. Where it would
    /// roll to rest, or slow more than the table says before full load was asked for, the new gear
    /// has to pull at once.
    fn gap(&self, conditions: &Conditions, wanted: &Attempt, cut: bool, gear: usize) -> Attempt {
        let motion = self.motion(conditions, wanted.end_mps);
        let rolling_mps2 = self.truck.rolling_mps2(conditions.start_mps, motion.slope);
        let rolling_mps = (conditions.start_mps + rolling_mps2).max(0.0);
        let slows = wanted.end_mps < conditions.start_mps && !conditions.rolls;
        let mut end_mps = if slows { wanted.end_mps.min(rolling_mps) } else { rolling_mps };
        if !cut {
            end_mps = self.limited(conditions.start_mps, end_mps);
        }
        end_mps = end_mps.min(conditions.most_mps);
        if self.truck.wheel_w(&self.motion(conditions, end_mps)) > ENGAGING_W {
            self.attempt_in(conditions, end_mps, gear)
        } else {
            self.open(conditions, end_mps)
        }
    }
}

/// A speed after some cuts.
fn cut_mps(mut speed_mps: f64, cuts: usize) -> f64 {
    for _ in 0..cuts {
        speed_mps = f64::from(speed_mps as f32 * CUT);
    }
    speed_mps
}
