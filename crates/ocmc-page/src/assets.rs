//! The files of the page.

/// A file of the page: its name, its type, and its bytes.
pub(crate) struct Asset {
    pub(crate) name: &'static str,
    pub(crate) kind: &'static str,
    pub(crate) bytes: &'static [u8],
}

const HTML: &str = "text/html; charset=utf-8";
const STYLE: &str = "text/css; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";

const fn asset(name: &'static str, kind: &'static str, bytes: &'static [u8]) -> Asset {
    Asset { name, kind, bytes }
}

/// All of them.
const ASSETS: &[Asset] = &[
    asset("index.html", HTML, include_bytes!("../assets/index.html")),
    asset("page.css", STYLE, include_bytes!("../assets/page.css")),
    asset("main.js", SCRIPT, include_bytes!("../assets/main.js")),
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
    fn every_file_that_a_served_page_names_is_there() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
        let mut missing = Vec::new();
        for entry in fs::read_dir(folder).expect("the folder").flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            let is_of_tab = ["engine-tab.js", "tab-worker.js", "wasi.js"].contains(&name.as_str());
            if entry.path().is_file() && !is_of_tab && find(&name).is_none() {
                missing.push(name);
            }
        }
        assert!(missing.is_empty(), "{missing:?}");
    }
}
