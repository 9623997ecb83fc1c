//! From logs to the pedal gains of their drivers: each event of each log.

use super::LogFile;
use super::pedals::events;
use crate::intake::FileAccount;
use crate::number_text::grouped;
use ocmc_core::study::Study;
use ocmc_estimation::identification::identify::EventFit;
use ocmc_estimation::identification::one_truck::{NamedEvent, identify_log};
use ocmc_estimation::identification::options::IdentifyOptions;
use ocmc_estimation::identification::population::Population;
use serde::Serialize;
use std::sync::atomic::{AtomicBool, Ordering};

/// Most drives and events without a fit that are named one by one.
const MOST_TOLD: usize = 5;

/// A drive or an event without a fit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LeftOut {
    /// Where it stands.
    pub place: String,
    /// Why there is no fit.
    pub reason: String,
    /// The reason without its numbers.
    #[serde(skip)]
    pub kind: &'static str,
}

/// Mass of the truck that was driven, by all events of a log.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TruckMass {
    /// The driver.
    pub driver: String,
    /// Events of the log.
    pub events: usize,
    /// Mass, in kg.
    pub mass_kg: f64,
    /// Its standard error, in kg.
    pub error_kg: f64,
    /// Mass of the study's truck with its mean payload, in kg.
    pub study_mass_kg: f64,
}

impl TruckMass {
    /// The mass in words.
    pub fn text(&self) -> String {
        let Self { driver, events, .. } = self;
        let [mass, error, study] = [self.mass_kg, self.error_kg, self.study_mass_kg]
            .map(|kg| grouped(kg.round().max(0.0) as u64));
        format!(
            "driver {driver}: his {events} events say that the truck weighs {mass} ± {error} kg \
             (the study's: {study} kg)"
        )
    }
}

/// Events on their way to fits.
#[derive(Clone, Debug, Default)]
pub struct Identification {
    /// Events without an answer yet: those of each log and driver, driven with one truck, and where
    /// they stand.
    waiting: Vec<Vec<(String, NamedEvent)>>,
    /// Fits that were found.
    pub fits: Vec<EventFit>,
    /// Drives without a fit, in the order in which that was noticed.
    pub left_out: Vec<LeftOut>,
    /// Mass of the truck of each log, by all its events.
    pub trucks: Vec<TruckMass>,
    /// Notes on parts of the drives that were not used.
    pub notes: Vec<String>,
    /// Files that were read.
    pub inputs: Vec<FileAccount>,
}

impl Identification {
    /// Adds the events of a log, driven with the truck and by a driver of a study.
    pub fn add(&mut self, file: &LogFile, study: &Study) {
        self.inputs.push(file.read.clone());
        let first = self.waiting.len();
        for drive in &file.drives {
            let place = file.place(drive);
            let (reason, kind) = match events(drive, &place, study) {
                Ok((events, notes)) => {
                    self.notes.extend(notes);
                    if !events.is_empty() {
                        let events = events.into_iter().map(|event| (place.clone(), event));
                        let same = |group: &&mut Vec<(String, NamedEvent)>| {
                            group.iter().all(|(_, event)| event.driver == drive.driver)
                        };
                        match self.waiting[first..].iter_mut().find(same) {
                            Some(group) => group.extend(events),
                            None => self.waiting.push(events.collect()),
                        }
                        continue;
                    }
                    let reason = "no event in the rows that can be used: a log needs the label \
                        `event`, or slopes of 0.5 % or more";
                    (reason.to_owned(), "no event in them")
                }
                Err(fault) => (fault.to_string(), "time that runs backwards"),
            };
            self.left_out.push(LeftOut { place, reason, kind });
        }
    }

    /// Events without an answer yet.
    pub fn waiting(&self) -> usize {
        self.waiting.iter().map(Vec::len).sum()
    }

