//! Lays out what cbindgen writes: short comments on one line, prototypes filled, and the forms of a function for other scalars and dimensions right below it.

/// The longest line of a prototype or of a comment of one line.
const WIDTH: usize = 130;

pub(super) fn lay_out(header: &str) -> String {
    let mut out: Vec<String> = Vec::new();
    let mut lines = header.lines().peekable();
    while let Some(line) = lines.next() {
        if line.trim() == "/**" {
            comment(&mut out, line, &mut lines);
        } else if let Some((head, first)) = prototype(line) {
            let mut arguments = first.to_owned();
            while !arguments.ends_with(");") {
                let Some(next) = lines.next() else { break };
                arguments.push(' ');
                arguments.push_str(next.trim());
            }
            // A form of the function above it: no line between.
            if out.len() > 1 && out[out.len() - 1].is_empty() && out[out.len() - 2].ends_with(");") {
                out.pop();
            }
            let arguments: Vec<_> = arguments.trim_end_matches(");").split(", ").collect();
            fill(&mut out, format!("{head}("), (&arguments, ",", ");"));
        } else if line.starts_with("typedef struct") && line.ends_with('{') {
            members(&mut out, line, &mut lines);
        } else if line.starts_with("#define") && ends_with_constant(&out) {
            // Constants that are explained on one line each follow one another.
            let comment = out.pop().unwrap_or_default();
            out.pop();
            out.extend([comment, line.to_owned()]);
        } else if !(line.is_empty() && out.last().is_some_and(String::is_empty)) {
            out.push(line.to_owned());
        }
    }
    out.join("\n") + "\n"
}

/// A comment, on one line if it has one.
fn comment<'a>(out: &mut Vec<String>, start: &str, lines: &mut impl Iterator<Item = &'a str>) {
    let indent = &start[..start.len() - start.trim_start().len()];
    let text: Vec<_> = lines.take_while(|line| line.trim() != "*/").collect();
    let bare = |line: &str| line.trim_start().trim_start_matches('*').trim().to_owned();
    match text.as_slice() {
        [one] if indent.len() + bare(one).len() + 7 <= WIDTH => out.push(format!("{indent}/** {} */", bare(one))),
        _ => {
            out.push(start.to_owned());
            out.extend(text.into_iter().map(|line| line.trim_end().to_owned()));
            out.push(format!("{indent} */"));
        }
    }
}

/// What is in front of the parenthesis of a function of the library, and what is behind it on the line.
fn prototype(line: &str) -> Option<(&str, &str)> {
    let (head, first) = line.split_once('(')?;
    let name = head.rsplit([' ', '*']).next()?;
    let is_function = name.starts_with("mollis_") && !head.starts_with([' ', '#', '/']) && !head.starts_with("typedef");
    is_function.then_some((head, first))
}

/// Whether the last lines are a constant, an empty line and a comment of one line.
fn ends_with_constant(out: &[String]) -> bool {
    let [.., constant, empty, comment] = out else { return false };
    constant.starts_with("#define") && empty.is_empty() && comment.starts_with("/** ") && comment.ends_with("*/")
}

/// A structure; its members fill lines if they are explained at the form for the plane.
fn members<'a>(out: &mut Vec<String>, start: &str, lines: &mut impl Iterator<Item = &'a str>) {
    let (mut body, mut end) = (Vec::new(), "}");
    for line in lines {
        if line.starts_with('}') {
            end = line;
            break;
        }
        body.push(line);
    }
    if body.iter().any(|line| line.trim() == "/**") {
        out.push(start.to_owned());
        let body = lay_out(&body.join("\n"));
        out.extend(body.lines().map(str::to_owned));
    } else {
        out.push(start.to_owned());
        let body: Vec<_> = body.iter().map(|line| line.trim().trim_end_matches(';')).collect();
        fill(out, "  ".to_owned(), (&body, ";", ";"));
    }
    out.push(end.to_owned());
}

/// Appends parts to a line; what does not fit goes to further ones.
fn fill(out: &mut Vec<String>, mut line: String, (parts, between, last): (&[&str], &str, &str)) {
    for (k, part) in parts.iter().enumerate() {
        let end = if k + 1 == parts.len() { last } else { between };
        let space = if line.ends_with(['(', ' ']) { "" } else { " " };
        if line.len() + space.len() + part.len() + end.len() > WIDTH {
            let indent = if last == ";" { "  " } else { "    " };
            out.push(std::mem::replace(&mut line, format!("{indent}{part}{end}")));
        } else {
            line.push_str(&format!("{space}{part}{end}"));
        }
    }
    out.push(line);
}

#[cfg(test)]
mod tests {
    use super::lay_out;

    #[test]
    fn comments_and_prototypes() {
        let long = "  /**\n   * One.\n   *\n   * Two.\n   */\n  double x;\n";
        assert_eq!(lay_out(long), long);
        assert_eq!(lay_out("/**\n * Short.\n */\n#define A 1\n"), "/** Short. */\n#define A 1\n");
        let two = "/**\n * Doc.\n */\nint mollis_a(int x,\n             int y);\n\nint mollis_b(void);\n\n#ifdef X\n";
        let plain = "typedef struct s {\n  int x;\n  int y;\n} s;\n";
        assert_eq!(lay_out(plain), "typedef struct s {\n  int x; int y;\n} s;\n");
        let constants = "/**\n * A.\n */\n#define A 1\n\n/**\n * B.\n */\n#define B 2\n";
        assert_eq!(lay_out(constants), "/** A. */\n#define A 1\n/** B. */\n#define B 2\n");
        assert_eq!(lay_out(two), "/** Doc. */\nint mollis_a(int x, int y);\nint mollis_b(void);\n\n#ifdef X\n");
    }
}
