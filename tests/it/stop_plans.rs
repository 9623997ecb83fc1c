//! Stop plans: a drawn mission that is written as a plan drives on its own road as it was drawn; a
//! plan is found on a track; a study that names a plan repeats its run.

use crate::common::run;
use ocmc_core::kernel::drive::scheduler::drive_scenario;
use ocmc_core::operating_cycle::drawn_part::Draw;
use ocmc_core::operating_cycle::road::point_event::EventKind;
use ocmc_core::operating_cycle::route::Keep;
use ocmc_core::record::{COLUMNS, Cell};
use ocmc_io::given_cycle::{RouteOptions, read_route};
use ocmc_io::operating_cycle::RealisedCycle;
use ocmc_io::study as studies;
use std::fmt::Write as _;

const NONE: &[&str] = &[];

#[test]
fn a_drawn_mission_as_a_plan_drives_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let sets = ["mission.stops.cargo={delivered_share=0.8}"];
    let loaded = studies::load("urban-delivery", &sets).unwrap();
    // nothing of the mission is left to the study but the day
    let bare = studies::load("urban-delivery", &["mission.payload_kg=1.0"]).unwrap();
    let mut same = 0;
    for cycle_id in 0..12 {
        let scenario = loaded.study.sample(1, cycle_id);
        let cycle = &scenario.cycle;
        let mut plan = "place,position_m,dwell_s,payload_kg,departure\n".to_owned();
        let clock = |second: f64| {
            let (hour, minute) = ((second / 3600.0).floor(), (second / 60.0).floor() % 60.0);
            format!("{hour:02}:{minute:02}:{:09.6}", second % 60.0)
        };
        let departs = clock(cycle.mission.departure_s);
        writeln!(plan, "depot,0,,{},{departs}", cycle.mission.payload_kg).unwrap();
        for (part, event) in cycle.mission.parts.iter().zip(
            cycle.road.events.iter().filter(|e| matches!(e.kind, EventKind::MissionStop { .. })),
        ) {
            let dwell_s = event.kind.standstill_s().unwrap();
            writeln!(plan, "a,{},{dwell_s},{},", part.start_m, part.payload_kg).unwrap();
        }
        writeln!(plan, "depot,{},,,", cycle.road.length_m).unwrap();
        let (road, table) = (folder.path().join("road.json"), folder.path().join("plan.csv"));
        let written = RealisedCycle::new(&loaded, 1, cycle_id);
        std::fs::write(&road, serde_json::to_string(&written).unwrap()).unwrap();
        std::fs::write(&table, plan).unwrap();
        let options = RouteOptions { stop_plan: Some(&table), ..RouteOptions::default() };
        let keep = [Keep::Weather, Keep::Traffic];
        let given = bare.clone().on_routes(&[road], &keep, options).unwrap();
        let record = drive_scenario(&loaded.study, scenario);
        let again = drive_scenario(&given.study, given.study.sample(1, cycle_id));
        // as in `given_cycles`: last bits of the road may move a shift
        if again.n_gear_shifts != record.n_gear_shifts {
            continue;
        }
        same += 1;
        for column in COLUMNS {
            if column.name == "departure_s_of_year" {
                continue;
            }
            if let (Cell::Number(Some(a)), Cell::Number(Some(b))) =
                (column.get(&record), column.get(&again))
            {
                let error = (a - b).abs() / a.abs().max(1.0);
                assert!(error < 1e-6, "{cycle_id} {}: {a} {b}", column.name);
            }
        }
    }
    assert!(same >= 8, "{same} of 12");
}

#[test]
fn a_plan_of_coordinates_is_found_on_a_track() {
    let folder = tempfile::tempdir().unwrap();
    let [track, table] = ["track.gpx", "plan.csv"].map(|name| folder.path().join(name));
    // 30 km to the north, every 20 m
    let mut points = String::new();
    for k in 0..=1500 {
        let latitude = 52.0 + f64::from(k) * 20.0 / 111_194.93;
        write!(points, "<trkpt lat=\"{latitude:.7}\" lon=\"9.0\"/>").unwrap();
    }
    let gpx = format!("<gpx version=\"1.1\"><trk><trkseg>{points}</trkseg></trk></gpx>");
    std::fs::write(&track, gpx).unwrap();
    let plan = "place,lat,lon,dwell_min,unload_kg\nDepot,52.0,9.0,,\n\
                A,52.0899322,9.0007,20,900\nB,52.1798644,8.9995,15,600\nEnd,52.2697966,9.0,,\n";
    std::fs::write(&table, plan).unwrap();
    let options =
        RouteOptions { draw: &Draw::ALL, stop_plan: Some(&table), ..RouteOptions::default() };
    let (cycle, account) = read_route(&track, options).unwrap();
    let stops: Vec<f64> = cycle.events.iter().map(|event| event.position_m).collect();
    assert!((stops[0] - 10_000.0).abs() < 5.0 && (stops[1] - 20_000.0).abs() < 5.0, "{stops:?}");
    assert_eq!(cycle.parts.iter().map(|p| p.payload_kg).collect::<Vec<_>>(), [600.0, 0.0]);
    let told = account.told().join("\n");
    assert!(told.contains("plan.csv`: a stop plan: 2 stops"), "{told}");
    let far = plan.replace("9.0007", "9.7");
    std::fs::write(&table, far).unwrap();
    let fault = read_route(&track, options).unwrap_err().to_string();
    assert!(fault.contains("line 3, A: 47.9") && fault.contains("beside the track"), "{fault}");
}

#[test]
fn a_study_that_names_a_plan_repeats_its_run() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("road.csv", "position_m,speed_limit_kmh\n0,80\n40000,80\n");
    let plan = "place,km,dwell_min,unload_t,departure\nA,0,,,07:00\nB,20,30,4,\nC,40,,,\n";
    write("plan.csv", plan);
    write(
        "s.toml",
        "[study]\nname = \"s\"\ndescription = \"d\"\nbase = \"field-truck\"\n[mission]\n\
         routes = [{ file = \"road.csv\", stop_plan = \"plan.csv\", weight = 1.0 }]\n",
    );
    let study = folder.path().join("s.toml");
    let loaded = studies::load(study.to_str().unwrap(), NONE).unwrap();
    let records = run(&loaded.study, 8);
    assert!(records.iter().all(|record| record.payload_kg == 4000.0 && record.n_stops >= 1));
    let resolved = studies::resolved_toml(&loaded.model);
    let again = studies::load_text("resolved.toml", &resolved, NONE).unwrap();
    assert_eq!(run(&again.study, 8), records);
    write("plan.csv", &plan.replace("30", "31"));
    let fault = studies::load_text("resolved.toml", &resolved, NONE).unwrap_err().to_string();
    assert!(fault.contains("plan.csv") && fault.contains("SHA-256"), "{fault}");
}
