//! The pictures of the driving-simulator study: curve speeds, accelerations, identified gains and
//! set speeds, recorded against simulated drives, each driver's panel.

use super::panel::{Mark, Panel, colour};
use super::simulator_study::{DriveSeries, SimulatorEvent, SimulatorRepetition};
use super::speed_over_distance::standalone;
use super::svg::{begin, label};

/// Metres a second in kilometres an hour.
const KMH: f64 = 3.6;
/// Most points of a line.
const MOST_POINTS: usize = 400;
/// Colours of what is recorded and of what is simulated, as in the paper.
const RECORDED: &str = "stroke=\"#2e9e4f\" stroke-width=\"1.6\"";
const SIMULATED: &str = "stroke=\"#2f6fd0\" stroke-width=\"1.6\"";
const LIMIT: &str = "stroke=\"#8a8a8a\" stroke-dasharray=\"5 4\"";
/// Colours of climbs and descents.
const UPHILL: &str = "#d55e00";
const DOWNHILL: &str = "#0072b2";

/// A picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Name of its file, without ending.
    pub name: &'static str,
    /// Caption of the picture.
    pub caption: String,
    /// It, as SVG that takes its letters and axes from a page.
    svg: String,
}

impl Picture {
    fn new(name: &'static str, caption: impl Into<String>, svg: String) -> Self {
        Self { name, caption: caption.into(), svg: svg + "</svg>\n" }
    }
    /// As SVG that takes its letters and axes from a page.
    pub(super) fn svg(&self) -> &str {
        &self.svg
    }

    /// As SVG that stands alone.
    pub fn standalone(&self) -> String {
        standalone(&self.svg)
    }
}

/// The pictures of a repetition, in the order of the paper.
pub fn pictures(repetition: &SimulatorRepetition) -> Vec<Picture> {
    let mut all = vec![curve_speeds(repetition), accelerations(repetition)];
    if !repetition.events.is_empty() {
        all.extend([
            gains(repetition),
            gains_by_direction(repetition),
            set_speeds(repetition),
            one_event(repetition),
        ]);
    }
    all.push(drives(repetition));
    all
}

/// Speed over radius, with both laws.
fn curve_speeds(repetition: &SimulatorRepetition) -> Picture {
    let (width, height) = (960.0, 420.0);
    let panel = Panel::new([110.0, 265.0], [30.0, 80.0], [50.0, 24.0, 890.0, 344.0]);
    let mut svg = begin(width, height, "Speed in curves over their radius");
    panel.across(&mut svg, &[30.0, 40.0, 50.0, 60.0, 70.0, 80.0], "km/h");
    let ticks = [125.0, 175.0, 250.0].map(|radius: f64| (radius, format!("{radius:.0}")));
    panel.along(&mut svg, &ticks, "radius, m");
    panel.line(&mut svg, [(110.0, 70.0), (265.0, 70.0)], LIMIT);
    let laws = [
        "stroke=\"#8a8a8a\" stroke-width=\"2\"",
        "stroke=\"#8a8a8a\" stroke-dasharray=\"2 4\" stroke-width=\"2\"",
    ];
    for ([exponent, speed_mps], how) in repetition.curve_laws.into_iter().zip(laws) {
        let point = |k: u32| {
            let radius_m = 110.0 + 5.0 * f64::from(k);
            let ratio = radius_m / repetition.reference_radius_m;
            (radius_m, KMH * speed_mps * ratio.powf(exponent))
        };
        panel.line(&mut svg, (0..=31).map(point), how);
    }
    for curve in &repetition.curves {
        let mark = if curve.left { Mark::Cross } else { Mark::Circle };
        // drivers beside one another, as far as there is room
        let beside_m = 1.1 * (curve.driver as f64 - 4.5);
        let title = format!("driver {}, {:.1} km/h", curve.driver, KMH * curve.speed_mps);
        let point = (curve.radius_m + beside_m, KMH * curve.speed_mps);
        panel.mark(&mut svg, point, mark, colour(curve.driver - 1), &title);
    }
    let [[exponent, speed_mps], _] = repetition.curve_laws;
    let caption = format!(
        "Speed in curves: left (+) and right (o), a colour a driver; limit (dashed); the law with \
         the estimated exponent {exponent:.2} and {:.1} km/h at {:.0} m (line), and with exponent \
         0.5 (dotted).",
        KMH * speed_mps,
        repetition.reference_radius_m
    );
    Picture::new("curve-speed", caption, svg)
}

