//! Lines of the text files of the format, and what does not make sense in them.

use crate::import::{Error, Location, Warnings};
use std::collections::BTreeMap;
use std::path::Path;

/// Calls a function with the line number, the keyword and the rest of every statement.
///
/// A statement ends with its line, unless that ends with a backslash.
pub(crate) fn for_each<E>(
    bytes: &[u8],
    mut statement: impl FnMut(u32, &[u8], &[u8]) -> Result<(), E>,
) -> Result<(), E> {
    let end = if bytes.contains(&b'\n') { b'\n' } else { b'\r' };
    let mut joined = Vec::new();
    for (line, number) in bytes.split(|byte| *byte == end).zip(1..) {
        let mut line = line.trim_ascii();
        if let [part @ .., b'\\'] = line
            && !line.starts_with(b"#")
        {
            joined.extend_from_slice(part);
            joined.push(b' ');
            continue;
        }
        if !joined.is_empty() {
            joined.extend_from_slice(line);
            line = &joined;
        }
        let keyword = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
        let (keyword, rest) = line.split_at(keyword);
        if !keyword.is_empty() && !keyword.starts_with(b"#") {
            statement(number, keyword, rest.trim_ascii_start())?;
        }
        joined.clear();
    }
    Ok(())
}

/// The words of a statement up to a comment.
pub(crate) fn words(rest: &[u8]) -> impl Iterator<Item = &[u8]> {
    rest.split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty())
        .take_while(|word| word[0] != b'#')
}

/// A number, which need not be finite.
pub(crate) fn number<T: std::str::FromStr>(word: &[u8]) -> Option<T> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// The faults of a file, those of one kind as one: a file may have millions.
#[derive(Debug, Default)]
pub(crate) struct Faults(BTreeMap<String, (u32, u64)>);

impl Faults {
    /// Counts a fault; the first of its kind is the one whose line is told.
    pub fn add(&mut self, line: u32, reason: &str) {
        if let Some((_, count)) = self.0.get_mut(reason) {
            *count += 1;
        } else if self.0.len() < Warnings::MOST {
            self.0.insert(reason.to_owned(), (line, 1));
        }
    }

    /// Warns of all of them, in the order of their lines.
    pub fn warn(self, file: &Path, warnings: &mut Warnings) -> Result<(), Error> {
        let mut faults: Vec<_> = self.0.into_iter().collect();
        faults.sort_by_key(|(_, (line, _))| *line);
        for (reason, (line, count)) in faults {
            let location =
                Location { file: file.to_owned(), line: Some(line), ..Location::default() };
            warnings.warn_times(location, reason, count)?;
        }
        Ok(())
    }
}
