//! Errors of a given operating cycle.

/// Error of a given operating cycle.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GivenCycleError {
    /// No such track.
    #[error("there is no track `{track}`: {purpose}")]
    Missing {
        /// Name of the track.
        track: String,
        /// Why it is needed.
        purpose: &'static str,
    },
    /// A track of another kind.
    #[error("the values of track `{track}` are {found}, allowed are {wanted}")]
    Kind {
        /// Name of the track.
        track: String,
        /// Kind of its values.
        found: &'static str,
        /// Kind that its values have to have.
        wanted: &'static str,
    },
    /// Two tracks of one name.
    #[error(
        "there are two tracks `{track}`, and nothing says which of them is meant; allowed is one"
    )]
    Twice {
        /// Name of the tracks.
        track: String,
    },
    /// Positions and values that are not pairs.
    #[error(
        "track `{track}` has {positions} positions and {values} values, allowed is one value for \
         each position"
    )]
    Lengths {
        /// Name of the track.
        track: String,
        /// Its positions.
        positions: usize,
        /// Its values.
        values: usize,
    },
    /// Positions out of order.
    #[error(
        "in track `{track}`, position {position_m} m (entry {entry}) is not above the one before \
         it; positions have to grow, from 0 m on"
    )]
    Order {
        /// Name of the track.
        track: String,
        /// Entry, from 1.
        entry: usize,
        /// Its position, in m.
        position_m: f64,
    },
    /// A value out of range.
    #[error(
        "in track `{track}`, the value at {position_m} m is {value}, allowed is {minimum} to \
         {maximum}"
    )]
    Range {
        /// Name of the track.
        track: String,
        /// Its position, in m.
        position_m: f64,
        /// The value.
        value: f64,
        /// Smallest allowed value.
        minimum: f64,
        /// Largest allowed value.
        maximum: f64,
    },
    /// A word that means nothing here.
    #[error(
        "in track `{track}`, the value at {position_m} m is `{value}`, allowed is one of: {allowed}"
    )]
    Word {
        /// Name of the track.
        track: String,
        /// Its position, in m.
        position_m: f64,
        /// The word.
        value: String,
        /// The words that are known.
        allowed: String,
    },
    /// Points that scatter so much that no road can be made of them.
    #[error(
        "the {what} scatter by {noise_m:.1} m, allowed is at most {most_m} m: no road can be told \
         from them; give a smoothed route, or `curvature_per_m` and `grade`"
    )]
    Noise {
        /// Positions or altitudes.
        what: &'static str,
        /// Their scatter, in m.
        noise_m: f64,
        /// The most, in m.
        most_m: f64,
    },
    /// A charger of the study beyond the road.
    #[error(
        "`charging.public.positions_m` has a charger at {position_m} m, allowed is below \
         {length_m}, the length of this road"
    )]
    ChargerBeyond {
        /// Position of the charger, in m.
        position_m: f64,
        /// Length of the road, in m.
        length_m: f64,
    },
    /// Something that only happens at stops of the mission, elsewhere.
    #[error(
        "track `{track}` has a value at {position_m} m, allowed are the positions of stops of the \
         mission, track `mission_stop_s`"
    )]
    NoMissionStop {
        /// Name of the track.
        track: &'static str,
        /// Its position, in m.
        position_m: f64,
    },
    /// An object of a map of which it is not known what happens there.
    #[error(
        "there is a `{object}` at {position_m} m, and nothing says what happens there: give its \
         standstill, `stop_s`{or_draw}"
    )]
    OpenPlace {
        /// The object.
        object: &'static str,
        /// Its position, in m.
        position_m: f64,
        /// How it is drawn instead, where it can be.
        or_draw: &'static str,
    },
    /// A road that is too short or too long.
    #[error("the road is {length_m} m long, allowed is 200 m to 5000000 m")]
    Length {
        /// Its length, in m.
        length_m: f64,
    },
}

impl GivenCycleError {
    /// Error of a road without speed limits.
    pub fn no_limits() -> Self {
        Self::Missing {
            track: "speed_limit_mps".to_owned(),
            purpose: "without a limit it is not known how fast to drive; give it, or have it drawn \
                      from the study's road types, `--draw limits`",
        }
    }
}
