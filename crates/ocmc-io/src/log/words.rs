//! A column of words, each kept once.

/// The words of a column.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Words {
    names: Vec<String>,
    of_row: Vec<u32>,
}

impl Words {
    /// Adds a row.
    pub(super) fn push(&mut self, word: &str) {
        // a word holds for many rows: the last one is the likeliest
        let last = self.of_row.last().filter(|&&place| self.names[place as usize] == word);
        let place = last.copied().unwrap_or_else(|| {
            let known = self.names.iter().position(|name| name == word);
            known.unwrap_or_else(|| {
                self.names.push(word.to_owned());
                self.names.len() - 1
            }) as u32
        });
        self.of_row.push(place);
    }

    /// The word of each row, empty where there is none.
    pub fn rows(&self) -> impl Iterator<Item = &str> {
        self.of_row.iter().map(|&place| self.names[place as usize].as_str())
    }
}