/// Accelerations by kind of change.
fn accelerations(repetition: &SimulatorRepetition) -> Picture {
    let (width, height) = (960.0, 420.0);
    let kinds = repetition.medians_mps2.len() as f64;
    let panel = Panel::new([0.0, kinds], [-2.5, 1.0], [50.0, 24.0, 890.0, 344.0]);
    let mut svg = begin(width, height, "Accelerations by change of the limit");
    let [low, high] = repetition.within_mps2;
    panel.filled(&mut svg, [0.0, kinds], [low, high], "fill=\"#8a8a8a\" fill-opacity=\"0.25\"");
    panel.across(&mut svg, &[-2.5, -2.0, -1.5, -1.0, -0.5, 0.0, 0.5, 1.0], "m/s²");
    let names: Vec<(f64, String)> = repetition
        .medians_mps2
        .iter()
        .enumerate()
        .map(|(k, median)| (k as f64 + 0.5, median.0.to_owned()))
        .collect();
    panel.along(&mut svg, &names, "change of the limit, km/h");
    for (k, (kind, ours, paper)) in repetition.medians_mps2.iter().enumerate() {
        let k = k as f64;
        let ours = ours.unwrap_or(f64::NAN);
        panel.line(&mut svg, [(k + 0.1, *paper), (k + 0.9, *paper)], LIMIT);
        let ends = [(k + 0.1, ours), (k + 0.9, ours)];
        panel.line(&mut svg, ends, "stroke=\"#8a8a8a\" stroke-width=\"2\"");
        for change in repetition.changes.iter().filter(|change| change.change == *kind) {
            let point = (k + 0.1 + change.driver as f64 / 11.25, change.acceleration_mps2);
            let title = format!("driver {}, {:.2} m/s²", change.driver, point.1);
            panel.mark(&mut svg, point, Mark::Dot, colour(change.driver - 1), &title);
        }
    }
    let caption = format!(
        "Accelerations at changes of the limit, a colour a driver; the median (line) and that of \
         the paper (dashed). What lies in the grey band, {low} to {high} m/s², does not count."
    );
    Picture::new("accelerations", caption, svg)
}

const GAINS: [&str; 3] = ["K_P, s/m", "K_I, 1/m", "K_D, s²/m"];
/// Upper ends of the axes of the gains: as in the paper, larger ones end there.
const SHOWN: [f64; 3] = [2.0, 0.2, 1.0];

/// Bars of the gains of these events, in three panels; what ended at a bound has a dark edge.
fn gain_bars(svg: &mut String, events: &[&SimulatorEvent], ticks: &[(f64, String)], what: &str) {
    let names = ["kp", "ki", "kd"];
    for (k, (gain, most)) in GAINS.into_iter().zip(SHOWN).enumerate() {
        let frame = [50.0, 28.0 + 180.0 * k as f64, 890.0, 130.0];
        let panel = Panel::new([0.0, events.len() as f64], [0.0, most], frame);
        panel.across(svg, &[0.0, 0.5 * most, most], gain);
        panel.along(svg, ticks, if k == 2 { what } else { "" });
        for (place, event) in events.iter().enumerate() {
            let fill = if event.grade > 0.0 { UPHILL } else { DOWNHILL };
            let edge = if event.at_bound.contains(&names[k]) {
                " stroke=\"currentColor\" stroke-width=\"1.5\""
            } else {
                ""
            };
            let x = [place as f64 + 0.12, place as f64 + 0.88];
            panel.filled(svg, x, [0.0, event.gains[k]], &format!("fill=\"{fill}\"{edge}"));
            let truth = event.true_gains[k];
            panel.line(svg, x.map(|x| (x, truth)), "stroke=\"currentColor\" stroke-width=\"1.2\"");
        }
    }
}

