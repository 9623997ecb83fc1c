//! The files of the page.

use std::borrow::Cow;

/// A file of the page: its name, its type, and its bytes.
pub(crate) struct Asset {
    pub(crate) name: &'static str,
    pub(crate) kind: &'static str,
    pub(crate) bytes: &'static [u8],
}

/// Mark on the page that names its engine: as the file lies there, one in the tab.
const ENGINE_OF_TAB: &str = r#"name="ocmc-engine" content="tab""#;
const ENGINE_OF_PROGRAM: &str = r#"name="ocmc-engine" content="native""#;

impl Asset {
    /// Bytes that the browser gets: on the page itself this program is named as its engine.
    pub(crate) fn served(&self) -> Cow<'static, [u8]> {
        if self.kind != HTML {
            return Cow::Borrowed(self.bytes);
        }
        let text = String::from_utf8_lossy(self.bytes);
        Cow::Owned(text.replacen(ENGINE_OF_TAB, ENGINE_OF_PROGRAM, 1).into_bytes())
    }
}

const HTML: &str = "text/html; charset=utf-8";
const STYLE: &str = "text/css; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const PICTURE: &str = "image/svg+xml";
const TEXT: &str = "text/plain; charset=utf-8";

const fn asset(name: &'static str, kind: &'static str, bytes: &'static [u8]) -> Asset {
    Asset { name, kind, bytes }
}

/// All of them.
const ASSETS: &[Asset] = &[
    asset("answer.js", SCRIPT, include_bytes!("../assets/answer.js")),
    asset("compare.js", SCRIPT, include_bytes!("../assets/compare.js")),
    asset("cost.js", SCRIPT, include_bytes!("../assets/cost.js")),
    asset("dom.js", SCRIPT, include_bytes!("../assets/dom.js")),
    asset("doubt.js", SCRIPT, include_bytes!("../assets/doubt.js")),
    asset("engine-native.js", SCRIPT, include_bytes!("../assets/engine-native.js")),
    asset("engine.js", SCRIPT, include_bytes!("../assets/engine.js")),
    asset("fields.js", SCRIPT, include_bytes!("../assets/fields.js")),
    asset("files.js", SCRIPT, include_bytes!("../assets/files.js")),
    asset("fleet.js", SCRIPT, include_bytes!("../assets/fleet.js")),
    asset("format.js", SCRIPT, include_bytes!("../assets/format.js")),
    asset("icon.svg", PICTURE, include_bytes!("../assets/icon.svg")),
    asset("index.html", HTML, include_bytes!("../assets/index.html")),
    asset("job.js", SCRIPT, include_bytes!("../assets/job.js")),
    asset("laws.js", SCRIPT, include_bytes!("../assets/laws.js")),
    asset("live.js", SCRIPT, include_bytes!("../assets/live.js")),
    asset("main.js", SCRIPT, include_bytes!("../assets/main.js")),
    asset("page.css", STYLE, include_bytes!("../assets/page.css")),
    asset("planner.js", SCRIPT, include_bytes!("../assets/planner.js")),
    asset("plot.js", SCRIPT, include_bytes!("../assets/plot.js")),
    asset("range.js", SCRIPT, include_bytes!("../assets/range.js")),
    asset("save.js", SCRIPT, include_bytes!("../assets/save.js")),
    asset("sketch.js", SCRIPT, include_bytes!("../assets/sketch.js")),
    asset("study.js", SCRIPT, include_bytes!("../assets/study.js")),
    asset("tables.js", SCRIPT, include_bytes!("../assets/tables.js")),
    asset("trip.js", SCRIPT, include_bytes!("../assets/trip.js")),
    asset("trucks.js", SCRIPT, include_bytes!("../assets/trucks.js")),
    asset("vendor/uPlot.esm.js", SCRIPT, include_bytes!("../assets/vendor/uPlot.esm.js")),
    asset("vendor/uPlot.min.css", STYLE, include_bytes!("../assets/vendor/uPlot.min.css")),
    asset("vendor/LICENSE", TEXT, include_bytes!("../assets/vendor/LICENSE")),
];

/// The file of a name; the page itself has none.
pub(crate) fn find(name: &str) -> Option<&'static Asset> {
    let name = if name.is_empty() { "index.html" } else { name };
    ASSETS.iter().find(|asset| asset.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::path::Path;

    #[test]
    fn the_served_page_names_this_program_as_its_engine() {
        let page = find("").expect("the page").served();
        assert!(String::from_utf8_lossy(&page).contains(ENGINE_OF_PROGRAM));
    }

    #[test]
    fn every_file_that_a_served_page_names_is_there() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
        let mut missing = Vec::new();
        for entry in fs::read_dir(folder).expect("the folder").flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            let is_of_tab = ["engine-tab.js", "offline.js", "tab-worker.js", "wasi.js"]
                .contains(&name.as_str());
            if entry.path().is_file() && !is_of_tab && find(&name).is_none() {
                missing.push(name);
            }
        }
        assert!(missing.is_empty(), "{missing:?}");
    }
}
