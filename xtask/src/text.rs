//! Reads Rust and C well enough for the checks of this repository: blanks comments and literals, lists identifiers.

/// The source with every comment, string and character literal blanked. Line breaks are kept.
pub fn code_only(source: &str) -> String {
    let bytes = source.as_bytes();
    let mut out = String::with_capacity(source.len());
    let mut at = 0;
    while at < bytes.len() {
        let rest = &source[at..];
        let skip = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            block_comment(rest)
        } else if rest.starts_with('"') {
            literal(rest, '"')
        } else if let Some(n) = raw_string(rest, &out) {
            n
        } else if rest.starts_with('\'') {
            // A character literal or a lifetime: only the former has a closing quote.
            let mut inside = rest.chars().skip(1);
            match (inside.next(), inside.next()) {
                (Some('\\'), _) => literal(rest, '\''),
                (Some(c), Some('\'')) => 2 + c.len_utf8(),
                _ => 0,
            }
        } else {
            0
        };
        if skip == 0 {
            let c = rest.chars().next().unwrap_or(' ');
            out.push(c);
            at += c.len_utf8();
        } else {
            out.push(' ');
            out.extend(rest[..skip].chars().filter(|&c| c == '\n'));
            at += skip;
        }
    }
    out
}

fn block_comment(rest: &str) -> usize {
    let (mut depth, mut at) = (0_usize, 0);
    while at < rest.len() {
        if rest[at..].starts_with("/*") {
            depth += 1;
            at += 2;
        } else if rest[at..].starts_with("*/") {
            depth -= 1;
            at += 2;
            if depth == 0 {
                return at;
            }
        } else {
            at += rest[at..].chars().next().map_or(1, char::len_utf8);
        }
    }
    rest.len()
}

fn literal(rest: &str, quote: char) -> usize {
    let mut escaped = false;
    for (k, c) in rest.char_indices().skip(1) {
        if !escaped && c == quote {
            return k + 1;
        }
        escaped = !escaped && c == '\\';
    }
    rest.len()
}

/// The length of the raw string that starts here, if there is one.
fn raw_string(rest: &str, before: &str) -> Option<usize> {
    if before.ends_with(|c: char| c.is_alphanumeric() || c == '_') && !before.ends_with(['b', 'c']) {
        return None;
    }
    let hashes = rest.strip_prefix('r')?.chars().take_while(|&c| c == '#').count();
    if !rest[1 + hashes..].starts_with('"') {
        return None;
    }
    let end = format!("\"{}", "#".repeat(hashes));
    let start = 2 + hashes;
    Some(rest[start..].find(&end).map_or(rest.len(), |k| start + k + end.len()))
}

/// Every identifier with its offset.
pub fn identifiers(code: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut at = 0;
    std::iter::from_fn(move || {
        let start = at + code[at..].find(|c: char| c.is_alphanumeric() || c == '_')?;
        let tail = &code[start..];
        let end = start + tail.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(tail.len());
        at = end;
        Some((start, &code[start..end]))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_literals_go() {
        let source = "a /* unsafe /* x */ */ b // unsafe\n\"un\\\"safe\" r#\"unsafe\"# '\\'' 'x' &'life c br\"unsafe\"";
        let code = code_only(source);
        let words: Vec<_> = identifiers(&code).map(|(_, word)| word).collect();
        assert_eq!(words, ["a", "b", "life", "c", "b"]);
        assert_eq!(code.matches('\n').count(), 1);
    }
}
