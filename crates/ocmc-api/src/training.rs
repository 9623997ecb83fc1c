//! Worth of training the drivers of a fleet who stand worst in its records.

use crate::answer::Answer;
use crate::cost::costing;
use crate::error::Error;
use crate::run::whole_trucks;
use crate::text::{fact, table, took};
use crate::watch::{Watch, watched};
use ocmc_core::cost::levelised::Levelised;
use ocmc_core::cost::state::State;
use ocmc_core::random::{Factor, PickFreeze, StreamSet};
use ocmc_core::record::Record;
use ocmc_fleet::quantity::LITRES;
use ocmc_fleet::run::{RunPlan, records};
use ocmc_fleet::training::{Choice, Gain, Price, Training, TrainingOptions};
use ocmc_io::label::label;
use ocmc_io::number_text::{count_of, grouped, percent, rough, rounded};
use ocmc_io::study::{LoadedStudy, study_hash};
use serde::Serialize;
use std::fmt::Write;
use std::ops::ControlFlow;
use std::time::Instant;

/// Drivers whose training is asked about.
#[derive(Clone, Debug)]
pub struct TrainingRequest<'a> {
    /// The study, and how the answer calls it.
    pub study: (String, &'a LoadedStudy),
    /// Changes by training in the study, as `KEY=VALUE`; where nothing is said, a trained driver
    /// drives as the middle fifth of drivers.
    pub coached: Vec<String>,
    /// Share of the drivers who are trained: those who stand worst in the records.
    pub share: f64,
    /// The cycles: whole trucks, each of which is driven twice.
    pub plan: RunPlan,
}

/// Worth of training.
#[derive(Clone, Debug, Serialize)]
pub struct TrainingAnswer {
    /// Name of the study.
    pub study: String,
    /// Hash of the resolved study.
    pub study_hash: String,
    /// Changes by training; nothing where a trained driver drives as the middle fifth.
    pub coached: Vec<String>,
    /// Master seed.
    pub seed: u64,
    /// Id of the first cycle.
    pub first_cycle: u64,
    /// Number of cycles, each of which was driven twice.
    pub cycles: u64,
    /// Share of the drivers who are trained.
    pub share: f64,
    /// Worth of training, over distance.
    #[serde(flatten)]
    pub training: Training,
    /// Distance of a chosen driver in a year, in m: of the trips that were driven.
    pub distance_m_per_a: f64,
    /// Saving by training in a year for each chosen driver: litres, or kWh.
    pub amount_per_a: f64,
    /// 95 % interval of that, over drivers.
    pub amount_per_a_ci95: Option<[f64; 2]>,
    /// Money a year for each chosen driver, in the currency of the study.
    pub money_per_a: Option<f64>,
    /// 95 % interval of that, over drivers.
    pub money_per_a_ci95: Option<[f64; 2]>,
    /// Code of the currency.
    pub currency: Option<String>,
    #[serde(skip)]
    wall_s: f64,
    #[serde(skip)]
    threads: usize,
}

