//! Measured drives over simulated ones: how a population of trips on the same road predicts the
//! trips that were made.
//!
//! One measured drive is one trip of one driver; the simulated trips of the same road are an
//! ensemble ([`ensemble::Ensemble`]). Where the measured trip is one more draw of the same
//! population, its rank among the simulated ones is uniform, and the bands of ranks cover it as
//! often as they say ([`score`]). Places within one trip depend on one another, so that the test of
//! uniformity takes one value of each trip ([`uniformity`]).

pub mod ensemble;
pub mod passage;
pub mod pooled;
pub mod score;
pub mod simulated;
pub mod uniformity;