/// Gains by driver and event.
fn gains(repetition: &SimulatorRepetition) -> Picture {
    let mut svg = begin(960.0, 580.0, "Identified gains by driver and event");
    let events: Vec<&SimulatorEvent> = repetition.events.iter().collect();
    gain_bars(&mut svg, &events, &driver_ticks(&repetition.events), EVENTS_OF_DRIVERS);
    let caption = "Identified gains, one fit for each driver and event: climbs (orange) and \
                   descents (blue); a dark edge where the gain ended at a bound, a black line \
                   where the driver's own gain lies. Axes are cut off as in the paper.";
    Picture::new("gains", caption, svg)
}

const EVENTS_OF_DRIVERS: &str = "events of each driver, in the order in which they were met";

/// Names of the drivers, each in the middle of its events.
fn driver_ticks(events: &[SimulatorEvent]) -> Vec<(f64, String)> {
    let of_driver = |driver: usize| {
        let is_own = |event: &SimulatorEvent| event.driver == driver;
        let (first, last) = (events.iter().position(is_own)?, events.iter().rposition(is_own)?);
        Some((0.5 * (first + last + 1) as f64, format!("driver {driver}")))
    };
    (1..=8).filter_map(of_driver).collect()
}

/// The same, climbs first.
fn gains_by_direction(repetition: &SimulatorRepetition) -> Picture {
    let mut svg = begin(960.0, 580.0, "Identified gains, climbs and descents apart");
    let mut events: Vec<&SimulatorEvent> = repetition.events.iter().collect();
    events.sort_by(|a, b| b.grade.total_cmp(&a.grade).then(a.driver.cmp(&b.driver)));
    let mut ticks: Vec<(f64, String)> = Vec::new();
    for group in events.chunk_by(|a, b| a.event == b.event) {
        let before = events.iter().take_while(|event| event.event != group[0].event).count();
        ticks.push((before as f64 + 0.5 * group.len() as f64, group[0].event.clone()));
    }
    gain_bars(&mut svg, &events, &ticks, "events of all drivers, steepest climb first");
    let uphill = |event: &&&SimulatorEvent| event.grade > 0.0;
    let bound = |event: &&&SimulatorEvent| event.at_bound.iter().any(|name| name.starts_with('k'));
    let (all, ended) =
        (events.iter().filter(uphill).count(), events.iter().filter(uphill).filter(bound).count());
    let down = events.iter().filter(|event| event.grade < 0.0);
    let caption = format!(
        "The same gains, climbs and descents apart: {ended} of {all} climbs and {} of {} descents \
         end with a gain at a bound.",
        down.clone().filter(bound).count(),
        down.count()
    );
    Picture::new("gains-by-direction", caption, svg)
}

/// Set speeds by driver and event.
fn set_speeds(repetition: &SimulatorRepetition) -> Picture {
    let n = repetition.events.len() as f64;
    let panel = Panel::new([0.0, n], [60.0, 80.0], [50.0, 24.0, 890.0, 244.0]);
    let mut svg = begin(960.0, 320.0, "Identified set speeds");
    panel.across(&mut svg, &[60.0, 65.0, 70.0, 75.0, 80.0], "km/h");
    panel.along(&mut svg, &driver_ticks(&repetition.events), EVENTS_OF_DRIVERS);
    panel.line(&mut svg, [(0.0, 70.0), (n, 70.0)], LIMIT);
    for (place, event) in repetition.events.iter().enumerate() {
        let place = place as f64;
        let fill = if event.grade > 0.0 { UPHILL } else { DOWNHILL };
        let top = KMH * event.set_speed_mps;
        let how = format!("fill=\"{fill}\"");
        panel.filled(&mut svg, [place + 0.12, place + 0.88], [60.0, top], &how);
        let wanted = KMH * event.wanted_mps;
        let ends = [(place + 0.05, wanted), (place + 0.95, wanted)];
        panel.line(&mut svg, ends, "stroke=\"currentColor\" stroke-width=\"1.2\"");
    }
    let caption = "Identified set speeds: climbs (orange) and descents (blue), the limit \
                   (dashed), and what the driver wants (black).";
    Picture::new("set-speeds", caption, svg)
}

