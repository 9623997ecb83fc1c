//! Studies of earlier versions of the program: keys that came since, each with the value that
//! restores what the program did before there was such a key.
//!
//! The study of a run directory is completed with these values when it is read, and whoever reads
//! it sees which; a user's own study is not changed: its message names the value.

use super::error::Fault;
use super::node::{Content, Node, path_of};
use super::source::{Source, SourceKind};
use ocmc_core::study::tree::Step;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A key that came after version 0.1.0 and that every resolved study has.
#[derive(Clone, Copy, Debug)]
pub(super) struct NewKey {
    /// Its path; `*` stands for every name in its table.
    pub(super) path: &'static str,
    /// The value that restores earlier behaviour, as TOML.
    pub(super) value: &'static str,
}

/// The keys that came since version 0.1.0.
pub(super) const NEW_KEYS: &[NewKey] = &[
    NewKey { path: "vehicle.electric.charging.connection_s", value: "0.0" },
    NewKey { path: "driver.speed_change.peak_acceleration_ratio", value: "100.0" },
    NewKey { path: "driver.pedals.feed_forward", value: "false" },
    NewKey { path: "driver.pedals.ramp_gain_minimum", value: "0.0" },
    NewKey { path: "driver.pedals.ramp_lead_s", value: "0.0" },
    NewKey { path: "driver.pedals.ramp_slack_share", value: "0.0" },
    NewKey { path: "driver.pedals.brake_tolerance_mps", value: "0.0" },
    NewKey {
        path: "driver.look_ahead",
        value: "{ coasting = false, eco_roll = false, predictive_cruise = false, \
                engine_stop = false, minimum_speed_mps = 13.9, preview_s = 36.0, \
                decision_factor = 2.5, underspeed_mps = 1.4, engine_stop_delay_s = 2.0, \
                engine_stop_power_w = 1200.0 }",
    },
    NewKey { path: "simulation.columns_by", value: "[]" },
    NewKey { path: "vehicle.gearbox.shift.opposite_interval_s", value: "0.0" },
    NewKey { path: "vehicle.gearbox.shift.before_ramp_s", value: "0.0" },
    NewKey { path: "vehicle.gearbox.shift.minimum_acceleration_mps2", value: "-10.0" },
];

/// Puts these keys where a study lacks them. Returns each that was put, as `path = value`.
pub(super) fn complete(tree: &mut Node, keys: &[NewKey]) -> Result<Vec<String>, Box<Fault>> {
    let mut put = Vec::new();
    for key in keys {
        let steps: Vec<&str> = key.path.split('.').collect();
        complete_at(tree, &steps, key, &mut Vec::new(), &mut put)?;
    }
    Ok(put)
}

/// Puts a key at the end of the steps. A table that is not there is another kind of study: nothing
/// is put into it.
fn complete_at(
    node: &mut Node,
    steps: &[&str],
    key: &NewKey,
    above: &mut Vec<Step>,
    put: &mut Vec<String>,
) -> Result<(), Box<Fault>> {
    let (Some((step, below)), Some(entries)) = (steps.split_first(), node.entries_mut()) else {
        return Ok(());
    };
    if below.is_empty() {
        if !entries.contains_key(*step) {
            entries.insert((*step).to_owned(), value_of(key)?);
            let path = path_of(&[&above[..], &[Step::Key((*step).to_owned())]].concat());
            put.push(format!("{path} = {}", key.value));
        }
        return Ok(());
    }
    let named = entries.iter_mut().filter(|(name, _)| *step == "*" || name == step);
    for (name, node) in named {
        above.push(Step::Key(name.clone()));
        complete_at(node, below, key, above, put)?;
        above.pop();
    }
    Ok(())
}

fn value_of(key: &NewKey) -> Result<Node, Box<Fault>> {
    let (name, text) = (key.path.to_owned(), key.value.to_owned());
    let source = Arc::new(Source { kind: SourceKind::BuiltIn, name, text });
    Node::parse_value(&source, 0)
}

/// The value that restores earlier behaviour where the key of these steps is lacking.
pub(super) fn earlier_value(steps: &[Step], keys: &[NewKey]) -> Option<&'static str> {
    let is = |key: &&NewKey| {
        let names: Vec<&str> = key.path.split('.').collect();
        names.len() == steps.len()
            && names.iter().zip(steps).all(|(name, step)| match step {
                Step::Key(key) => name == key || *name == "*",
                Step::Index(_) => false,
            })
    };
    keys.iter().find(is).map(|key| key.value)
}

/// The keys that the resolved study of an earlier version lacks, as `path = value`.
pub(super) fn lacking(text: &str) -> Vec<String> {
    let source = Source { kind: SourceKind::File, name: String::new(), text: text.to_owned() };
    let mut tree = Node::parse(&Arc::new(source))
        .unwrap_or_else(|_| Node::new(Content::Table(BTreeMap::new()), None));
    complete(&mut tree, NEW_KEYS).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::{Files, check, load, resolved_toml};

    /// As if these keys had come with the next version.
    const KEYS: &[NewKey] = &[
        NewKey { path: "vehicle.wheel_inertia_kgm2", value: "160.0" },
        NewKey { path: "road.types.*.wind_exposure", value: "0.5" },
        NewKey { path: "vehicle.nowhere.key", value: "1" },
    ];

    fn earlier() -> Node {
        let model = load("field-truck", &[] as &[&str]).expect("built in").model;
        let text = resolved_toml(&model);
        let lines = text.lines().filter(|line| {
            !line.starts_with("wheel_inertia_kgm2") && !line.starts_with("wind_exposure")
        });
        let text = lines.collect::<Vec<_>>().join("\n");
        let source = Source { kind: SourceKind::File, name: "old".to_owned(), text };
        Node::parse(&Arc::new(source)).expect("TOML")
    }

    #[test]
    fn an_earlier_study_is_completed_and_what_was_put_is_named() {
        let mut tree = earlier();
        assert!(check(&tree, &Files::here()).is_err());
        let put = complete(&mut tree, KEYS).expect("values");
        assert_eq!(put.len(), 4, "{put:?}");
        assert_eq!(put[0], "vehicle.wheel_inertia_kgm2 = 160.0");
        assert!(put.contains(&"road.types.rural.wind_exposure = 0.5".to_owned()), "{put:?}");
        let (model, _) = check(&tree, &Files::here()).expect("complete");
        assert_eq!(model.vehicle.wheel_inertia_kgm2, 160.0);
        assert_eq!(complete(&mut tree, KEYS).expect("values"), Vec::<String>::new());
    }

    #[test]
    fn the_value_of_a_lacking_key_is_found_by_its_path() {
        let steps = |path: &str| -> Vec<Step> {
            path.split('.').map(|key| Step::Key(key.to_owned())).collect()
        };
        assert_eq!(earlier_value(&steps("road.types.a.wind_exposure"), KEYS), Some("0.5"));
        assert_eq!(earlier_value(&steps("road.types.wind_exposure"), KEYS), None);
    }

    #[test]
    fn a_study_of_this_version_lacks_nothing() {
        let model = load("field-truck", &[] as &[&str]).expect("built in").model;
        assert_eq!(lacking(&resolved_toml(&model)), Vec::<String>::new());
        assert_eq!(lacking("no = = TOML"), Vec::<String>::new());
    }
}
