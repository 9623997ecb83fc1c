//! Before the drive of VECTO 2.2's driver: overspeed and look-ahead coasting change the nodes.

use super::mission::{Mission, Nodes};
use super::polygon::ShiftPolygons;
use super::truck::{Motion, Truck};
use super::{LookAhead, Overspeed, VectoDriver, sine};

/// A second brakes where the one before is faster by this, in m/s.
const SLOWER_MPS: f64 = 1e-4;
/// A target rises where it is higher by this than that of the second before, in m/s.
const HIGHER_MPS: f64 = 1e-4;
/// Steps of a fixed point.
const FIXED_POINT_STEPS: usize = 30;

/// Changes the nodes of a mission by overspeed and look-ahead coasting.
pub(super) fn prepare(
    nodes: &mut Nodes,
    mission: &Mission,
    truck: &Truck,
    driver: &VectoDriver,
    auxiliary_w: f64,
) {
    let polygons = ShiftPolygons::new(&driver.shift_polygons, truck.powertrain);
    let (slopes, gears) = (Vec::new(), Vec::new());
    let mut preparation =
        Preparation { nodes, mission, truck, driver, polygons, auxiliary_w, slopes, gears };
    preparation.locate();
    preparation.choose_gears_and_overspeed();
    preparation.look_ahead();
}

struct Preparation<'a> {
    nodes: &'a mut Nodes,
    mission: &'a Mission,
    truck: &'a Truck<'a>,
    driver: &'a VectoDriver,
    polygons: ShiftPolygons,
    auxiliary_w: f64,
    /// Climb per metre of road in each second of the mission: that of the place where it ends.
    slopes: Vec<f64>,
    /// The gear of each second before anything behind it was changed.
    gears: Vec<usize>,
}

