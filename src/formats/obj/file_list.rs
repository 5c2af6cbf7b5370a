//! Lists of material files. Spaces separate names, and may also be part of names.

/// Maximum number of words of a name that are tried together, and of bytes.
const MAX_WORDS: usize = 12;
const MAX_NAME_BYTES: usize = 4096;

/// The names of a list of at most `most` words: at each word the longest run of words that `exists`
/// knows, and what stands between such runs, cut behind each `.mtl`.
pub(super) fn split(names: &str, most: usize, exists: impl Fn(&str) -> bool) -> Vec<&str> {
    let words = words(names, most);
    let mut split = Vec::new();
    let mut unknown = None;
    let mut index = 0;
    while let Some(&(start, _)) = words.get(index) {
        let ends = words[index..].iter().take(MAX_WORDS).map(|word| word.1);
        let short = ends.take_while(|end| end - start <= MAX_NAME_BYTES);
        let runs: Vec<&str> = short.map(|end| &names[start..end]).collect();
        match runs.iter().rposition(|run| exists(run)) {
            Some(last) => {
                let before = unknown.take().map_or("", |from: usize| &names[from..start]);
                split.extend(split_at_mtl(before));
                split.push(runs[last]);
                index += last + 1;
            }
            None => {
                unknown.get_or_insert(start);
                index += 1;
            }
        }
    }
    let end = words.last().map_or(0, |word| word.1);
    split.extend(split_at_mtl(unknown.map_or("", |from| &names[from..end])));
    split
}

/// Names that end where a word ends in `.mtl`.
pub(super) fn split_at_mtl(names: &str) -> impl Iterator<Item = &str> {
    let ends = names
        .match_indices(char::is_whitespace)
        .map(|(offset, _)| offset);
    let ends = ends.chain([names.len()]).filter(|&end| {
        let ending = end.checked_sub(4).and_then(|start| names.get(start..end));
        end == names.len() || ending.is_some_and(|ending| ending.eq_ignore_ascii_case(".mtl"))
    });
    let mut start = 0;
    let parts = ends.map(move |end| {
        let part = names[start..end].trim();
        start = end;
        part
    });
    parts.filter(|part| !part.is_empty())
}

/// Starts and ends of words. Blanks in double quotes or behind a `\` end none.
fn words(names: &str, most: usize) -> Vec<(usize, usize)> {
    let mut words = Vec::new();
    let mut start = None;
    let mut quoted = false;
    let mut before = ' ';
    for (offset, c) in names.char_indices() {
        if start.is_none() {
            quoted = c == '"';
        } else if c == '"' {
            quoted = false;
        }
        let ends = c.is_whitespace() && !quoted && before != '\\';
        match start {
            Some(first) if ends => {
                words.push((first, offset));
                start = None;
            }
            None if !c.is_whitespace() => start = Some(offset),
            _ => {}
        }
        if words.len() == most {
            return words;
        }
        before = c;
    }
    words.extend(start.map(|first| (first, names.trim_end().len())));
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_run_that_exists_is_a_name() {
        let existing = ["a", "my lib", "my lib two", "c.mtl", "\"d e\"", "f\\ g"];
        let names = |list| split(list, 100, |name| existing.contains(&name));
        assert_eq!(
            names("a my lib two my lib c.mtl"),
            ["a", "my lib two", "my lib", "c.mtl"]
        );
        assert_eq!(
            names("no my c.mtl more\tx.MTL y a"),
            ["no my", "c.mtl", "more\tx.MTL", "y", "a"]
        );
        assert_eq!(
            names("\"d e\"  f\\ g \"open a"),
            ["\"d e\"", "f\\ g", "\"open a"]
        );
        assert_eq!(names(""), [""; 0]);
        assert_eq!(split("x y z", 2, |_| false), ["x y"]);
    }

    #[test]
    fn work_is_bounded() {
        let calls = std::cell::Cell::new(0);
        let long = "word ".repeat(100_000);
        let count = |_: &str| {
            calls.set(calls.get() + 1);
            false
        };
        split(&long, 1000, count);
        assert!(calls.get() <= 1000 * MAX_WORDS);
    }
}
