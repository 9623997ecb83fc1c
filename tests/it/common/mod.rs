//! Studies and hand-made roads for the whole-program tests.

use ocmc_core::energy::Carrier;
use ocmc_core::kernel::drive::cpu::CpuLevel;
use ocmc_core::kernel::drive::scheduler::drive;
use ocmc_core::kernel::drive::trace::Trace;
use ocmc_core::operating_cycle::road::Road;
use ocmc_core::operating_cycle::road::point_event::{EventKind, PointEvent};
use ocmc_core::operating_cycle::road::road_type::Section;
use ocmc_core::operating_cycle::road::speed_sign::SpeedSign;
use ocmc_core::operating_cycle::road::surface::Ground;
use ocmc_core::operating_cycle::weather::STANDARD_WEATHER;
use ocmc_core::operating_cycle::{OperatingCycle, TrafficStretch, WeatherStretch};
use ocmc_core::powertrain::PowertrainKind;
use ocmc_core::powertrain::combustion::CombustionPowertrain;
use ocmc_core::random::Streams;
use ocmc_core::record::Record;
use ocmc_core::study::{Scenario, Study};

/// A built-in study with settings, prepared.
pub(crate) fn study(name: &str, sets: &[&str]) -> Study {
    ocmc_io::study::load(name, sets).unwrap_or_else(|e| panic!("{e}")).study
}

/// Drives cycles 0 to n with seed 1 on two threads.
pub(crate) fn run(study: &Study, n: u64) -> Vec<Record> {
    std::thread::scope(|scope| {
        let half = n / 2;
        let first = scope.spawn(move || drive(study, 1, 0..half, CpuLevel::best()));
        let mut second = drive(study, 1, half..n, CpuLevel::best());
        let mut records = first.join().unwrap();
        records.append(&mut second);
        records
    })
}

/// A given road of motorway type, in standard weather, without other vehicles.
pub(crate) struct GivenRoad {
    pub length_m: f64,
    pub sign_mps: f64,
    /// Slope of each 25 m step; the last one goes on to the end.
    pub slopes: Vec<f64>,
    /// Position and standstill of stop signs.
    pub stops: Vec<(f64, f64)>,
    pub payload_kg: f64,
}

impl GivenRoad {
    pub(crate) fn flat(length_m: f64, sign_mps: f64) -> Self {
        Self { length_m, sign_mps, slopes: vec![0.0], stops: Vec::new(), payload_kg: 24_300.0 }
    }

    pub(crate) fn slope(mut self, slope: f64) -> Self {
        self.slopes = vec![slope];
        self
    }

    pub(crate) fn stop(mut self, position_m: f64, standstill_s: f64) -> Self {
        self.stops.push((position_m, standstill_s));
        self
    }

    /// The road, driven by driver 0 and truck 0 of the study with this payload.
    pub(crate) fn scenario(&self, study: &Study) -> Scenario {
        let mut scenario = study.sample(1, 0);
        let road_type = study.road_types().iter().position(|n| n == "motorway").unwrap();
        let steps = (self.length_m / 25.0).ceil() as usize;
        let last = *self.slopes.last().unwrap();
        let events = self.stops.iter().map(|&(position_m, standstill_s)| PointEvent {
            position_m,
            kind: EventKind::StopSign { standstill_s },
            turns: false,
        });
        let road = Road {
            length_m: self.length_m,
            sections: vec![Section { start_m: 0.0, end_m: self.length_m, road_type }],
            signs: vec![SpeedSign { start_m: 0.0, speed_mps: self.sign_mps }],
            curves: Vec::new(),
            slopes: (0..steps).map(|k| *self.slopes.get(k).unwrap_or(&last)).collect(),
            slope_step_m: 25.0,
            // IRI 1.5 mm/m, at which roughness does nothing
            roughness_m3: vec![(1.5f64 / 0.544).powi(2) * 1e-6; steps],
            roughness_block_m: 200.0,
            grounds: vec![Ground::Asphalt],
            events: events.collect(),
            heading_rad: 0.0,
            climb_reached: true,
            route: None,
        };
        let mut mission = scenario.cycle.mission.clone();
        mission.length_m = self.length_m;
        mission.payload_kg = self.payload_kg;
        scenario.cycle = OperatingCycle {
            mission,
            road,
            weather: vec![WeatherStretch { start_m: 0.0, weather: STANDARD_WEATHER }],
            traffic: vec![TrafficStretch { start_m: 0.0, density_per_m: 0.0 }],
            free_flow_s: 0.0,
        };
        scenario.curve_residuals = Vec::new();
        let streams = Streams::new(1, 0);
        let without = &study.model().simulation.without;
        scenario.vehicle = study.model().vehicle.sample(self.payload_kg, &streams, without);
        scenario
    }
}

