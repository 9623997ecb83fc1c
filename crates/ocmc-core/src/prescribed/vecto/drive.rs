//! The drive: second by second along the nodes, with what engine and gearbox can do.

use super::gears::{GearChoice, GearMemory};
use super::mission::{Mission, Nodes};
use super::truck::{Motion, Truck};
use super::{Plan, PlannedSecond, VectoDriver};
use crate::powertrain::GearOrder;

/// What a speed is multiplied by until the engine has the power.
const CUT: f64 = 0.9999;
/// Most of these steps: the speed is then a hundred-thousandth.
const MOST_CUTS: usize = 120_000;
/// Power at the wheels from which an open clutch is closed, in W.
const ENGAGING_W: f64 = 200.0;
/// Speed below which first gear is released by a truck that slows, in m/s.
const RELEASE_MPS: f64 = 5.0 / 3.6;
/// Speed below which distances are not corrected, in m/s.
const CORRECTED_FROM_MPS: f64 = 1.0;
/// Speed below which a truck rests, in m/s.
const REST_MPS: f64 = 1e-4;
/// Least share of its speed that a truck keeps in a gap.
const KEPT_IN_GAP: f64 = 0.5;

/// The drive of a truck along a mission.
pub(super) struct Drive<'a> {
    mission: &'a Mission,
    truck: &'a Truck<'a>,
    driver: &'a VectoDriver,
    choice: GearChoice<'a>,
    nodes: Nodes,
    auxiliary_w: f64,
    memory: GearMemory,
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
    /// Seconds that its gap lasts from here, this one included; 0 in the second after it, in which
    /// the gear is engaged whatever is wanted.
    open_s: u32,
}