/// Drives each trip by its own driver and by another one, or by the trained one, and finds what the
/// training of those who stand worst in the records is worth.
///
/// ```
/// use ocmc_api::{Answer, RunPlan, TrainingRequest, go_on, study, training};
/// let sets = ["mission.length_m=3000", "fleet.trips_per_truck=10"];
/// let loaded = study::load("field-truck", &sets)?;
/// let plan = RunPlan::new(1, 0, 120, None, None);
/// let study = ("mine".to_owned(), &loaded);
/// let request = TrainingRequest { study, coached: Vec::new(), share: 0.25, plan };
/// let answer = training(&request, &mut go_on)?;
/// assert_eq!((answer.training.drivers, answer.training.chosen), (12, 3));
/// assert!(answer.text().contains("the training gives"));
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::PartOfTruck`] where the cycles are no whole trucks, [`Error::Study`] where what
/// training changes is no value of the study, [`Error::NobodyToTrain`] where fewer than two drivers
/// completed a trip; [`Error::Interrupted`].
pub fn training(request: &TrainingRequest, watch: &mut Watch) -> Result<TrainingAnswer, Error> {
    let TrainingRequest { study: (name, loaded), coached, share, plan } = request;
    whole_trucks(&loaded.study, plan)?;
    let trained = if coached.is_empty() { None } else { Some(loaded.set(coached)?) };
    let clock = Instant::now();
    let (own, other) = watched(2 * plan.cycles, watch, |look| {
        let own = records(&loaded.study, plan, &mut *look)?;
        let later = |done| look(plan.cycles + done);
        let other = if let Some(trained) = &trained {
            records(&trained.study, plan, later)?
        } else {
            let streams = StreamSet::of_factor(Factor::Driver);
            let pick_freeze = PickFreeze { streams, cycle_id: Some(0) };
            records(&loaded.study, &RunPlan { pick_freeze, ..*plan }, later)?
        };
        ControlFlow::Continue((own, other))
    })?;
    let costing = costing(loaded);
    let central = costing.as_ref().map(|costing| Levelised::of(costing, &State::central(costing)));
    let price = |record: &Record| Some(central.as_ref()?.cost(&costing.as_ref()?.trip(record)?));
    let options = TrainingOptions { share: *share, is_trained: trained.is_some(), seed: plan.seed };
    let price = costing.is_some().then_some(&price as Price);
    let training = Training::of(&own, &other, &options, price)
        .ok_or_else(|| Error::NobodyToTrain(name.clone()))?;
    let distance_m_per_a = training.distance_m / years(loaded) as f64;
    let km_per_a = distance_m_per_a / 1000.0;
    // litres over 100 km, kWh over km
    let amount = if training.column == LITRES { km_per_a / 100.0 } else { km_per_a };
    let Gain { of_quantity, of_quantity_ci95, money_per_km, money_per_km_ci95, .. } = training.gain;
    let times = |ci95: Option<[f64; 2]>, factor: f64| ci95.map(|ends| ends.map(|x| factor * x));
    Ok(TrainingAnswer {
        study: name.clone(),
        study_hash: study_hash(&loaded.model),
        coached: coached.clone(),
        seed: plan.seed,
        first_cycle: plan.first_cycle,
        cycles: plan.cycles,
        share: *share,
        distance_m_per_a,
        amount_per_a: amount * of_quantity,
        amount_per_a_ci95: times(of_quantity_ci95, amount),
        money_per_a: money_per_km.map(|money| km_per_a * money),
        money_per_a_ci95: times(money_per_km_ci95, km_per_a),
        currency: costing.map(|costing| costing.currency),
        training,
        wall_s: clock.elapsed().as_secs_f64(),
        threads: plan.threads,
    })
}

/// Years that the trips of a truck take.
pub(crate) fn years(loaded: &LoadedStudy) -> u64 {
    let nesting = loaded.study.nesting();
    let last = nesting.trips_per_truck.saturating_sub(1);
    nesting.days.map_or(1, |days| 1 + days.day_of(last) / 365)
}

impl Answer for TrainingAnswer {
    fn text(&self) -> String {
        let training = &self.training;
        let mut text = fact("study", &self.study);
        text.push_str(&fact("seed", self.seed));
        let pairs = format!("{}, each driven twice", count_of(training.pairs, "trip"));
        text.push_str(&fact("trips", pairs));
        text.push_str(&took(self.wall_s, self.threads, 2 * self.cycles));
        if training.left_out > 0 {
            let left_out = count_of(training.left_out, "trip");
            text.push_str(&fact("left out", format!("{left_out} not completed")));
        }
        let to = if self.coached.is_empty() {
            " drive as the middle fifth.".to_owned()
        } else {
            format!(" are trained:\n  {}", self.coached.join("\n  "))
        };
        let _ = writeln!(
            text,
            "\n{} of {} drivers, the worst in the records,{to}\n",
            training.chosen, training.drivers
        );
        text.push_str(&self.worth());
        let reliability = training.reliability.map_or_else(
            || "Drivers do not differ beyond chance in the records.\n".to_owned(),
            |share| {
                format!(
                    "A mean of the records is {} % driver and truck, the rest is chance.\n",
                    percent(share)
                )
            },
        );
        text.push_str(&reliability);
        let _ = writeln!(
            text,
            "Of the chosen {} % are truly among the worst {} %.",
            percent(training.truly_worst),
            percent(self.share)
        );
        text.push_str(&self.choices());
        text
    }
}

impl TrainingAnswer {
    /// Worth of training, over distance and a year.
    fn worth(&self) -> String {
        let training = &self.training;
        let (unit, factor) = label(training.column);
        let km_per_a = self.distance_m_per_a / 1000.0;
        let litres = training.column == LITRES;
        let amount = |gain: f64| rounded(gain * if litres { km_per_a / 100.0 } else { km_per_a });
        let plain = |name: &str, gain: f64| {
            [name.to_owned(), rounded(factor * gain), String::new(), amount(gain), String::new()]
        };
        let with = |name: &str, gain: &Gain| {
            let range = gain.of_quantity_ci95.map_or("-".to_owned(), |[low, high]| {
                format!("{} to {}", rounded(factor * low), rounded(factor * high))
            });
            let money = gain.money_per_km.map_or(String::new(), |m| rounded(km_per_a * m));
            let gain = gain.of_quantity;
            [name.to_owned(), rounded(factor * gain), range, amount(gain), money]
        };
        let mut rows = vec![plain("the records show", training.shown)];
        rows.extend(training.expected.map(|gain| plain("of it would come back", gain)));
        rows.push(with("the training gives", &training.gain));
        rows.push(with("if the worst were known", &training.gain_if_known));
        let per_a = if litres { "L per year" } else { "kWh per year" };
        let money = self.currency.as_ref().map_or(String::new(), |code| format!("{code} per year"));
        let head = ["", unit, "95 %", per_a, money.as_str()];
        let time = training.gain.time_s_per_m * self.distance_m_per_a / 3600.0;
        let mut text = table(&[25, 11, 18, 13, 13], &head, rows);
        let _ = writeln!(
            text,
            "for each of them, in a year of {} km; they then drive {} h {}.",
            grouped(km_per_a.round() as u64),
            rough(time.abs()),
            if time < 0.0 { "longer" } else { "less" }
        );
        if let (Some(money), Some([low, high]), Some(code)) =
            (self.money_per_a, self.money_per_a_ci95, &self.currency)
        {
            let [money, low, high] = [money, low, high].map(rounded);
            let _ = writeln!(text, "Money: {money} {code} ({low} to {high}) a year for each.");
        }
        text.push('\n');
        text
    }

    /// How the choice depends on the records.
    fn choices(&self) -> String {
        let (_, factor) = label(self.training.column);
        let row = |choice: &Choice| {
            [
                grouped(choice.trips as u64),
                percent(choice.truly_worst),
                rounded(factor * choice.shown),
                rounded(factor * choice.gain),
            ]
        };
        let head = ["trips recorded", "truly worst, %", "records show", "training gives"];
        let rows = self.training.by_trips.iter().map(row);
        format!("\n{}", table(&[16, 16, 14, 16], &head, rows))
    }
}
