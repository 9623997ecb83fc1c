//! The way of a drive: when it was where, and how fast.

use super::standstill::{Standstill, standstills};

/// One drive along its way, one entry a row that is used.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DrivenWay {
    /// Rows of the log.
    pub row: Vec<usize>,
    /// Time, in s.
    pub time_s: Vec<f64>,
    /// Speed, in m/s.
    pub speed_mps: Vec<f64>,
    /// Way from the first row on, in m.
    pub way_m: Vec<f64>,
    /// Position of the first row, in m, where the log has positions that never fall; none where the
    /// way is the integral of the speed.
    pub position_m: Option<f64>,
    /// Whether nothing was logged before a row, so that only the position shows what happened.
    pub unseen: Vec<bool>,
}

impl DrivenWay {
    /// Length, in m.
    pub fn length_m(&self) -> f64 {
        self.way_m.last().copied().unwrap_or(0.0)
    }

    /// Time from the first row to the last one, in s.
    pub fn duration_s(&self) -> f64 {
        let ends = self.time_s.first().zip(self.time_s.last());
        ends.map_or(0.0, |(start_s, end_s)| end_s - start_s)
    }

    /// Where the vehicle stood, on its way.
    pub fn standstills(&self) -> Vec<Standstill> {
        standstills(&self.time_s, &self.speed_mps, &self.way_m, &self.unseen)
    }
}