    /// Answers them, those of a truck together; `done` counts them. Ends soon once `stop` is set,
    /// with the answers so far.
    pub fn identify(
        &mut self,
        study: &Study,
        options: &IdentifyOptions,
        stop: &AtomicBool,
        mut done: impl FnMut(usize),
    ) {
        let mut answered = 0;
        for truck in std::mem::take(&mut self.waiting) {
            let (places, events): (Vec<String>, Vec<NamedEvent>) = truck.into_iter().unzip();
            let log_fit = identify_log(study, &events, options, stop, &mut || {
                answered += 1;
                done(answered);
            });
            if let (Some([mass_kg, error_kg]), Some(event)) = (log_fit.mass_kg, events.first()) {
                let model = study.model();
                self.trucks.push(TruckMass {
                    driver: event.driver.clone(),
                    events: events.len(),
                    mass_kg,
                    error_kg,
                    study_mass_kg: model.vehicle.curb_mass_kg + model.mission.payload_kg.centre(),
                });
            }
            for ((place, event), fit) in places.iter().zip(&events).zip(log_fit.fits) {
                match fit {
                    Ok(fit) => self.fits.push(fit),
                    Err(fault) => self.left_out.push(LeftOut {
                        place: format!("event `{}` of {place}", event.event),
                        reason: fault.to_string(),
                        kind: fault.kind(),
                    }),
                }
            }
            if stop.load(Ordering::Relaxed) {
                return;
            }
        }
    }

    /// Warnings about drives without a fit: each where it is a few, otherwise how many for which
    /// reason.
    pub fn left_out_warnings(&self) -> Vec<String> {
        if self.left_out.len() > MOST_TOLD {
            return vec![self.left_out_by_kind()];
        }
        self.left_out.iter().map(|l| format!("{} is left out: {}", l.place, l.reason)).collect()
    }

    /// How many drives and events have no fit for which reason, the most frequent one first.
    fn left_out_by_kind(&self) -> String {
        let mut kinds: Vec<(&str, u64)> = Vec::new();
        for LeftOut { kind, .. } in &self.left_out {
            match kinds.iter_mut().find(|(known, _)| known == kind) {
                Some((_, count)) => *count += 1,
                None => kinds.push((kind, 1)),
            }
        }
        kinds.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        let reasons = kinds.iter().map(|(kind, count)| format!("{} for {kind}", grouped(*count)));
        let reasons = reasons.collect::<Vec<_>>().join(", ");
        let all = grouped(self.left_out.len() as u64);
        format!("{all} events or drives are left out: {reasons}; `left_out` (--json) has each")
    }

    /// The first drive or event that was left out, where nothing has a fit, with the account of the
    /// others where they are many.
    pub fn failed(&self) -> Option<LeftOut> {
        let mut first = self.left_out.first().filter(|_| self.fits.is_empty())?.clone();
        if self.left_out.len() > MOST_TOLD {
            first.reason = format!("{}; {}", first.reason, self.left_out_by_kind());
        }
        Some(first)
    }

    /// The population behind the fits.
    pub fn population(&self) -> Option<Population> {
        Population::of(&self.fits)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_few_are_named_and_many_are_counted_by_reason() {
        let left_out = |k: usize| LeftOut {
            place: format!("event `{k}`"),
            reason: format!("{k} rows"),
            kind: if k == 2 { "a vehicle that stands" } else { "less than 30 rows" },
        };
        let identification = |count| Identification {
            left_out: (1..=count).map(left_out).collect(),
            ..Identification::default()
        };
        let few = identification(MOST_TOLD);
        assert_eq!(few.left_out_warnings().len(), MOST_TOLD);
        assert_eq!(few.left_out_warnings()[1], "event `2` is left out: 2 rows");
        assert_eq!(few.failed().unwrap().reason, "1 rows");
        let many = identification(1200);
        let account = "1,200 events or drives are left out: 1,199 for less than 30 rows, 1 for a \
                       vehicle that stands; `left_out` (--json) has each";
        assert_eq!(many.left_out_warnings(), [account]);
        assert_eq!(many.failed().unwrap().reason, format!("1 rows; {account}"));
        assert!(
            identification(0).left_out_warnings().is_empty()
                && identification(0).failed().is_none()
        );
    }
}
