//! The page of a fleet of groups: what it uses, emits and costs, whole and by group.

use super::opening::lead;
use super::svg::{bars, escaped};
use super::tables::{cells, rows, table};
use super::{FOOT, STYLE, folded, page_head};
use std::fmt::Write;

/// A fleet of groups, as far as its page needs it.
#[derive(Clone, Copy, Debug)]
pub struct MixedFleetPage<'a> {
    /// Name of the study.
    pub study: &'a str,
    /// The answer in a sentence.
    pub said: &'a str,
    /// Key figures in large print: numbers with their units, and their meaning.
    pub keys: &'a [[String; 2]],
    /// Name of the total whose shares are drawn.
    pub shared: &'a str,
    /// Name of each group, its share of that total, and this in words; none where not all have it.
    pub shares: &'a [(String, f64, String)],
    /// Tables below.
    pub tables: &'a [PageTable],
    /// The command that repeats it, in the directory of the study.
    pub command: &'a str,
    /// Facts about it.
    pub facts: &'a [(&'static str, String)],
}

/// A table of a page.
#[derive(Clone, Debug)]
pub struct PageTable {
    /// Heading above it.
    pub heading: &'static str,
    /// Note of the table, in a sentence.
    pub note: &'static str,
    /// Names of its columns.
    pub head: Vec<String>,
    /// Its rows.
    pub rows: Vec<Vec<String>>,
}

/// The page: HTML that opens offline.
pub fn mixed_fleet_html(page: &MixedFleetPage) -> String {
    let mut text = lead(page.said) + "<div class=\"key\">\n";
    for [number, words] in page.keys {
        let _ = writeln!(text, "<div><b>{}</b>{}</div>", escaped(number), escaped(words));
    }
    text.push_str("</div>\n");
    let (name, shares) = (page.shared, page.shares);
    if !shares.is_empty() {
        let _ = writeln!(
            text,
            "<h2>{0} by group</h2>\n<figure>{1}<figcaption>What each group adds to the {0} of the \
             fleet.</figcaption></figure>",
            escaped(name),
            bars(shares, &format!("{name} by group"))
        );
    }
    for PageTable { heading, note, head, rows } in page.tables {
        let head: Vec<String> = head.iter().map(|name| escaped(name)).collect();
        let rows =
            rows.iter().map(|row| cells(&row.iter().map(|cell| escaped(cell)).collect::<Vec<_>>()));
        let _ = writeln!(
            text,
            "<h2>{heading}</h2>\n<p class=\"soft\">{note}</p>\n{}",
            table(&head, rows)
        );
    }
    let _ = write!(
        text,
        "<h2>Repeat this answer</h2>\n<p>Where the study file is:</p>\n<pre class=\"command\" \
         tabindex=\"0\">{}</pre>\n<h2>Provenance</h2>\n<div class=\"wide\" \
         tabindex=\"0\"><table><tbody>\n{}</tbody></table></div>\n",
        escaped(page.command),
        rows(page.facts)
    );
    text.push_str(
        "<p class=\"soft\">Behind ± lies where another fleet of as many such trucks would lie. It \
         does not hold the error of the models, nor that of numbers that were judged.</p>\n",
    );
    let title = escaped(page.study);
    let top = page_head(&format!("{title}: a fleet of groups, by ocmc"), STYLE);
    format!("{top}<h1>{title}</h1>\n{}{FOOT}", folded(&text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_answer_stands_first_and_names_stay_text() {
        let shares = [
            ("<a>".to_owned(), 30.0, "30.0 t".to_owned()),
            ("b".to_owned(), 10.0, "10.0 t".to_owned()),
        ];
        let table = PageTable {
            heading: "By group",
            note: "All of them.",
            head: vec!["group".to_owned(), "fuel, L".to_owned()],
            rows: vec![vec!["<a>".to_owned(), "1 ± 0.1".to_owned()]],
        };
        let page = mixed_fleet_html(&MixedFleetPage {
            study: "a & b",
            said: "40 trucks use 3 L.",
            keys: &[["3 ± 1 L".to_owned(), "fuel".to_owned()]],
            shared: "WTW CO2e",
            shares: &shares,
            tables: &[table],
            command: "ocmc --study mixed.toml",
            facts: &[("seed", "1".to_owned())],
        });
        let at = |words: &str| page.find(words).unwrap_or_else(|| panic!("{words}: {page}"));
        assert!(at("40 trucks use") < at("<b>3 ± 1 L</b>") && at("<b>3") < at("By group"));
        assert!(page.contains("a &amp; b") && page.contains("&lt;a&gt;") && !page.contains("<a>"));
        assert_eq!(page.matches("class=\"bar\"").count(), 2);
    }
}
