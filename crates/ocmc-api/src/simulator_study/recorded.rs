//! Measurements of one drive of the simulator, as off a log: curves, speed changes, and the signals
//! of its slopes.

use ocmc_core::kernel::drive::trace::trace;
use ocmc_core::study::Study;
use ocmc_estimation::fit::speed_change::{SpeedChangeOptions, SpeedLog, accelerations};
use ocmc_estimation::identification::event::PedalLog;
use ocmc_estimation::log::TripLog;
use ocmc_estimation::log::curve::{Correction, CurveOptions, DrivenCurve, detect_curves};

/// One drive.
#[derive(Clone, Debug)]
pub(super) struct Recorded {
    pub(super) curves: Vec<DrivenCurve>,
    /// Kind of each change of the limit, and its acceleration, in m/s².
    pub(super) changes: Vec<(String, f64)>,
    /// The signals, where they are kept.
    pub(super) signals: Option<Signals>,
}

/// The signals of a drive.
#[derive(Clone, Debug)]
pub(super) struct Signals {
    pub(super) log: PedalLog,
    pub(super) limit_mps: Vec<f64>,
    /// Speed that the driver wants on the free road, in m/s.
    pub(super) wanted_mps: f64,
    /// K_P, K_I and K_D of the driver.
    pub(super) gains: [f64; 3],
}

impl Recorded {
    /// Drives a cycle; `keep` its signals. None where the log of it cannot be read, as of a truck
    /// that never starts.
    pub(super) fn of(study: &Study, seed: u64, cycle_id: u64, keep: bool) -> Option<Self> {
        let columns = trace(study, seed, cycle_id).columns;
        let column = |name: &str| {
            let column = columns.iter().find(|column| column.name == name);
            &column.expect("traces have it").values
        };
        let [time_s, speed_mps, limit_mps] =
            ["time_s", "speed_mps", "limit_mps"].map(|name| column(name).as_slice());
        let log = TripLog {
            time_s: time_s.into(),
            speed_mps: speed_mps.into(),
            yaw_rate_radps: column("yaw_rate_radps").as_slice().into(),
            limit_mps: Some(limit_mps.into()),
            ..TripLog::default()
        };
        // the signals of a simulation have neither bias nor lag
        let exact = Correction::Given(0.0);
        let options =
            CurveOptions { gyro_bias_radps: exact, speed_lag_s: exact, ..CurveOptions::default() };
        let curves = detect_curves(&log, &options).ok()?.curves;
        let log = SpeedLog { time_s, speed_mps, limit_mps };
        let changes = accelerations(&log, &SpeedChangeOptions::default()).ok()?.changes;
        let signals = keep.then(|| {
            let scenario = study.sample(seed, cycle_id);
            let pedals = scenario.driver.pedals;
            let free_mps = limit_mps.first().copied().unwrap_or(f64::NAN);
            Signals {
                log: PedalLog {
                    time_s: time_s.to_vec(),
                    speed_mps: speed_mps.to_vec(),
                    accelerator: column("accelerator").clone(),
                    brake: column("brake").clone(),
                    grade: column("grade").clone(),
                    position_m: Some(column("position_m").clone()),
                    gear: column("gear").clone().into(),
                    ..PedalLog::default()
                },
                limit_mps: limit_mps.to_vec(),
                wanted_mps: scenario.driver.speed_limit.compliance * free_mps,
                gains: [pedals.proportional, pedals.integral, pedals.derivative],
            }
        });
        Some(Self { curves, changes, signals })
    }
}
