//! Steady driving equals the closed form; a smooth case converges with second order.

use crate::common::{GivenRoad, column, diesel, typical};
use fearless_simd::{Level, dispatch, prelude::*};
use ocmc_core::energy::ledger::Term;
use ocmc_core::kernel::drive::trace::trace_scenario;
use ocmc_core::kernel::step::road_row::RoadRow;
use ocmc_core::kernel::step::state::{KernelParameters, State};
use ocmc_core::lanes::{Lanes, UNBOUNDED};
use ocmc_core::study::{SimulationModel, Study};
use ocmc_core::vehicle::resistance::GRAVITY_MPS2;

/// Engine torque that holds a speed on a slope, from the wheel back through axle, retarder and
/// gearbox.
fn steady_torque_nm(
    study: &Study,
    gear: usize,
    speed_mps: f64,
    wheel_force_n: f64,
    auxiliary_nm: f64,
) -> f64 {
    let vehicle = &study.model().vehicle;
    let gearbox = &diesel(study).gearbox;
    let axle_out = wheel_force_n * vehicle.wheel_radius_m / gearbox.axle_ratio;
    let axle_in = (axle_out + gearbox.axle_loss_torque_nm) / (1.0 - gearbox.axle_loss_share);
    let shaft_radps = speed_mps / vehicle.wheel_radius_m * gearbox.axle_ratio;
    let growth_nms2 = gearbox.retarder_torque_nms2.unwrap_or(0.0);
    let retarder = gearbox.retarder_torque_nm + growth_nms2 * shaft_radps * shaft_radps;
    let box_out = axle_in + retarder;
    let ratio = gearbox.ratio[gear];
    let turning = gearbox.loss_torque_nms.unwrap_or(0.0) * shaft_radps * ratio;
    let share = if ratio == 1.0 { gearbox.direct_loss_share } else { gearbox.indirect_loss_share };
    let torque = (box_out / ratio + gearbox.loss_torque_nm + turning) / (1.0 - share);
    assert!(torque > gearbox.loss_floor_nm.unwrap_or(0.0));
    torque + auxiliary_nm
}

#[test]
fn constant_speed_is_the_closed_form_to_1e_6() {
    let study = typical(&[]);
    // 48 m of climb: beyond 50 m the air density would be taken anew
    for (slope, speed_mps) in [(0.0, 80.0 / 3.6), (0.0, 60.0 / 3.6), (0.0008, 70.0 / 3.6)] {
        let scenario = GivenRoad::flat(60_000.0, speed_mps).slope(slope).scenario(&study);
        let vehicle = scenario.vehicle;
        let trace = trace_scenario(&study, scenario);
        let position = column(&trace, "position_m");
        let speed = column(&trace, "speed_mps");
        let gear = column(&trace, "gear");
        let (from, to) = (
            position.iter().position(|x| *x > 50_000.0).unwrap(),
            position.iter().position(|x| *x > 55_000.0).unwrap(),
        );
        let v = speed_mps;
        assert!(speed[from..to].iter().all(|s| (s / v - 1.0).abs() < 1e-9), "steady");

        let weather = ocmc_core::operating_cycle::weather::STANDARD_WEATHER;
        let crr = vehicle.rolling_coefficient
            * ocmc_core::vehicle::resistance::rolling_temperature_factor(288.15, 0.006);
        let cosine = (1.0f64 - slope * slope).sqrt();
        // the study's weather was replaced by the standard one at the altitude of the start, plus
        // the climb
        let force = |climb_m: f64| {
            let density = weather.air_density_kgpm3(climb_m);
            vehicle.mass_kg * GRAVITY_MPS2 * (crr * cosine + slope)
                + 0.5 * density * vehicle.drag_area_m2 * v * v
        };
        // one weather stretch, little climb: the density of the start holds all the way
        let wanted = force(0.0);
        let work: f64 = column(&trace, "wheel_energy_added_j")[from + 1..=to].iter().sum();
        let way: f64 = column(&trace, "distance_added_m")[from + 1..=to].iter().sum();
        assert!((work / (wanted * way) - 1.0).abs() < 1e-6, "{} {wanted}", work / way);

        let g = gear[to] as usize - 1;
        let w = v * study.vehicle().gears[g].speed_ratio_per_m;
        let torque = steady_torque_nm(&study, g, v, wanted, vehicle.auxiliary_power_w / w);
        let rate = diesel(&study).engine.fuel_kgps(w, torque) * vehicle.map_factor;
        let fuel: f64 = column(&trace, "fuel_added_kg")[from + 1..=to].iter().sum();
        let time: f64 = column(&trace, "step_s")[from + 1..=to].iter().sum();
        assert!((fuel / (rate * time) - 1.0).abs() < 1e-6, "{} {rate}", fuel / time);
    }
}

