//! The first draws of each primitive of a stream, pinned. A change here changes every result of
//! every study: it needs an entry under *Values* in CHANGELOG.md that says why.
//!
//! The generator is ChaCha8 keyed by the seed, its stream number is 64 × cycle + stream.

use ocmc_core::distribution::{Law, Quantity, standard_gamma};
use ocmc_core::random::{Draws, Stream};

/// Draws of seed 1, cycle 2.
fn first(stream: Stream, draw: impl Fn(&mut Draws) -> f64) -> [f64; 4] {
    let mut draws = Draws::new(1, 2, stream);
    std::array::from_fn(|_| draw(&mut draws))
}

/// Equality of bits, which prints what a changed pin would have to be.
#[track_caller]
fn assert_bits(what: &str, drawn: [f64; 4], pinned: [f64; 4]) {
    assert_eq!(drawn.map(f64::to_bits), pinned.map(f64::to_bits), "{what}: now {drawn:?}");
}

#[test]
fn primitives() {
    assert_bits(
        "uniform",
        first(Stream::RoadType, Draws::uniform),
        [0.059556908663836616, 0.18261248988549145, 0.8566284114747251, 0.296367666667997],
    );
    assert_bits(
        "uniform",
        first(Stream::Vehicle, Draws::uniform),
        [0.6793911296984951, 0.9468331195400217, 0.6140936895846432, 0.3647203230862875],
    );
    assert_bits(
        "normal",
        first(Stream::RoadType, Draws::normal),
        [-1.558504013513442, -0.9054538852142744, 1.0652934033024144, -0.5348763930188587],
    );
    assert_bits(
        "exponential",
        first(Stream::RoadType, Draws::exponential),
        [2.820822975403918, 1.7003889129113277, 0.15475104662416375, 1.2161544783257294],
    );
    let index = |draws: &mut Draws| draws.index(&[1.0, 2.0, 0.0, 5.0]) as f64;
    assert_bits("index", first(Stream::RoadType, index), [0.0, 1.0, 3.0, 1.0]);
    let gamma = |shape: f64| first(Stream::RoadType, move |draws| standard_gamma(draws, shape));
    assert_bits(
        "gamma 2.5",
        gamma(2.5),
        [0.587006018623288, 4.143438651133976, 2.9703029663955514, 1.3565905575195343],
    );
    assert_bits(
        "gamma 0.5",
        gamma(0.5),
        [0.001548250319068225, 0.15630092907802134, 0.10384956652559629, 0.9284678574369862],
    );
}

#[test]
fn laws() {
    let pins: [(&str, [f64; 4]); 8] = [
        (
            r#"{"distribution":"normal","mean":1.0,"sd":0.03,"lower":0.92,"upper":1.05}"#,
            [0.9797920500518135, 0.9856737465200601, 1.0353349809448467, 1.029255256148319],
        ),
        (
            r#"{"distribution":"log_normal","median":0.6,"log_sd":0.25}"#,
            [0.5108066741268953, 0.5373918869765784, 0.8590783100874556, 0.8015737920621543],
        ),
        (
            r#"{"distribution":"uniform","lower":2.0,"upper":8.0}"#,
            [3.5592051727579492, 3.978055518147743, 7.546755362639846, 7.260129372107421],
        ),
        (
            r#"{"distribution":"exponential","mean":6.0}"#,
            [8.085499694703271, 6.657871011609231, 0.4712779906224329, 0.7896230839392904],
        ),
        (
            r#"{"distribution":"gamma","mean":0.8,"shape":0.7}"#,
            [0.15225932079669696, 0.8878557233646565, 0.09332455725742976, 0.05952550008997256],
        ),
        (
            r#"{"distribution":"weibull","mean":4.0,"shape":2.0}"#,
            [5.23953635359473, 4.754524765799914, 1.264963529617945, 1.6373794802730668],
        ),
        (
            r#"{"distribution":"beta","alpha":4.0,"beta":2.0,"scale":24300.0}"#,
            [9094.000459690353, 12949.27908125048, 20051.29861779358, 16397.730273191904],
        ),
        (
            r#"{"distribution":"empirical","values":[1.0,2.0,5.0],"weights":[1.0,2.0,1.0]}"#,
            [2.0, 2.0, 5.0, 5.0],
        ),
    ];
    for (text, pinned) in pins {
        let law: Quantity = serde_json::from_str(text).unwrap();
        assert_bits(text, first(Stream::Payload, |draws| law.sample(draws)), pinned);
    }
    let mixture = Law::Mixture {
        weights: vec![0.2, 0.8],
        components: vec![0.0.into(), Quantity::Law(Law::Exponential { mean: 1.0 })],
    };
    assert_bits(
        "mixture",
        first(Stream::Payload, |draws| mixture.sample(draws)),
        [1.1096451686015385, 0.13160384732321506, 1.6010752010827507, 3.573283941268992],
    );
}
