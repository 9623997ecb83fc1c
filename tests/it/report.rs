//! The report of a run, as the command writes it and as a real browser shows it.

use crate::program::{ocmc, run_into};
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

#[test]
fn a_report_lies_beside_the_run_or_where_it_is_asked_for() {
    let parent = tempfile::tempdir().expect("a directory");
    let run = parent.path().join("run");
    run_into(&run, &["--cycles", "100"]);
    ocmc(&["report"]).arg(&run).assert().success();
    let page = fs::read_to_string(run.join("report.html")).expect("written");
    assert!(page.starts_with("<!DOCTYPE html>") && page.trim_end().ends_with("</html>"));
    assert!(page.contains("field-truck") && page.contains("of 100 cycles"));
    // once more, to another place: the same run, the same page
    let other = parent.path().join("other.html");
    ocmc(&["report", "--out"]).arg(&other).arg(&run).assert().success();
    assert_eq!(page, fs::read_to_string(&other).expect("written"));

    let output = ocmc(&["report", "nowhere"]).output().expect("the program starts");
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("nowhere"));
    // a run with its report can still be read, and is not in the way of --resume
    ocmc(&["--resume", "--out"]).arg(&run).assert().success();
}

#[cfg(unix)]
#[test]
fn a_report_is_not_written_through_a_link() {
    let parent = tempfile::tempdir().expect("a directory");
    let (run, other) = (parent.path().join("run"), parent.path().join("other"));
    run_into(&run, &["--cycles", "10"]);
    fs::write(&other, "theirs").expect("space");
    std::os::unix::fs::symlink(&other, run.join("report.html")).expect("space");
    let output = ocmc(&["report"]).arg(&run).output().expect("the program starts");
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("is a symbolic link"));
    assert_eq!(fs::read_to_string(&other).expect("there"), "theirs");
    // where it is asked for the user knows
    ocmc(&["report", "--out"]).arg(run.join("report.html")).arg(&run).assert().success();
}

#[test]
fn the_energy_of_a_saturated_run_adds_up() {
    let parent = tempfile::tempdir().expect("a directory");
    let file = parent.path().join("steep.csv");
    let table = "time_s,speed_mps,slope\n0,0,0\n30,20,0\n60,20,0.1\n90,20,0.1\n";
    fs::write(&file, table).expect("space");
    let page = |run: &Path| {
        ocmc(&["report"]).arg(run).assert().success();
        fs::read_to_string(run.join("report.html")).expect("written")
    };
    let row = "missing at the wheels<";
    for study in ["field-truck", "battery-truck"] {
        let run = parent.path().join(study);
        let follow = ["--follow-speed", "exact", "--cycles", "6", "--quiet", "--study", study];
        ocmc(&["drive"]).arg(&file).args(follow).arg("--out").arg(&run).assert().success();
        let page = page(&run);
        assert!(page.contains("add up to 100.0000 %") && page.contains(row), "{study}");
    }
    // with a driver the truck is slower instead
    let driven = parent.path().join("driven");
    run_into(&driven, &["--cycles", "20"]);
    let page = page(&driven);
    assert!(page.contains("add up to 100.0000 %") && !page.contains(row));
}

#[test]
fn the_command_on_the_page_repeats_the_run() {
    let parent = tempfile::tempdir().expect("a directory");
    let run = parent.path().join("run");
    let sets = ["--set", "simulation.without=[\"curves\"]", "--set", "vehicle.drag_area_m2=5.0"];
    run_into(&run, &[&["--cycles", "20", "--seed", "3", "--format", "csv"], &sets[..]].concat());
    ocmc(&["report"]).arg(&run).assert().success();
    let page = fs::read_to_string(run.join("report.html")).expect("written");
    let command = page.split_once("<pre class=\"command\" tabindex=\"0\">").expect("a command").1;
    let command = command.split_once("</pre>").expect("its end").0;
    let command = command.replace("&#39;", "'").replace("&quot;", "\"").replace("&amp;", "&");
    assert!(command.contains("--set"), "{command}");
    let command = command.replacen("ocmc", env!("CARGO_BIN_EXE_ocmc"), 1);
    let shell = Command::new("sh").args(["-c", &command]).current_dir(&parent).output();
    let shell = shell.expect("a shell");
    assert!(shell.status.success(), "{}", String::from_utf8_lossy(&shell.stderr));
    let bytes = |of: &str| fs::read(parent.path().join(of).join("records.csv")).expect("written");
    assert!(bytes("run") == bytes("again"));
}