/// A truck in top gear at 20 m/s that wants 20.5 m/s on an endless constant row: nothing saturates
/// or shifts.
fn smooth(study: &Study, duration_s: f64) -> (f64, f64, f64) {
    dispatch!(Level::baseline(), simd => smooth_with(simd, study, duration_s))
}

fn smooth_with<S: Simd>(simd: S, study: &Study, duration_s: f64) -> (f64, f64, f64) {
    let all = |value| Lanes::splat(simd, value);
    let shared = KernelParameters::new(study, diesel(study));
    let mut state = State::parked(simd, &shared);
    let mut row = [0.0; RoadRow::COLUMNS];
    row[RoadRow::LENGTH] = 1e7;
    row[RoadRow::LIMIT] = 20.5 * 20.5;
    row[RoadRow::BACKWARD] = UNBOUNDED;
    row[RoadRow::GRADE] = 0.05;
    row[RoadRow::ROLLING] = 0.055;
    row[RoadRow::HALF_DENSITY] = 0.6;
    row[RoadRow::HEAD_WIND] = 2.0;
    row[RoadRow::CROSS_WIND] = 1.5;
    row[RoadRow::TO_STOP] = UNBOUNDED;
    row[RoadRow::GRIP] = 7.0;
    let mut row = RoadRow(row);
    row.set_static(20.5, true);
    row.set_coasting(0.0);
    state.motion.left[0] = row.0[RoadRow::LENGTH];
    state.motion.roads[0] = vec![row];
    state.constants.mass = all(30_000.0);
    state.constants.drag_area = all(5.3);
    state.powertrain.auxiliary_power = all(4700.0);
    state.powertrain.fuel_factor = all(1.0);
    state.set_gear(0, shared.vehicle.gears.len() - 1, &shared);
    state.motion.speed = all(20.0);
    state.motion.filtered = all(20.0);
    state.powertrain.torque = all(900.0);
    state.motion.integral = all(0.3);
    state.constants.proportional = all(0.4);
    state.constants.integral_gain = all(0.02);
    state.constants.derivative_over_filter = all(0.1);
    state.constants.tracking = all(0.1);
    state.motion.engine_speed = all(20.0 * state.gear.speed_ratio[0]);
    (state.motion.up_left, state.motion.down_left) = (all(f64::INFINITY), all(f64::INFINITY));
    state.motion.ceiling = all(UNBOUNDED);
    state.constants.least_ceiling = all(UNBOUNDED);
    state.constants.peak_ratio = all(UNBOUNDED);
    let steps = (duration_s / shared.short_step_s).round() as usize;
    for _ in 0..steps {
        state.motion.longest = all(shared.short_step_s);
        let view = state.step(&shared);
        assert!(view.accelerator[0] > 0.05 && view.accelerator[0] < 0.95);
    }
    (state.motion.speed[0], state.ledger[Term::Fuel][0], state.ledger[Term::Wheel][0])
}

#[test]
fn a_smooth_case_converges_with_second_order() {
    // steps of one length: the one that is allowed whatever acceleration does
    let at = |step: f64| {
        smooth(
            &typical(&[&format!("simulation.step_s={}", step / SimulationModel::SHORT_STEP_SHARE)]),
            8.0,
        )
    };
    let reference = at(0.002);
    let error = |r: (f64, f64, f64)| {
        [(r.0 - reference.0).abs(), (r.1 - reference.1).abs(), (r.2 - reference.2).abs()]
    };
    let (coarse, middle, fine) = (error(at(0.4)), error(at(0.2)), error(at(0.1)));
    for k in 0..3 {
        for (a, b) in [(coarse[k], middle[k]), (middle[k], fine[k])] {
            let order = (a / b).log2();
            assert!((1.7..2.4).contains(&order), "quantity {k}: order {order}");
        }
    }
}
