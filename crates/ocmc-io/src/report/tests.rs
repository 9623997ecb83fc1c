use super::*;
use crate::given_drive::{Follow, Followed, GivenDrive};
use crate::run_directory::RunSummary;
use crate::run_directory::{Manifest, RunStatus};
use crate::study;
use ocmc_core::record::Outcome;
use ocmc_fleet::run::{RunPlan, records as drive};
use ocmc_fleet::summary::SummaryBuilder;
use std::convert::Infallible;
use std::ops::ControlFlow;

fn run(name: &str) -> StoredRun {
    let loaded = study::load("field-truck", &["mission.length_m=2000"]).expect("built in");
    let plan = RunPlan::new(1, 0, 200, Some(2), None);
    let driven: ControlFlow<Infallible, _> =
        drive(&loaded.study, &plan, |_| ControlFlow::Continue(()));
    let ControlFlow::Continue(mut records) = driven;
    records[7].outcome = Outcome::Stalled;
    let mut fleet = SummaryBuilder::default();
    fleet.add(&records);
    let mut manifest = Manifest::new(&loaded, &plan, &GivenDrive::nothing());
    manifest.study = name.to_owned();
    manifest.status = RunStatus::Complete;
    manifest.completed = 200;
    let summary = RunSummary::new(&manifest, fleet.finish(), 1.0, 2);
    StoredRun { manifest, records, summary }
}

#[test]
fn the_report_has_every_part_and_fetches_nothing() {
    let page = html(&run("my fleet").into());
    for part in [
        "my fleet",
        "mean of the fleet",
        "P95",
        "Where the energy went",
        "What goes with the spread",
        "payload",
        "A trip in the middle",
        "the engine brake, or retarder (blue)",
        "Lowest and highest",
        "ocmc trace --study field-truck --set mission.length_m=2000.0 --seed 1 --cycle-id",
        "19 of 20 trips use less than",
        "ocmc --study field-truck --set mission.length_m=2000.0 --seed 1 --cycles 200 --out again",
        "1 of 200 cycles was not completed",
        "stalled",
        "Provenance",
        "Beside published figures",
        "VECTO 3, generic tractor of 2016",
        "length_m = 2000.0",
        "prefers-color-scheme: dark",
        "@media print",
    ] {
        assert!(page.contains(part), "{part}");
    }
    for foreign in ["http://", "https://", "<script", "@import", "url("] {
        // sources that a study names are text, not links
        let place = page.match_indices(foreign).find(|(at, _)| page[..*at].ends_with(['"', '\'']));
        assert!(place.is_none(), "{foreign}");
    }
    assert!(!page.contains("<script") && !page.contains("NaN") && !page.contains("inf"));
    for tag in ["div", "table", "figure", "svg", "details", "tr", "td", "th", "code"] {
        let (open, close) = (
            page.matches(&format!("<{tag}>")).count() + page.matches(&format!("<{tag} ")).count(),
            page.matches(&format!("</{tag}>")).count(),
        );
        assert_eq!(open, close, "{tag}");
    }
}

#[test]
fn the_losses_add_up_to_the_fuel() {
    let page = html(&run("x").into());
    assert!(page.contains("add up to 100.0000 %"), "the balance closes");
}

#[test]
fn what_a_study_calls_itself_is_text() {
    let page = html(&run("<script>alert('x')</script> & \"co\"").into());
    assert!(!page.contains("<script"));
    assert!(page.contains("&lt;script&gt;alert(&#39;x&#39;)&lt;/script&gt; &amp; &quot;co&quot;"));
}

#[test]
fn a_run_without_a_completed_cycle_has_a_report() {
    let mut run = run("x");
    let mut fleet = SummaryBuilder::default();
    run.records.truncate(3);
    for record in &mut run.records {
        record.outcome = Outcome::TimedOut;
    }
    fleet.add(&run.records);
    run.summary.summary = fleet.finish();
    assert!(html(&run.clone().into()).contains("timed_out"));
}

