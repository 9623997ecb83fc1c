//! The energy ledger: what is integrated over a cycle. Each term is integrated on its own, so no
//! term of the energy balance is a remainder.
//!
//! [`TERMS`] declares each term once: its columns in trace and record, its place in the balance,
//! and the cycles that have it. Sums, trace, records and the balance follow from the declaration.

use crate::lanes::{Lanes, WIDTH};
use fearless_simd::prelude::*;
use std::ops::{Index, IndexMut};

/// A term of the ledger; what it is, [`TERMS`] says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub enum Term {
    /// Integrated time, in s.
    Time,
    /// Distance, in m.
    Distance,
    /// Fuel, in kg.
    Fuel,
    /// Work of the engine at the crankshaft or of the motor at its shaft, in J.
    Crankshaft,
    /// Work of the auxiliaries, in J.
    Auxiliary,
    /// Loss of the slipping clutch, in J.
    Clutch,
    /// Loss of gearbox, retarder and axle, in J.
    Transmission,
    /// Kinetic energy of the engine that its jumps in speed lose, signed, in J.
    Shift,
    /// Work against the air, in J.
    Drag,
    /// Work against rolling resistance, in J.
    Rolling,
    /// Work against gravity, in J.
    Grade,
    /// Work of the service brakes, in J.
    ServiceBrake,
    /// Work of the engine brake, in J.
    EngineBrake,
    /// Positive work at the hubs of the driven wheels, in J.
    Wheel,
    /// Energy that the battery's store has lost, charging at stops not counted, in J.
    Battery,
    /// Heat in the battery, in J.
    BatteryLoss,
    /// Losses of motor and inverter, in J.
    MotorLoss,
    /// Energy that braking by the motor brought back to the terminals, in J.
    Regenerated,
    /// Energy that charging at stops put into the store, in J.
    Charged,
    /// Heat in the battery while it was charged, in J.
    ChargingLoss,
    /// Energy that the store gave beyond the points of a map, or beyond what the battery can give,
    /// in J.
    OutsideMap,
    /// Energy of the fuel, in J, where a speed is followed; elsewhere it follows from the mass.
    FuelEnergy,
    /// Time at the limit of the powertrain, in s.
    Limited,
    /// Work at the wheels that the powertrain could not give, in J.
    Missing,
    /// Distance driven with neither pedal pressed, in m.
    Coasting,
    /// Energy of the hydrogen that a fuel cell takes, in J.
    CellInput,
    /// Loss of the fuel cell, what its pumps take included, in J.
    CellLoss,
}

/// The place of a term in the energy balance: source + given = losses + change of kinetic energy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A source of the powertrains that name it as theirs.
    Source,
    /// Energy that is given beside the source.
    Given,
    /// A loss, or work against gravity.
    Loss,
    /// No term of the balance.
    Outside,
}

/// How a cycle is driven.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// By a driver, in closed loop.
    Driven,
    /// Its speed is followed exactly.
    Followed,
}

/// The cycles that have a term.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// All.
    All,
    /// Terms of the powertrains that name it.
    Powertrain,
    /// Terms of one mode.
    Only(Mode),
}

/// Where a term stands in the record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Recorded {
    /// In a field of the record.
    Field,
    /// In columns that the powertrain fills: those of a carrier.
    ByPowertrain,
    /// In a column of its own, behind the fields. New terms are recorded so.
    Column {
        /// Name, with its unit as a suffix.
        name: &'static str,
        /// Meaning of the column, with its unit.
        meaning: &'static str,
        /// Word for a loss, in a list of them.
        label: &'static str,
    },
}

/// The declaration of a term.
#[derive(Clone, Copy, Debug)]
pub struct Declaration {
    /// The term.
    pub term: Term,
    /// Column in the trace: what one row adds.
    pub trace: &'static str,
    /// Where the record has it.
    pub recorded: Recorded,
    /// Place in the energy balance.
    pub place: Place,
    /// The cycles that have it.
    pub extent: Extent,
}

