//! Finding JSON in prose.

/// Places at which JSON may begin that are looked at; an answer that has it later is prose.
const MOST_STARTS: usize = 64;

/// Balanced `{…}` and `[…]` pieces of `text` in order, the outer ones before those inside them. Brackets inside of strings
/// count for nothing.
pub(super) fn balanced(text: &str) -> impl Iterator<Item = &str> {
    let starts = text.char_indices().filter(|(_, c)| matches!(c, '{' | '['));
    starts.take(MOST_STARTS).filter_map(|(start, _)| piece(&text[start..]))
}

/// Whether `text` opens something that it never closes: it was cut off.
pub(super) fn is_cut_off(text: &str) -> bool {
    text.find(['{', '[']).is_some_and(|start| piece(&text[start..]).is_none())
}

/// The balanced piece at the start of `text`.
fn piece(text: &str) -> Option<&str> {
    let mut open = Vec::new();
    let (mut in_string, mut escaped) = (false, false);
    for (at, c) in text.char_indices() {
        if in_string {
            match c {
                _ if escaped => escaped = false,
                '\\' => escaped = true,
                '"' => in_string = false,
                _ => {}
            }
            continue;
        }
        match c {
            '"' => in_string = true,
            '{' => open.push('}'),
            '[' => open.push(']'),
            '}' | ']' => {
                if open.pop() != Some(c) {
                    return None;
                }
                if open.is_empty() {
                    return Some(&text[..at + 1]);
                }
            }
            _ => {}
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_found_in_prose_and_strings_are_respected() {
        let text = r#"I see {braces}, and: {"a": "}\"]", "b": [1, {"c": 2}]} done"#;
        let found: Vec<&str> = balanced(text).collect();
        assert_eq!(found[0], "{braces}");
        assert_eq!(found[1], r#"{"a": "}\"]", "b": [1, {"c": 2}]}"#);
        assert_eq!(found[2..], [r#"[1, {"c": 2}]"#, r#"{"c": 2}"#]);
        assert!(is_cut_off(r#"{"a": [1, 2"#) && !is_cut_off("no json"));
    }
}