impl Preparation<'_> {
    /// Slopes along the sum of the mean speeds, each that of the place where a second ends. They
    /// stay, whatever overspeed and coasting make of the speeds.
    fn locate(&mut self) {
        let (nodes, mission) = (&self.nodes, self.mission);
        self.slopes = (0..nodes.seconds())
            .scan(0.0, |way_m, second| {
                *way_m += nodes.mean_mps(second);
                Some(sine(mission.gradient(*way_m)))
            })
            .collect();
    }

    fn auxiliary_w(&self, second: usize) -> f64 {
        self.auxiliary_w + self.nodes.auxiliary_w[second]
    }

    fn motion(&self, second: usize) -> Motion {
        Motion {
            speed_mps: self.nodes.mean_mps(second),
            acceleration_mps2: self.nodes.acceleration_mps2(second),
            slope: self.slopes[second],
            auxiliary_w: self.auxiliary_w(second),
        }
    }

    /// The highest gear in which the engine is above the downshift line, by the power at the
    /// wheels.
    fn quick_gear(&self, motion: &Motion) -> usize {
        let wheel_w = self.truck.wheel_w(motion);
        let fits = |gear: &usize| {
            let speed_radps = self.truck.speed_radps(*gear, motion.speed_mps);
            let torque_nm = wheel_w / speed_radps.max(1.0);
            speed_radps > self.polygons.of(*gear).down.at_radps(torque_nm)
        };
        (0..self.truck.powertrain.gears.len()).rev().find(fits).unwrap_or(0)
    }

    /// Forwards: the gear of each second, as it is when its turn comes, and overspeed behind it.
    fn choose_gears_and_overspeed(&mut self) {
        for second in 0..self.nodes.seconds() {
            let motion = self.motion(second);
            let gear = self.quick_gear(&motion);
            self.gears.push(gear);
            if let Some(overspeed) = &self.driver.overspeed {
                self.run_over(second, &motion, gear, overspeed);
            }
        }
    }

    /// Lets the truck roll with a closed clutch where it would have to be braked.
    fn run_over(&mut self, second: usize, motion: &Motion, gear: usize, overspeed: &Overspeed) {
        if motion.speed_mps < overspeed.minimum_speed_mps {
            return;
        }
        let speed_radps = self.truck.speed_radps(gear, motion.speed_mps);
        let per_m = speed_radps / motion.speed_mps;
        let inertia_kgm2 = self.truck.powertrain.engine_model.inertia_kgm2;
        let spin_w = inertia_kgm2 * per_m * motion.acceleration_mps2 * speed_radps;
        // auxiliaries count when it coasts, not for whether it does
        if self.truck.quick_w(gear, &Motion { auxiliary_w: 0.0, ..*motion }) + spin_w
            >= self.truck.drag_w(speed_radps)
        {
            return;
        }
        let start_mps = self.nodes.speed_mps[second];
        let coasting_mps2 =
            self.truck.coasting_mps2(gear, start_mps, motion.slope, motion.auxiliary_w);
        let most_mps = self.nodes.mean_target_mps(second) + overspeed.above_mps;
        let node_mps = start_mps + coasting_mps2;
        self.nodes.speed_mps[second + 1] =
            node_mps.min(most_mps).min(2.0 * most_mps - start_mps).max(0.0);
    }

    fn brakes(&self, second: usize) -> bool {
        second > 0 && self.nodes.mean_mps(second - 1) > self.nodes.mean_mps(second) + SLOWER_MPS
    }

    /// From the end to the start: each ramp is braked as hard as the table says and no harder, and
    /// coasting comes before it.
    fn look_ahead(&mut self) {
        let mut second = self.nodes.seconds();
        while second > 0 {
            second -= 1;
            if !self.brakes(second) {
                continue;
            }
            let from = self.coasting_start(second);
            if self.brakes_hard(second) {
                self.brake_exactly(second);
            }
            // the second that one looks back from does not end its ramp
            let mut ramp = second - 1;
            while self.brakes_hard(ramp) {
                self.brake_exactly(ramp);
                if ramp == 0 {
                    return;
                }
                ramp -= 1;
            }
            // the second in which the ramp ends has to be fast enough
            if let Some((from, minimum_mps)) = from
                && self.nodes.mean_mps(ramp) >= minimum_mps
            {
                self.coast(from, second);
            }
            second = ramp + 1;
        }
    }

    fn brakes_hard(&self, second: usize) -> bool {
        let table = &self.driver.acceleration;
        let most_mps2 = table.deceleration_mps2(self.nodes.mean_mps(second));
        self.nodes.acceleration_mps2(second) < most_mps2 - 1e-9
    }

    /// Lowers the speed at the start of a second until it is braked as the table says.
    fn brake_exactly(&mut self, second: usize) {
        let end_mps = self.nodes.speed_mps[second + 1];
        let mut start_mps = self.nodes.speed_mps[second];
        for _ in 0..FIXED_POINT_STEPS {
            let mean_mps = 0.5 * (start_mps + end_mps);
            start_mps = end_mps - self.driver.acceleration.deceleration_mps2(mean_mps);
        }
        self.nodes.speed_mps[second] = start_mps;
    }

    /// Where coasting before a ramp begins, and the least speed for it.
    fn coasting_start(&self, second: usize) -> Option<(usize, f64)> {
        let LookAhead::Window { deceleration_mps2, minimum_speed_mps } = self.driver.look_ahead?
        else {
            return None;
        };
        Some((self.window_start(second, deceleration_mps2)?, minimum_speed_mps))
    }

    /// VECTO 2.2's window: as long as a fixed deceleration would take, not before the second behind
    /// the target's last rise, and so short that coasting does not become slower than the ramp's
    /// end.
    fn window_start(&self, second: usize, deceleration_mps2: f64) -> Option<usize> {
        let end_mps = self.nodes.mean_mps(second);
        let before = (0..second).rev().find(|k| !self.brakes(*k))?;
        let fast_mps = self.nodes.mean_mps(before);
        let length = libm::round((end_mps - fast_mps) / deceleration_mps2.min(-1e-3)).max(0.0);
        let mut start = second.saturating_sub(length as usize);
        let rises = |k: &usize| {
            *k > 0
                && self.nodes.mean_target_mps(*k) > self.nodes.mean_target_mps(*k - 1) + HIGHER_MPS
        };
        if let Some(rise) = (start..=second).rev().find(rises) {
            start = second.min(rise + 1);
        }
        while start < second && self.coasts_below(start, second, end_mps) {
            start += 1;
        }
        Some(start)
    }

    /// Whether coasting from a second, in its gear and on its slope, is slower than a speed before
    /// another second.
    fn coasts_below(&self, start: usize, end: usize, speed_mps: f64) -> bool {
        let (motion, gear) = (self.motion(start), self.gears[start]);
        let mut now_mps = motion.speed_mps;
        for _ in start..end {
            now_mps += self.truck.coasting_mps2(gear, now_mps, motion.slope, motion.auxiliary_w);
            if now_mps < speed_mps {
                return true;
            }
        }
        false
    }

    /// Coasts from a second on, while that is slower than the nodes and does not brake.
    fn coast(&mut self, from: usize, until: usize) {
        for second in from..=until {
            let (motion, gear) = (self.motion(second), self.gears[second]);
            let start_mps = self.nodes.speed_mps[second];
            let change =
                self.truck.coasting_mps2(gear, start_mps, motion.slope, motion.auxiliary_w);
            // the table is asked at the speed that the second had before it coasts
            let planned_mps = self.nodes.mean_mps(second);
            let hard = change < self.driver.acceleration.deceleration_mps2(planned_mps);
            if start_mps + 0.5 * change >= planned_mps || hard {
                break;
            }
            self.nodes.speed_mps[second + 1] = (start_mps + change).max(0.0);
        }
    }
}