#[test]
fn a_comparison_and_an_analysis_are_kept_and_repeat_from_their_pages() {
    let parent = tempfile::tempdir().expect("a directory");
    let parent = parent.path();
    let length = ["--set", "mission.length_m=4000"];
    let compare =
        ["compare", "field-truck", "long-haul", "--cycles", "60", "--quiet", "--out", "compared"];
    ocmc(&[&compare[..], &length].concat()).current_dir(parent).assert().success();
    let text = |file: &str| fs::read_to_string(parent.join(file)).expect(file);
    let page = text("compared/report.html");
    assert!(
        page.contains("Differences, pair by pair")
            && page.contains("long-haul against field-truck")
    );
    assert_eq!(text("compared/pairs.csv").lines().count(), 61);
    let again = ["compare", "a.toml", "b.toml", "--cycles", "60", "--json", "--quiet"];
    let again = ocmc(&again).current_dir(parent.join("compared")).output().expect("it starts");
    let again: serde_json::Value = serde_json::from_slice(&again.stdout).expect("JSON");
    let kept: serde_json::Value =
        serde_json::from_str(&text("compared/comparison.json")).expect("JSON");
    assert_eq!(again["difference"], kept["difference"]);
    for study in ["a", "b"] {
        ocmc(&["verify"]).arg(parent.join("compared").join(study)).assert().success();
    }
    let refused = ocmc(&compare).current_dir(parent).output().expect("it starts");
    assert_eq!(refused.status.code(), Some(1));

    let shares =
        ["sensitivity", "--cycles", "20", "--factor", "road,driver", "--quiet", "--out", "shares"];
    ocmc(&[&shares[..], &length].concat()).current_dir(parent).assert().success();
    assert!(text("shares/report.html").contains("Total effects"));
    assert!(text("shares/design.csv").starts_with("cycle_id,a,b,road,driver\n0,"));
    ocmc(&["study", "check", "shares/study.toml"]).current_dir(parent).assert().success();
}

/// The browser, where there is one.
fn browser(profile: &Path) -> Option<Command> {
    let name = ["chromium", "chromium-browser", "google-chrome"].into_iter().find(|name| {
        let version = Command::new(name).arg("--version").stdout(Stdio::null()).status();
        version.is_ok_and(|status| status.success())
    })?;
    let mut command = Command::new(name);
    command.args(["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"]);
    command.args([
        "--disable-background-networking",
        "--disable-component-update",
        "--no-first-run",
    ]);
    command.args(["--disable-sync", "--disable-default-apps", "--disable-extensions"]);
    command.arg(format!("--user-data-dir={}", profile.display()));
    Some(command)
}

/// A report in a frame as wide as a phone, and a script that notes how it lies there.
const PHONE: &str = r#"<!DOCTYPE html><meta charset="utf-8"><body>
<iframe scrolling="no" style="border: 0; width: WIDTHpx; height: 800px" srcdoc="PAGE"></iframe>
<script>
  window.onload = () => {
    const page = document.querySelector("iframe").contentDocument;
    const boxes = (what) =>
      [...page.querySelectorAll(what)].map((part) => part.getBoundingClientRect());
    const rows = boxes(".commands tbody > tr");
    const highest = Math.max(...rows.map((row) => row.height));
    const cells = boxes(".commands td, .commands th, .commands code");
    const right = Math.max(...cells.map((cell) => cell.right));
    const wide = page.documentElement.scrollWidth;
    const parts = [...page.querySelectorAll("body *")].filter((part) => !part.closest(".wide, pre"));
    const width = page.documentElement.clientWidth;
    const beyond = parts.filter((part) => {
      const { left, right, width: own } = part.getBoundingClientRect();
      return own > 0 && (left < 0 || right > width);
    });
    // labels of one picture: as high as people can read, and none over another
    const pictures = [...page.querySelectorAll("svg")].map((picture) =>
      [...picture.querySelectorAll("text")].map((label) => label.getBoundingClientRect()));
    const lowest = Math.min(...pictures.flat().map((label) => label.height));
    const touch = (a, b) =>
      Math.min(a.right, b.right) - Math.max(a.left, b.left) > 0.5 &&
      Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 0.5;
    const over = pictures.flatMap((all) =>
      all.flatMap((a, k) => all.slice(k + 1).filter((b) => touch(a, b)))).length;
    document.title = `rows ${rows.length} highest ${highest} right ${right} page ${wide} \
beyond ${beyond.length} letters ${lowest} over ${over}`;
  };
