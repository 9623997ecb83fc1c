//! The engine of unit tests here and in `ocmc-vecto`.

use ocmc_core::distribution::Quantity;
use ocmc_core::energy::Carrier;
use ocmc_core::powertrain::component::engine::{EngineModel, FuelModel};

/// The engine of `tractor-40t-vecto`: VECTO's 325 kW.
pub(crate) fn engine_b() -> EngineModel {
    let radps = |rpm: &[f64]| rpm.iter().map(|n| n * std::f64::consts::PI / 30.0).collect();
    let kgps = |row: &[f64]| row.iter().map(|g| g / 3.6e6).collect();
    EngineModel {
        inertia_kgm2: 5.15,
        idle_speed_radps: 62.832,
        torque_lag_s: 0.5,
        full_load_speed_radps: radps(&[600., 800., 1000., 1400., 1600., 1800., 2000., 2100.]),
        full_load_torque_nm: vec![1188., 1661., 2134., 2134., 1928., 1722., 1253., 1019.],
        map_speed_radps: radps(&[
            600., 751., 902., 1053., 1204., 1367., 1490., 1612., 1735., 1857.,
        ]),
        drag_torque_nm: vec![-138., -142., -148., -155., -165., -183., -201., -219., -235., -254.],
        map_torque_nm: vec![0., 427., 854., 1280., 1707., 2134.],
        map_fuel_kgps: vec![
            kgps(&[1355., 5830., 10440.]),
            kgps(&[1649., 7149., 12957., 19231.]),
            kgps(&[2211., 8515., 15411., 22743., 30535.]),
            kgps(&[2768., 9836., 17855., 26161., 35019., 45438.]),
            kgps(&[3087., 11040., 20336., 29782., 39786., 51129.]),
            kgps(&[3845., 12797., 22854., 33740., 45836., 58296.]),
            kgps(&[4373., 14091., 25093., 36865., 50250.]),
            kgps(&[4904., 15404., 27492., 40115., 54666.]),
            kgps(&[5587., 16949., 30160., 43924., 59469.]),
            kgps(&[6674., 18688., 33003., 48118.]),
        ],
        power_take_off_speed_radps: None,
        fuel_factor: Quantity::Number(1.0),
        fuel: FuelModel {
            carrier: Carrier::LiquidFuel,
            density_kgpm3: 836.0,
            heating_value_jpkg: 42.7e6,
            co2_kg_per_kg: 3.13,
        },
    }
}