const fn field(term: Term, trace: &'static str, place: Place, extent: Extent) -> Declaration {
    Declaration { term, trace, recorded: Recorded::Field, place, extent }
}

const fn by_powertrain(declared: Declaration) -> Declaration {
    Declaration { recorded: Recorded::ByPowertrain, ..declared }
}

/// The terms, in order. The unit is the suffix of the column.
pub const TERMS: &[Declaration] = &[
    field(Term::Time, "simulated_added_s", Place::Outside, Extent::All),
    field(Term::Distance, "distance_added_m", Place::Outside, Extent::All),
    by_powertrain(field(Term::Fuel, "fuel_added_kg", Place::Outside, Extent::Powertrain)),
    field(Term::Crankshaft, "crankshaft_work_added_j", Place::Source, Extent::Powertrain),
    field(Term::Auxiliary, "auxiliary_energy_added_j", Place::Loss, Extent::All),
    field(Term::Clutch, "clutch_loss_added_j", Place::Loss, Extent::Powertrain),
    field(Term::Transmission, "transmission_loss_added_j", Place::Loss, Extent::All),
    field(Term::Shift, "shift_loss_added_j", Place::Loss, Extent::All),
    field(Term::Drag, "drag_energy_added_j", Place::Loss, Extent::All),
    field(Term::Rolling, "rolling_energy_added_j", Place::Loss, Extent::All),
    field(Term::Grade, "potential_added_j", Place::Loss, Extent::All),
    field(Term::ServiceBrake, "service_brake_energy_added_j", Place::Loss, Extent::All),
    field(Term::EngineBrake, "engine_brake_energy_added_j", Place::Loss, Extent::Powertrain),
    field(Term::Wheel, "wheel_energy_added_j", Place::Outside, Extent::All),
    by_powertrain(field(
        Term::Battery,
        "battery_energy_added_j",
        Place::Source,
        Extent::Powertrain,
    )),
    field(Term::BatteryLoss, "battery_loss_added_j", Place::Loss, Extent::Powertrain),
    field(Term::MotorLoss, "motor_loss_added_j", Place::Loss, Extent::Powertrain),
    field(Term::Regenerated, "regenerated_energy_added_j", Place::Outside, Extent::Powertrain),
    field(Term::Charged, "charged_energy_added_j", Place::Outside, Extent::Powertrain),
    field(Term::ChargingLoss, "charging_loss_added_j", Place::Outside, Extent::Powertrain),
    field(Term::OutsideMap, "outside_map_energy_added_j", Place::Outside, Extent::All),
    by_powertrain(field(
        Term::FuelEnergy,
        "fuel_energy_added_j",
        Place::Outside,
        Extent::Only(Mode::Followed),
    )),
    field(Term::Limited, "limited_added_s", Place::Outside, Extent::Only(Mode::Followed)),
    field(Term::Missing, "missing_energy_added_j", Place::Given, Extent::Only(Mode::Followed)),
    Declaration {
        recorded: Recorded::Column {
            name: "coasting_distance_m",
            meaning: "Distance driven with neither pedal pressed, in m; null where a speed is \
                      followed exactly.",
            label: "coasting",
        },
        ..field(
            Term::Coasting,
            "coasting_distance_added_m",
            Place::Outside,
            Extent::Only(Mode::Driven),
        )
    },
    Declaration {
        recorded: Recorded::Column {
            name: "fuel_cell_input_j",
            meaning: "Energy of the hydrogen that the fuel cell took, in J; null without one.",
            label: "fuel cell, input",
        },
        ..field(Term::CellInput, "fuel_cell_input_added_j", Place::Source, Extent::Powertrain)
    },
    Declaration {
        recorded: Recorded::Column {
            name: "fuel_cell_loss_j",
            meaning: "Loss of the fuel cell, what its pumps take included, in J; null without one.",
            label: "fuel cell",
        },
        ..field(Term::CellLoss, "fuel_cell_loss_added_j", Place::Loss, Extent::Powertrain)
    },
];