/// The default study with the typical driver, by default with a PID, and the typical truck.
pub(crate) fn typical(sets: &[&str]) -> Study {
    let mut all = vec![
        "driver.pedals.pid_share=1.0",
        "simulation.without=[\"driver_spread\", \"vehicle_spread\"]",
    ];
    all.extend_from_slice(sets);
    study("field-truck", &all)
}

/// As [`typical`], in a truck that does not look ahead.
pub(crate) fn unassisted(sets: &[&str]) -> Study {
    let mut all =
        vec!["driver.look_ahead.eco_roll=false", "driver.look_ahead.predictive_cruise=false"];
    all.extend_from_slice(sets);
    typical(&all)
}

/// Engine and gearbox of a study that has them.
pub(crate) fn diesel(study: &Study) -> &CombustionPowertrain {
    match &study.vehicle().powertrain {
        PowertrainKind::Combustion(diesel) => diesel,
        _ => panic!("a diesel truck"),
    }
}

/// Engine speed at the start of each row, in rad/s: that of the wheels where the clutch is closed.
pub(crate) fn start_speeds_radps(study: &Study, trace: &Trace) -> Vec<f64> {
    let [speed, gear, closed, engine] =
        ["speed_mps", "gear", "clutch_closed", "engine_speed_radps"]
            .map(|name| column(trace, name));
    let gears = &study.vehicle().gears;
    let start = |k: usize| {
        let ratio_per_m = gears[gear[k] as usize - 1].speed_ratio_per_m;
        if k > 0 && closed[k] > 0.0 { speed[k - 1] * ratio_per_m } else { engine[k] }
    };
    (0..speed.len()).map(start).collect()
}

/// A column of a trace.
pub(crate) fn column<'a>(trace: &'a Trace, name: &str) -> &'a [f64] {
    let found = trace.columns.iter().find(|c| c.name == name);
    &found.unwrap_or_else(|| panic!("no column {name}")).values
}

/// Crankshaft work less everything that it went into, over the crankshaft work.
pub(crate) fn balance(r: &Record) -> f64 {
    let crank = r.crankshaft_work_j.unwrap();
    let spent = r.auxiliary_energy_j
        + r.clutch_loss_j.unwrap()
        + r.transmission_loss_j
        + r.shift_loss_j.unwrap()
        + r.drag_energy_j
        + r.rolling_energy_j
        + r.service_brake_energy_j
        + r.engine_brake_energy_j.unwrap()
        + r.kinetic_change_j
        + r.potential_change_j;
    (crank - spent) / crank.abs()
}

/// A column of a record; 0 where it has none.
pub(crate) fn number(record: &Record, name: &str) -> f64 {
    ocmc_core::record::column(name).unwrap().get(record).number().unwrap_or(0.0)
}

/// Energy that the battery's store lost, and that a fuel cell gave, less all its uses, over the
/// energy that moved.
pub(crate) fn electric_balance(r: &Record) -> f64 {
    let [open_j, given_j] = electric_open_j(r);
    open_j / given_j.abs().max(r.wheel_energy_j)
}

/// Energy that the stores have given and nothing has taken, and all that they have given, in J.
pub(crate) fn electric_open_j(r: &Record) -> [f64; 2] {
    let spent = r.battery_loss_j.unwrap()
        + r.motor_loss_j.unwrap()
        + r.auxiliary_energy_j
        + r.transmission_loss_j
        + r.shift_loss_j.unwrap()
        + r.drag_energy_j
        + r.rolling_energy_j
        + r.service_brake_energy_j
        + r.kinetic_change_j
        + r.potential_change_j;
    let cell = number(r, "fuel_cell_input_j") - number(r, "fuel_cell_loss_j");
    let given = r.amount(Carrier::Electricity).unwrap() + cell;
    [given - spent, given]
}

/// Mean and standard error.
pub(crate) fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let var = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (var / n).sqrt())
}

/// Sample standard deviation.
pub(crate) fn sd(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    mean_and_error(values).1 * n.sqrt()
}