/// One signal of a drive.
type Signal = fn(&DriveSeries) -> &Vec<f64>;

/// Recorded against simulated speed and pedals, for the steepest descent of the second driver.
fn one_event(repetition: &SimulatorRepetition) -> Picture {
    let second = repetition.events.iter().filter(|event| event.driver == 2);
    let steepest = second.min_by(|a, b| a.grade.total_cmp(&b.grade));
    let event = steepest.or(repetition.events.first()).expect("events are there");
    let mut svg = begin(960.0, 580.0, "Recorded against simulated speed and pedals");
    let (recorded, simulated) = (&event.recorded, &event.simulated);
    let start_m = recorded.position_m.first().copied().unwrap_or(0.0);
    let end_m = recorded.position_m.last().copied().unwrap_or(1.0);
    let extremes = |values: &[f64]| {
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        [low, values.iter().copied().fold(f64::NEG_INFINITY, f64::max)]
    };
    let [slow, fast] = extremes(&recorded.speed_mps).map(|speed| KMH * speed);
    let speeds = [5.0 * (slow / 5.0 - 0.2).floor(), 5.0 * (fast / 5.0 + 0.2).ceil()];
    let brakes = [0.0, (10.0 * extremes(&recorded.brake)[1]).ceil().max(1.0) / 10.0];
    let signals: [(&str, [f64; 2], f64, Signal); 3] = [
        ("speed, km/h", speeds, KMH, |series| &series.speed_mps),
        ("accelerator", [0.0, 1.0], 1.0, |series| &series.accelerator),
        ("brake", brakes, 1.0, |series| &series.brake),
    ];
    for (k, (name, range, factor, signal)) in signals.into_iter().enumerate() {
        let frame = [50.0, 28.0 + 180.0 * k as f64, 890.0, 140.0];
        let panel = Panel::new([0.0, end_m - start_m], range, frame);
        panel.across(&mut svg, &[range[0], f64::midpoint(range[0], range[1]), range[1]], name);
        let ticks: Vec<(f64, String)> = (0..=((end_m - start_m) / 100.0) as usize)
            .map(|k| (100.0 * k as f64, format!("{}", 100 * k)))
            .collect();
        panel.along(&mut svg, &ticks, if k == 2 { "m behind the start of the event" } else { "" });
        for (series, how) in [(recorded, RECORDED), (simulated, SIMULATED)] {
            let point = |k| (series.position_m[k] - start_m, factor * signal(series)[k]);
            panel.line(&mut svg, thinned(series, MOST_POINTS).map(point), how);
        }
    }
    let caption = format!(
        "Driver {}, {}: recorded (green) and simulated with the identified gains (blue).",
        event.driver, event.event
    );
    Picture::new("event", caption, svg)
}

/// Places of so many points of a series, the last one among them.
fn thinned(series: &DriveSeries, most: usize) -> impl Iterator<Item = usize> + use<> {
    let rows = series.position_m.len();
    let every = rows.div_ceil(most).max(1);
    (0..rows).step_by(every).chain(rows.checked_sub(1))
}

