//! Comments: their width and their first words.

use crate::source::everything;

/// Last column of a comment.
const WIDTH: usize = 100;

/// Words with which no doc comment may begin: a noun or a verb names the thing.
const OPENINGS: [&str; 4] = ["What", "Whether", "Of", "By"];

/// Exceptions, at most ten: the file, the beginning of the comment, the reason.
const EXCEPTIONS: [(&str, &str, &str); 0] = [];

#[test]
fn comments_end_at_column_100() {
    let mut wrong = Vec::new();
    for source in &everything() {
        let mut fenced = false;
        for (line, number) in source.text.lines().zip(1..) {
            let trimmed = line.trim_start();
            let body = trimmed.trim_start_matches(['/', '!']).trim_start();
            let comment = trimmed.starts_with("//");
            if comment && body.starts_with("```") {
                fenced = !fenced;
            }
            // Table rows, lines of examples and single words cannot be broken.
            let unbreakable = fenced || body.starts_with('|') || !body.contains(' ');
            let wide = line.chars().count() > WIDTH;
            if wide && !(comment && unbreakable) && (comment || line.contains(" // ")) {
                wrong.push(format!(
                    "{}:{number}: {}",
                    source.path,
                    line.chars().count()
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Doc comments of a text, each with its first line's number.
fn doc_comments(text: &str) -> Vec<(usize, String)> {
    let mut comments: Vec<(usize, String)> = Vec::new();
    let mut open = "";
    for (line, number) in text.lines().zip(1..) {
        let trimmed = line.trim_start();
        let mark = ["///", "//!"].into_iter().find(|m| trimmed.starts_with(m));
        let Some(mark) = mark else {
            open = "";
            continue;
        };
        let body = trimmed[mark.len()..].trim();
        match comments.last_mut() {
            Some((_, words)) if open == mark => {
                words.push(' ');
                words.push_str(body);
            }
            _ => comments.push((number, body.to_owned())),
        }
        open = mark;
    }
    comments
}

/// Doc comments for which `wrong` holds, except the exceptions.
fn doc_comments_that(wrong: impl Fn(&str) -> bool) -> Vec<String> {
    const { assert!(EXCEPTIONS.len() <= 10) };
    let mut comments = Vec::new();
    for source in &everything() {
        let excused = |text: &str| {
            let mut rows = EXCEPTIONS.iter().filter(|row| row.0 == source.path);
            rows.any(|row| text.starts_with(row.1))
        };
        for (number, text) in doc_comments(&source.text) {
            if wrong(&text) && !excused(&text) {
                let beginning: String = text.chars().take(60).collect();
                comments.push(format!("{}:{number}: {beginning}", source.path));
            }
        }
    }
    comments
}

#[test]
fn doc_comments_are_read() {
    let text = "//! A\n\n/// B so\n/// many\n//! C\nfn f() {} // D\n    /// E\n";
    let comments = doc_comments(text);
    let expected = [(1, "A"), (3, "B so many"), (5, "C"), (7, "E")];
    assert_eq!(comments.len(), expected.len());
    for (comments, expected) in comments.iter().zip(expected) {
        assert_eq!((comments.0, comments.1.as_str()), expected);
    }
}

#[test]
fn doc_comments_begin_with_a_noun_or_a_verb() {
    let wrong = doc_comments_that(|text| {
        let first = text.split(|c: char| !c.is_alphanumeric()).next();
        first.is_some_and(|word| OPENINGS.contains(&word))
    });
    assert!(
        wrong.is_empty(),
        "{} of them:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
}

#[test]
fn doc_comments_name_their_quantities() {
    let vague = ["so", "many"].join(" ");
    let wrong = doc_comments_that(|text| text.to_lowercase().contains(&vague));
    assert!(
        wrong.is_empty(),
        "{} of them:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
}