</script>"#;

#[test]
fn on_a_phone_commands_stand_below_their_rows_and_nothing_overflows() {
    let parent = tempfile::tempdir().expect("a directory");
    let run = parent.path().join("run");
    run_into(&run, &["--trucks", "10", "--trips", "4"]);
    ocmc(&["report"]).arg(&run).assert().success();
    let page = fs::read_to_string(run.join("report.html")).expect("written");
    let page = page.replace('&', "&amp;").replace('"', "&quot;");
    for width in [360.0, 390.0] {
        let Some(mut browser) = browser(&parent.path().join("profile")) else {
            eprintln!("not tested: no Chromium here");
            return;
        };
        let file = parent.path().join("phone.html");
        let phone = PHONE.replace("WIDTH", &width.to_string()).replace("PAGE", &page);
        fs::write(&file, phone).expect("space");
        let address = format!("file://{}", file.display());
        let output = browser.args(["--dump-dom", &address]).output().expect("the browser starts");
        let shown = String::from_utf8(output.stdout).expect("UTF-8");
        let measured = |name: &str| -> f64 {
            let title = shown.split_once("<title>").and_then(|(_, rest)| rest.split_once('<'));
            let mut words = title.expect("the script ran").0.split(' ');
            words.find(|word| *word == name).expect("measured");
            words.next().and_then(|number| number.parse().ok()).expect("a number")
        };
        assert!(measured("rows") == 10.0);
        // numbers, and below them a command of up to four lines: it repeats what was set, too
        assert!(measured("highest") < 140.0, "{width}: {}", measured("highest"));
        assert!(measured("right") <= width, "{width}: {}", measured("right"));
        assert!(measured("page") <= width, "{width}: {}", measured("page"));
        assert!(measured("beyond") == 0.0, "{width}: {}", measured("beyond"));
        // the browser lays out in steps of 1/64 px
        assert!(measured("letters") >= 11.0 - 1.0 / 64.0, "{width}: {}", measured("letters"));
        assert!(measured("over") == 0.0, "{width}: {}", measured("over"));
    }
}

#[test]
fn a_browser_shows_it_without_errors_and_fetches_nothing() {
    let parent = tempfile::tempdir().expect("a directory");
    let Some(mut browser) = browser(&parent.path().join("profile")) else {
        eprintln!("not tested: no Chromium here");
        return;
    };
    let run = parent.path().join("run");
    run_into(&run, &["--cycles", "400"]);
    ocmc(&["report"]).arg(&run).assert().success();
    let network = parent.path().join("network.json");
    let address = format!("file://{}", run.join("report.html").display());
    let output = browser
        .args(["--enable-logging=stderr", "--v=0", "--dump-dom"])
        .arg(format!("--log-net-log={}", network.display()))
        .arg(&address)
        .output()
        .expect("the browser starts");
    assert!(output.status.success());
    let page = String::from_utf8(output.stdout).expect("UTF-8");
    for part in ["Where the energy went", "<polyline", "<rect", "Provenance"] {
        assert!(page.contains(part), "{part}");
    }
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(!message.contains("CONSOLE"), "{message}");
    let log = fs::read_to_string(&network).expect("the browser writes its log");
    assert!(log.contains("report.html") || log.contains("constants"), "a log of requests");
    // the browser's own services are not the page's; what the page asks for has it as its initiator
    let asked: Vec<&str> = log
        .lines()
        .filter(|line| {
            line.contains("\"initiator\":\"file:") || line.contains("\"initiator\":\"null")
        })
        .collect();
    assert!(asked.is_empty(), "{asked:?}");
}
