//! Texts that mean nothing to Markdown.

/// `text` in a paragraph or a cell, as it is: what Markdown would take for its own is marked, and line breaks are spaces.
pub(super) fn plain(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\\' | '`' | '*' | '_' | '[' | ']' | '<' | '>' | '#' | '|' | '~' | '&' | '!' | '$' => {
                plain.extend(['\\', c]);
            }
            c if c.is_control() => plain.push(' '),
            c => plain.push(c),
        }
    }
    plain
}

/// `text` as code in a paragraph or a cell.
pub(super) fn code(text: &str) -> String {
    // In a table a bar ends the cell, in code too.
    let text = text.replace('|', "\\|").replace(char::is_control, " ");
    let ticks = fence(&text, 1);
    // Beside a tick of its own, code has a space that is not shown.
    let space = if text.starts_with('`') || text.ends_with('`') {
        " "
    } else {
        ""
    };
    format!("{ticks}{space}{text}{space}{ticks}")
}

/// Lines of `text` as they are, of what a `language` is made of.
pub(super) fn block(language: &str, text: &str) -> String {
    let ticks = fence(text, 3);
    format!("{ticks}{language}\n{text}\n{ticks}")
}

/// More ticks than stand in a row in `text`, at least so many.
fn fence(text: &str, least: usize) -> String {
    let rows = text.split(|c| c != '`').map(str::len);
    "`".repeat(rows.fold(0, usize::max).saturating_add(1).max(least))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files_mean_nothing_to_markdown() {
        let name = "a_b*c* [d](e) <img> `f`|g\n# h";
        let expected = r"a\_b\*c\* \[d\](e) \<img\> \`f\`\|g \# h";
        assert_eq!(plain(name), expected);
        assert_eq!(plain("scenes/room-2.toml"), "scenes/room-2.toml");
    }

    #[test]
    fn code_may_hold_ticks_and_bars() {
        assert_eq!(code("a=1"), "`a=1`");
        assert_eq!(code("a='|'"), r"`a='\|'`");
        assert_eq!(code("a=`b``c"), "```a=`b``c```");
        assert_eq!(code("`"), "`` ` ``");
        assert_eq!(block("sh", "a"), "```sh\na\n```");
        assert_eq!(block("sh", "a ``` b"), "````sh\na ``` b\n````");
    }
}
