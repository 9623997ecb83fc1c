//! A state of the world: one value for each price, shared by all trips.

use super::Yearly;
use super::costing::{Costing, Input};
use crate::distribution::Quantity;
use crate::random::{Draws, Stream};

/// The value of one input.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// The same in all years.
    Constant(f64),
    /// One of each year; the last goes on.
    ByYear(Vec<f64>),
}

impl Value {
    /// In a year of the life, from 0.
    pub fn in_year(&self, year: usize) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::ByYear(values) => {
                values[year.min(values.len().checked_sub(1).expect("checked: one year at least"))]
            }
        }
    }

    /// In the first year: the only one of what does not change.
    pub fn first(&self) -> f64 {
        self.in_year(0)
    }
}

/// The values of all inputs, in their order.
#[derive(Clone, Debug, PartialEq)]
pub struct State(pub Vec<Value>);

impl Input {
    /// Whether states of the world differ in it.
    pub fn is_uncertain(&self) -> bool {
        !matches!(&self.price, Yearly::ByYear(_) | Yearly::Constant(Quantity::Number(_)))
    }

    fn value(&self, value_of: impl FnOnce(&Quantity) -> f64) -> Value {
        match &self.price {
            Yearly::Constant(quantity) => Value::Constant(value_of(quantity)),
            Yearly::ByYear(prices) => Value::ByYear(prices.clone()),
        }
    }
}

impl State {
    /// Where each law has its centre.
    pub fn central(costing: &Costing) -> Self {
        Self(costing.inputs.iter().map(|input| input.value(Quantity::centre)).collect())
    }

    /// State `number` of a seed, some inputs taken from the second sample. The value of an input is
    /// a function of the seed, the number and its key alone, so that two studies have the same
    /// price where they have the same law.
    pub fn drawn(
        costing: &Costing,
        seed: u64,
        number: u64,
        from_second: impl Fn(&Input) -> bool,
    ) -> Self {
        let drawn = |input: &Input| {
            if !input.is_uncertain() {
                return input.value(Quantity::centre);
            }
            let open = if from_second(input) { Draws::of_second_sample } else { Draws::new };
            input.value(|law| law.sample(open(seed, number, Stream::Price).at(input.place)))
        };
        Self(costing.inputs.iter().map(drawn).collect())
    }

    /// The state in which one input, where there is such a one, has another value in all years.
    #[must_use]
    pub fn with(&self, input: Option<usize>, value: f64) -> Self {
        let mut other = self.clone();
        if let Some(input) = input {
            other.0[input] = Value::Constant(value);
        }
        other
    }

    /// Value of an input that does not change from year to year.
    pub fn constant(&self, input: usize) -> f64 {
        self.0[input].first()
    }
}