// the place of a term in a ledger is that of its declaration
const _: () = {
    let mut k = 0;
    while k < TERMS.len() {
        assert!(TERMS[k].term as usize == k, "the order of the terms");
        k += 1;
    }
};

impl Term {
    /// Number of terms.
    pub const COUNT: usize = TERMS.len();

    /// Declaration of the term.
    pub fn declaration(self) -> &'static Declaration {
        &TERMS[self as usize]
    }

    /// Whether the cycles of a mode have it; `powertrain`: the terms that their powertrain names.
    pub fn is_in(self, mode: Mode, powertrain: &[Self]) -> bool {
        match self.declaration().extent {
            Extent::All => true,
            Extent::Powertrain => powertrain.contains(&self),
            Extent::Only(only) => only == mode,
        }
    }
}

/// Sums of all terms: of one cycle, or of the cycles in the lanes of a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ledger<T>([T; Term::COUNT]);

impl<T> Index<Term> for Ledger<T> {
    type Output = T;

    #[inline(always)]
    fn index(&self, term: Term) -> &T {
        &self.0[term as usize]
    }
}

impl<T> IndexMut<Term> for Ledger<T> {
    #[inline(always)]
    fn index_mut(&mut self, term: Term) -> &mut T {
        &mut self.0[term as usize]
    }
}

impl<T: Copy> Ledger<T> {
    /// All terms of one value.
    #[inline(always)]
    pub fn of(value: T) -> Self {
        Self([value; Term::COUNT])
    }
}

impl Ledger<f64> {
    /// Nothing yet.
    pub const EMPTY: Self = Self([0.0; Term::COUNT]);

    /// Energy missing in the balance, in J: 0 but for rounding. `sources`: those of the powertrain;
    /// `kinetic_change_j`: kinetic energy at the end less at the start.
    pub fn open_balance_j(&self, sources: &[Term], kinetic_change_j: f64) -> f64 {
        let signed = TERMS.iter().map(|declared| match declared.place {
            Place::Source if sources.contains(&declared.term) => self[declared.term],
            Place::Given => self[declared.term],
            Place::Loss => -self[declared.term],
            Place::Source | Place::Outside => 0.0,
        });
        signed.sum::<f64>() - kinetic_change_j
    }

    /// Adds another ledger.
    pub fn add(&mut self, other: &Self) {
        for (sum, amount) in self.0.iter_mut().zip(other.0) {
            *sum += amount;
        }
    }
}

impl<S: Simd> Ledger<Lanes<S>> {
    /// Ledger of one lane.
    pub fn lane(&self, lane: usize) -> Ledger<f64> {
        debug_assert!(lane < WIDTH);
        Ledger(self.0.map(|sums| sums[lane]))
    }

    /// Empties one lane.
    pub fn clear(&mut self, lane: usize) {
        for sums in &mut self.0 {
            sums[lane] = 0.0;
        }
    }

    /// Adds the ledger of an event to one lane.
    pub fn add_to_lane(&mut self, lane: usize, added: &Ledger<f64>) {
        for (sums, amount) in self.0.iter_mut().zip(added.0) {
            sums[lane] += amount;
        }
    }
}

/// Adds a step to the sums of a block, and keeps what the step added for a trace.
#[derive(Debug)]
pub struct StepLedger<'a, S: Simd> {
    sums: &'a mut Ledger<Lanes<S>>,
    /// Additions of the step.
    pub added: Ledger<Lanes<S>>,
}

impl<'a, S: Simd> StepLedger<'a, S> {
    /// Ledger of a step over the sums of a block.
    #[inline(always)]
    pub fn new(simd: S, sums: &'a mut Ledger<Lanes<S>>) -> Self {
        Self { sums, added: Ledger::of(Lanes::splat(simd, 0.0)) }
    }

    /// Adds to a term, once a step.
    #[inline(always)]
    pub fn add(&mut self, term: Term, amount: Lanes<S>) {
        self.sums[term] += amount;
        self.added[term] = amount;
    }
}