/// A second as it could be driven.
#[derive(Clone, Copy, Debug)]
struct Attempt {
    end_mps: f64,
    slope: f64,
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
        nodes: Nodes,
        auxiliary_w: f64,
    ) -> Self {
        let memory = GearMemory { gear: None, since_other_s: 0.0, engine_radps: None, slipped: false };
        Self {
            mission,
            truck,
            driver,
            choice: GearChoice::new(truck, driver),
            nodes,
            auxiliary_w,
            memory,
            shifting: None,
            engine_w: 0.0,
            distance_m: 0.0,
        }
    }

    /// Drives to the end of the nodes.
    pub(super) fn run(mut self) -> Plan {
        let way_m = self.nodes.way_m.clone();
        let (mut way_node, mut corrected) = (0, false);
        let mut seconds = Vec::with_capacity(self.nodes.seconds());
        let mut second = 0;
        while second < self.nodes.seconds() {
            let planned = self.second(second);
            seconds.push(planned);
            let mean_mps = self.nodes.mean_mps(second);
            self.distance_m += mean_mps;
            let correction = if corrected || mean_mps <= CORRECTED_FROM_MPS {
                Correction::None
            } else {
                correction(&way_m, way_node, self.distance_m, planned.target_mps)
            };
            match correction {
                Correction::None => way_node += 1,
                Correction::Repeat => self.repeat(second + 1),
                Correction::Drop => {
                    self.drop(second + 1);
                    way_node += 2;
                }
            }
            corrected = correction != Correction::None;
            second += 1;
        }
        Plan { speed_mps: self.nodes.speed_mps, seconds }
    }

    /// Repeats a second: a node of its mean speed comes between its nodes.
    fn repeat(&mut self, second: usize) {
        let nodes = &mut self.nodes;
        if second < nodes.seconds() {
            nodes.speed_mps.insert(second + 1, nodes.mean_mps(second));
            nodes.target_mps.insert(second + 1, nodes.target_mps[second]);
            nodes.auxiliary_w.insert(second + 1, nodes.auxiliary_w[second]);
        }
    }

    /// Leaves a second out.
    fn drop(&mut self, second: usize) {
        let nodes = &mut self.nodes;
        if second < nodes.seconds() {
            nodes.speed_mps.remove(second + 1);
            nodes.target_mps.remove(second + 1);
            nodes.auxiliary_w.remove(second + 1);
        }
    }

    /// Drives one second, and sets the speed at its end.
    fn second(&mut self, second: usize) -> PlannedSecond {
        let start_mps = self.nodes.speed_mps[second];
        let auxiliary_w = self.auxiliary_w + self.nodes.auxiliary_w[second];
        let wanted_mps = self.limited(start_mps, self.nodes.speed_mps[second + 1]);
        let mut done = self.strongest(start_mps, wanted_mps, auxiliary_w, second);
        self.shifting = self.shift(done.gear);
        if self.shifting.is_some_and(|shift| shift.open_s > 0) {
            done = self.gap(start_mps, &done, auxiliary_w);
        }
        // a gap counts as the gear that it leads to
        let held = self.shifting.map(|shift| shift.gear).or(done.gear);
        let same = held.is_some() && held == self.memory.gear;
        self.memory = GearMemory {
            gear: held,
            since_other_s: if same { self.memory.since_other_s + 1.0 } else { 2.0 },
            engine_radps: Some(done.engine_radps),
            slipped: done.slips,
        };
        let drag_w = self.truck.drag_w(done.engine_radps);
        self.engine_w = done.engine_w.max(drag_w) - auxiliary_w;
        self.nodes.speed_mps[second + 1] = done.end_mps;
        PlannedSecond {
            gradient: done.slope,
            gear: done.gear.map_or(GearOrder::Open, GearOrder::Engaged),
            target_mps: self.nodes.mean_target_mps(second),
            auxiliary_w,
        }
    }

    /// The shift that the next second is part of.
    fn shift(&self, wanted: Option<usize>) -> Option<Shift> {
        match self.shifting {
            Some(Shift { gear, open_s }) if open_s > 1 => Some(Shift { gear, open_s: open_s - 1 }),
            Some(Shift { gear, open_s: 1 }) => Some(Shift { gear, open_s: 0 }),
            _ => {
                let (last, gear) = (self.memory.gear?, wanted?);
                let open_s = self.driver.gap_s;
                (last != gear && open_s > 0).then_some(Shift { gear, open_s })
            }
        }
    }

    /// A wanted speed within what the table allows.
    fn limited(&self, start_mps: f64, wanted_mps: f64) -> f64 {
        let table = &self.driver.acceleration;
        let change = wanted_mps - start_mps;
        let mean_mps = 0.5 * (start_mps + wanted_mps);
        let most = |of: &dyn Fn(f64) -> f64| {
            let mut end_mps = wanted_mps;
            for _ in 0..30 {
                end_mps = start_mps + of(0.5 * (start_mps + end_mps));
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

    /// The fastest attempt that the engine can carry: the wanted speed is cut again and again.
    fn strongest(
        &self,
        start_mps: f64,
        wanted_mps: f64,
        auxiliary_w: f64,
        second: usize,
    ) -> Attempt {
        let mut end_mps = wanted_mps;
        let mut attempt = self.attempt(start_mps, end_mps, auxiliary_w, second);
        for _ in 0..MOST_CUTS {
            if attempt.able {
                break;
            }
            end_mps *= CUT;
            attempt = self.attempt(start_mps, end_mps, auxiliary_w, second);
        }
        attempt
    }

    /// One second to a speed at its end.
    fn attempt(&self, start_mps: f64, end_mps: f64, auxiliary_w: f64, second: usize) -> Attempt {
        let truck = self.truck;
        let speed_mps = 0.5 * (start_mps + end_mps);
        let slope = self.mission.gradient(self.distance_m + speed_mps);
        let motion = Motion {
            speed_mps,
            acceleration_mps2: end_mps - start_mps,
            slope: sine(slope),
            auxiliary_w,
        };
        let open = |engine_radps: f64, engine_w: f64| Attempt {
            end_mps,
            slope,
            gear: None,
            engine_radps,
            engine_w,
            slips: false,
            able: true,
        };
        if speed_mps < REST_MPS {
            return open(truck.idle_radps, auxiliary_w);
        }
        let wheel_w = truck.wheel_w(&motion);
        let gear = if let Some(shift) = self.shifting {
            shift.gear
        } else if self.memory.gear.is_none() && start_mps < REST_MPS {
            self.choice.start(motion.slope, auxiliary_w)
        } else if self.memory.gear.is_none() && second > 0 {
            self.choice.rolling_start(&motion)
        } else {
            self.choice.next(&motion, &self.memory)
        };
        let closed = self.closed_gear(gear, &motion, wheel_w);
        let last_radps = self.memory.engine_radps;
        let Some(gear) = closed else {
            let released = truck.released_radps(last_radps.unwrap_or(truck.idle_radps), self.engine_w);
            let spin_w = last_radps.map_or(0.0, |last| truck.spin_w(last, released));
            return open(released, auxiliary_w + spin_w);
        };
        let turns_radps = truck.speed_radps(gear, speed_mps);
        let slips = slips(truck, turns_radps, wheel_w, &motion);
        let engine_radps = if slips { truck.slipping_radps(turns_radps) } else { turns_radps };
        let spin_w = last_radps.map_or(0.0, |last| truck.spin_w(last, engine_radps));
        let engine_w = truck.gearbox_w(gear, &motion) + auxiliary_w + spin_w;
        Attempt {
            end_mps,
            slope,
            gear: Some(gear),
            engine_radps,
            engine_w,
            slips,
            able: engine_w <= truck.full_w(engine_radps),
        }
    }

    /// What is left of a chosen gear: none where the engine would stall.
    fn closed_gear(&self, gear: usize, motion: &Motion, wheel_w: f64) -> Option<usize> {
        let truck = self.truck;
        let turns = |gear: usize| truck.speed_radps(gear, motion.speed_mps);
        let mut closed = Some(gear);
        if gear == 0 && wheel_w < 0.0 && motion.speed_mps <= RELEASE_MPS {
            closed = None;
        }
        while let Some(gear) = closed {
            let slips = slips(truck, turns(gear), wheel_w, motion);
            if slips || turns(gear) >= truck.idle_radps {
                break;
            }
            closed = gear.checked_sub(1);
        }
        if closed.is_none() && wheel_w > ENGAGING_W {
            closed = Some(0);
        }
        let top = truck.powertrain.gears.len() - 1;
        closed.map(|gear| if turns(gear) > truck.fast_radps() { (gear + 1).min(top) } else { gear })
    }

    /// The second of a shift: the truck rolls.
    fn gap(&self, start_mps: f64, wanted: &Attempt, auxiliary_w: f64) -> Attempt {
        let truck = self.truck;
        let rolling_mps2 = truck.rolling_mps2(start_mps, sine(wanted.slope));
        let slowest_mps = KEPT_IN_GAP * start_mps;
        let end_mps = wanted.end_mps.min((start_mps + rolling_mps2).max(slowest_mps));
        let slope = self.mission.gradient(self.distance_m + 0.5 * (start_mps + end_mps));
        let last_radps = self.memory.engine_radps.unwrap_or(truck.idle_radps);
        let engine_radps = truck.released_radps(last_radps, self.engine_w);
        let engine_w = auxiliary_w + truck.spin_w(last_radps, engine_radps);
        Attempt { end_mps, slope, gear: None, engine_radps, engine_w, slips: false, able: true }
    }
}

/// Whether the clutch slips.
fn slips(truck: &Truck, turns_radps: f64, wheel_w: f64, motion: &Motion) -> bool {
    let drives = wheel_w > 0.0 && motion.acceleration_mps2 >= 0.0;
    drives && turns_radps < truck.slips_below_radps()
}

/// Climb per metre of road for a gradient.
fn sine(gradient: f64) -> f64 {
    gradient / (1.0 + gradient * gradient).sqrt()
}

/// What is done with the next second.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Correction {
    None,
    Repeat,
    Drop,
}

/// Compares the way that was driven with the mission's nodes: the next second is repeated where one
/// more of it comes nearer to the node, and left out where the node after it is as near.
fn correction(way_m: &[f64], node: usize, driven_m: f64, target_mps: f64) -> Correction {
    let Some(&here_m) = way_m.get(node) else {
        return Correction::None;
    };
    let off_m = (driven_m - here_m).abs();
    if (driven_m + target_mps - here_m).abs() < off_m {
        return Correction::Repeat;
    }
    match way_m.get(node + 1) {
        Some(&next_m) if (driven_m - next_m).abs() <= off_m => Correction::Drop,
        _ => Correction::None,
    }
}
