//! Fuel maps of engines: points that no engine has.

use super::Finding;
use crate::number_text::rounded;
use std::collections::BTreeMap;

/// Name of the check.
const NAME: &str = "fuel-map-point";
/// Share of the largest torque from which on an engine burns fuel.
const LOADED: f64 = 0.02;
/// Relative difference of two values at one point at which they are the same, as far as digits go.
const SAME: f64 = 1e-3;
/// One g/h in kg/s, and one 1/min in rad/s.
const GPH_KGPS: f64 = 1.0 / 3.6e6;
const RPM_RADPS: f64 = std::f64::consts::PI / 30.0;

/// Looks at the points of a map: speeds in rad/s, torques in Nm, fuel in kg/s.
pub fn judge(speed_radps: &[f64], torque_nm: &[f64], fuel_kgps: &[f64]) -> Option<Finding> {
    let most_nm = torque_nm.iter().fold(0.0, |most: f64, torque| most.max(*torque));
    let mut known: BTreeMap<[u64; 2], f64> = BTreeMap::new();
    let refuse = |k: usize, figures: [f64; 2], what: String| {
        let text = format!(
            "the map's point at {} rpm and {} Nm {what}",
            rounded(speed_radps[k] / RPM_RADPS),
            rounded(torque_nm[k])
        );
        Some(Finding::refused(NAME, figures, text, "correct the point, or leave it out"))
    };
    for (k, fuel) in fuel_kgps.iter().enumerate() {
        let gph = fuel / GPH_KGPS;
        if *fuel < 0.0 {
            return refuse(k, [gph, 0.0], format!("has {} g/h, below 0", rounded(gph)));
        }
        if *fuel == 0.0 && torque_nm[k] > LOADED * most_nm {
            return refuse(k, [gph, 0.0], "has no fuel under load".to_owned());
        }
        // adding zero makes one of both zeros
        let point = [speed_radps[k] + 0.0, torque_nm[k] + 0.0].map(f64::to_bits);
        if let Some(other) = known.insert(point, *fuel)
            && (other - fuel).abs() > SAME * other.abs().max(fuel.abs())
        {
            let other = other / GPH_KGPS;
            let text = format!("is there twice, with {} and {} g/h", rounded(other), rounded(gph));
            return refuse(k, [gph, other], text);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_that_no_engine_has_are_named() {
        let speeds = [100.0, 100.0, 150.0, 150.0];
        let torques = [0.0, 1000.0, 0.0, 1000.0];
        let fuel = [1e-4, 5e-3, 2e-4, 7e-3];
        let judged = |change: &dyn Fn(&mut Vec<f64>)| {
            let mut fuel = fuel.to_vec();
            change(&mut fuel);
            judge(&speeds, &torques, &fuel)
        };
        assert!(judged(&|_| {}).is_none());
        assert!(judged(&|fuel| fuel[0] = 0.0).is_none(), "cut off while it is motored");
        let text = |change: &dyn Fn(&mut Vec<f64>)| judged(change).unwrap().to_string();
        assert!(
            text(&|fuel| fuel[1] = -5e-3).contains("954.9 rpm and 1,000 Nm has -18,000 g/h"),
            "{}",
            text(&|fuel| fuel[1] = -5e-3)
        );
        assert!(text(&|fuel| fuel[3] = 0.0).contains("no fuel under load"));
        let twice = judge(&[100.0; 2], &[500.0; 2], &[2e-3, 3e-3]).unwrap();
        assert!(twice.text.contains("twice, with 7,200 and 10,800 g/h"), "{twice}");
        assert!(judge(&[100.0; 2], &[500.0; 2], &[2e-3, 2e-3]).is_none());
    }
}
