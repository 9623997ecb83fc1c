//! From logs to the pedal gains of their drivers: each event of each log.

use super::LogFile;
use super::pedals::{LoggedEvent, events};
use ocmc_core::identification::event::EventError;
use ocmc_core::identification::identify::{EventFit, IdentifyOptions, identify_event};
use ocmc_core::identification::population::Population;
use ocmc_core::study::Study;
use serde::Serialize;
use std::sync::atomic::AtomicBool;

/// A drive or an event without a fit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LeftOut {
    /// Where it stands.
    pub place: String,
    /// Why there is no fit.
    pub reason: String,
}

/// Events on their way to fits.
#[derive(Clone, Debug, Default)]
pub struct Identification {
    /// Events without an answer yet, and where they stand.
    waiting: Vec<(String, LoggedEvent)>,
    /// What was found.
    pub fits: Vec<EventFit>,
    /// What was not, in the order in which that was noticed.
    pub left_out: Vec<LeftOut>,
    /// What was not used of the drives.
    pub notes: Vec<String>,
}

impl Identification {
    /// Adds the events of a log.
    pub fn add(&mut self, file: &LogFile) {
        for drive in &file.drives {
            let place = file.place(drive);
            let events = match events(drive, &place) {
                Ok((events, notes)) => {
                    self.notes.extend(notes);
                    events
                }
                Err(fault) => {
                    self.left_out.push(LeftOut { place, reason: fault.to_string() });
                    continue;
                }
            };
            if events.is_empty() {
                let reason = "no event in the rows that can be used: a log needs the label `event`, or slopes of 0.5 % or more";
                self.left_out.push(LeftOut { place, reason: reason.to_owned() });
                continue;
            }
            self.waiting.extend(events.into_iter().map(|event| (place.clone(), event)));
        }
    }

    /// Events without an answer yet.
    pub fn waiting(&self) -> usize {
        self.waiting.len()
    }

    /// Answers them, one after the other; `done` counts them. Ends soon once `stop` is set, with the answers so far.
    pub fn identify(
        &mut self,
        study: &Study,
        options: &IdentifyOptions,
        stop: &AtomicBool,
        mut done: impl FnMut(usize),
    ) {
        for (k, (place, event)) in std::mem::take(&mut self.waiting).into_iter().enumerate() {
            let name = &event.event;
            let fit = identify_event(study, &event.driver, name, &event.log, options, stop);
            match fit {
                Ok(fit) => self.fits.push(fit),
                Err(EventError::Stopped) => return,
                Err(fault) => self.left_out.push(LeftOut {
                    place: format!("event `{name}` of {place}"),
                    reason: fault.to_string(),
                }),
            }
            done(k + 1);
        }
    }

    /// The population behind the fits.
    pub fn population(&self) -> Option<Population> {
        Population::of(&self.fits)
    }
}