/// The speed of each driver over the way, with the simulated events on it.
fn drives(repetition: &SimulatorRepetition) -> Picture {
    let (height, step) = (36.0 + 150.0 * repetition.drives.len() as f64, 150.0);
    let mut svg = begin(960.0, height, "Speed of each driver over the way");
    for (k, drive) in repetition.drives.iter().enumerate() {
        let series = &drive.series;
        let end_m = series.position_m.last().copied().unwrap_or(1.0);
        let panel =
            Panel::new([0.0, end_m], [0.0, 80.0], [50.0, 22.0 + step * k as f64, 890.0, 104.0]);
        panel.across(&mut svg, &[0.0, 20.0, 40.0, 60.0, 80.0], "");
        let ticks: Vec<(f64, String)> = (0..=(end_m / 2000.0) as usize)
            .map(|k| (2000.0 * k as f64, (2 * k).to_string()))
            .collect();
        panel.along(&mut svg, &ticks, "");
        let at = [panel.x.to[0], panel.y.to[1] - 6.0];
        label(&mut svg, at, "start", "name", &format!("driver {}: km/h over km", k + 1));
        let way = |k: usize| series.position_m[k];
        let limits = thinned(series, MOST_POINTS).map(|k| (way(k), KMH * drive.limit_mps[k]));
        panel.line(&mut svg, limits, LIMIT);
        let speeds = thinned(series, MOST_POINTS).map(|k| (way(k), KMH * series.speed_mps[k]));
        panel.line(&mut svg, speeds, RECORDED);
        for event in repetition.events.iter().filter(|event| event.driver == k + 1) {
            let series = &event.simulated;
            let point = |k: usize| (series.position_m[k], KMH * series.speed_mps[k]);
            panel.line(&mut svg, thinned(series, MOST_POINTS / 10).map(point), SIMULATED);
        }
    }
    let caption = "Speed of each driver: recorded (green), simulated on the slopes with the \
                   identified gains (blue), limit (dashed).";
    Picture::new("drivers", caption, svg)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::{SimulatorCurve, SimulatorDrive};

    fn event(driver: usize, grade: f64, at_bound: Vec<&'static str>) -> SimulatorEvent {
        let series = DriveSeries {
            position_m: vec![0.0, 50.0, 120.0],
            speed_mps: vec![19.0, 18.0, 19.0],
            accelerator: vec![0.3, 1.0, 0.4],
            brake: vec![0.0; 3],
        };
        SimulatorEvent {
            driver,
            event: format!("{:+.1} %", 100.0 * grade),
            grade,
            gains: [5.0, 1e-4, 0.1],
            true_gains: [1.0, 0.05, 0.05],
            bounds: [2.0, 0.2, 2.0],
            at_bound,
            set_speed_mps: 19.0,
            wanted_mps: 19.4,
            recorded: series.clone(),
            simulated: series,
        }
    }

    #[test]
    fn pictures_hold_every_event_and_no_number_that_is_none() {
        let series = event(1, 0.05, Vec::new()).recorded;
        let curve = SimulatorCurve {
            repetition: 0,
            driver: 1,
            radius_m: 125.0,
            left: true,
            speed_mps: f64::NAN,
        };
        let mut repetition = SimulatorRepetition {
            curves: vec![curve.clone(), SimulatorCurve { speed_mps: 15.0, ..curve }],
            curve_laws: [[0.2, 16.0], [0.5, 18.0]],
            reference_radius_m: 250.0,
            medians_mps2: vec![("70-to-40", None, -1.16)],
            within_mps2: [-0.4, 0.2],
            events: vec![event(1, 0.055, vec!["ki"]), event(2, -0.055, Vec::new())],
            drives: vec![SimulatorDrive { series, limit_mps: vec![19.4; 3] }],
            ..SimulatorRepetition::default()
        };
        let all = pictures(&repetition);
        let names: Vec<&str> = all.iter().map(|picture| picture.name).collect();
        let gains = ["gains", "gains-by-direction", "set-speeds", "event"];
        let wanted = [&["curve-speed", "accelerations"][..], &gains, &["drivers"]].concat();
        assert_eq!(names, wanted);
        assert!(all.iter().all(|picture| !picture.standalone().contains("NaN")));
        // the curve without a speed has no mark; three gains of two events, one at a bound
        assert_eq!(all[0].svg().matches("<title>driver 1").count(), 1);
        assert_eq!(all[2].svg().matches("<rect").count(), 6);
        assert_eq!(all[2].svg().matches("<rect fill=\"#d55e00\" stroke").count(), 1);
        let [climbs, descents] = ["1 of 1 climbs", "0 of 1 descents"];
        assert!(all[3].caption.contains(climbs) && all[3].caption.contains(descents));
        repetition.events.clear();
        assert_eq!(pictures(&repetition).len(), 3);
    }

    #[test]
    fn a_thinned_series_keeps_its_ends() {
        let series = DriveSeries { position_m: vec![0.0; 1001], ..DriveSeries::default() };
        let rows: Vec<usize> = thinned(&series, 100).collect();
        assert_eq!((rows[0], rows[rows.len() - 1]), (0, 1000));
        assert!(rows.len() <= 102);
        assert_eq!(thinned(&DriveSeries::default(), 10).count(), 0);
    }
}