#[test]
fn no_command_is_shown_that_would_not_give_the_cycle() {
    let mut run = run("x");
    let file = "cycle.csv".to_owned();
    run.manifest.followed = Some(Followed { how: Follow::Exact, file, cycle: None });
    let page = html(&run.clone().into());
    assert!(!page.contains("ocmc trace") && !page.contains("study.toml"), "{page}");
}

#[test]
fn a_study_with_routes_is_saved_where_they_are_named_from() {
    let mut run = run("x");
    assert!(!html(&run.clone().into()).contains("in the folder in which the run was started"));
    let route = "\n[[mission.routes]]\nfile = \"a.vdri\"\nweight = 1.0\n";
    run.manifest.resolved_study.push_str(route);
    assert!(html(&run.clone().into()).contains("in the folder in which the run was started"));
}

#[test]
fn a_share_that_rounds_to_nothing_is_not_shown() {
    let explaining = |share: f64| Explaining {
        name: format!("{share}"),
        factor: 1.0,
        association: Association { share, by_chance: 0.0, bands: Vec::new() },
    };
    let names = |quantities: Vec<Explaining>| -> Vec<String> {
        strongest(quantities).into_iter().map(|explaining| explaining.name).collect()
    };
    assert_eq!(
        names(vec![explaining(0.2), explaining(-0.001), explaining(0.004), explaining(0.6)]),
        ["0.6", "0.2"]
    );
}

#[test]
fn what_only_follows_from_the_payload_explains_nothing() {
    let page = html(&run("x").into());
    let from = page.find("What goes with the spread").expect("a panel");
    let panel = &page[from..from + page[from..].find("<h2>Road").expect("the next part")];
    assert!(panel.contains("payload"), "{panel}");
    assert!(!panel.contains("rolling"), "{panel}");
}

/// A number of a rule of the style for narrow screens.
fn on_a_phone(rule: &str) -> f64 {
    let narrow = STYLE.split_once("@media (max-width").expect("narrow screens").1;
    let narrow = narrow.split_once("@media print").expect("printing follows").0;
    let value = narrow.split_once(rule).expect("the rule").1.trim_start();
    let end = value.find(|c: char| !c.is_ascii_digit() && c != '.').expect("a unit");
    value[..end].parse().expect("a number")
}

#[test]
fn labels_of_broad_pictures_can_be_read_on_a_phone() {
    let letters = on_a_phone(".broad text { font-size:");
    // a page of 360 px with margins of 16 px, a picture of 720 units
    assert!(letters * (360.0 - 32.0) / 720.0 >= 10.0, "{letters}");
    // the lines below the histogram do not touch, and bars are as far apart as their names are high
    let page = html(&run("x").into());
    let lines = |picture: &str| -> Vec<f64> {
        let picture = page.split_once(picture).expect("a picture").1;
        let picture = picture.split_once("</svg>").expect("its end").0;
        let labels = picture.split("<text").skip(1);
        let y = labels.map(|label| label.split_once(" y=\"").expect("a place").1);
        let y = y.map(|y| y.split_once('"').expect("a number").0.parse().expect("a number"));
        let mut y: Vec<f64> = y.collect();
        y.sort_by(f64::total_cmp);
        y.dedup();
        y
    };
    for picture in ["Histogram of", "Energy by kind of loss"] {
        let lines = lines(picture);
        assert!(lines.len() > 2, "{picture}: {lines:?}");
        assert!(lines.windows(2).all(|y| y[1] - y[0] >= 1.2 * letters), "{picture}: {lines:?}");
    }
}

#[test]
fn what_is_wider_than_the_page_is_moved_within_its_box_also_by_keys() {
    assert!(
        STYLE.contains(".wide { overflow-x: auto;")
            && STYLE.contains("pre { padding: .8rem; overflow-x: auto; }")
    );
    assert!(STYLE.contains("figure:has(> .panorama) { overflow-x: auto; }"));
    let page = html(&run("x").into());
    let outside = page.match_indices("<table").filter(|(at, _)| {
        let before = &page[..*at];
        !before.ends_with("tabindex=\"0\">")
            && !before.ends_with("--columns: 7\">")
            && !before.ends_with("--columns: 2\">")
    });
    assert_eq!(outside.count(), 0);
}
