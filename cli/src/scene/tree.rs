//! A TOML file as a tree in which every value knows the line that it stands on.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::mistake::Mistake;

/// A value and where it was written.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// The value.
    pub value: Value,
    /// Line in the file, from 1.
    pub line: usize,
}

/// What a value may be.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// An integer or a decimal.
    Number(f64),
    /// A string.
    Text(String),
    /// `true` or `false`.
    Flag(bool),
    /// `[...]` or `[[...]]`.
    List(Vec<Node>),
    /// `[...]` with keys, in the order of the file.
    Table(Vec<(String, Node)>),
}

impl Node {
    /// An empty table.
    pub fn empty() -> Self {
        Self { value: Value::Table(Vec::new()), line: 1 }
    }

    /// The entries of a table; none for anything else.
    pub fn entries(&self) -> &[(String, Node)] {
        match &self.value {
            Value::Table(entries) => entries,
            _ => &[],
        }
    }

    /// The elements of a list; none for anything else.
    pub fn elements(&self) -> &[Node] {
        match &self.value {
            Value::List(elements) => elements,
            _ => &[],
        }
    }

    /// What stands under `key`.
    pub fn get(&self, key: &str) -> Option<&Node> {
        self.entries().iter().find(|(name, _)| name == key).map(|(_, node)| node)
    }

    /// The line of a key, or of the table itself where the key does not stand.
    pub fn line_of(&self, key: &str) -> usize {
        self.get(key).map_or(self.line, |node| node.line)
    }

    /// The table without `key`.
    pub fn without(&self, key: &str) -> Self {
        let entries = self.entries().iter().filter(|(name, _)| name != key).cloned().collect();
        Self { value: Value::Table(entries), line: self.line }
    }

    /// A number, also one written as text in multiples of pi: `"32 pi"`.
    pub fn number(&self) -> Option<f64> {
        match &self.value {
            Value::Number(number) => Some(*number),
            Value::Text(text) => {
                let factor = text.strip_suffix("pi")?.trim();
                let factor = if factor.is_empty() { 1.0 } else { factor.parse::<f64>().ok()? };
                Some(factor * std::f64::consts::PI)
            }
            _ => None,
        }
    }

    /// As it is shown in a message.
    pub fn shown(&self) -> String {
        match &self.value {
            Value::Number(number) => format!("{number}"),
            Value::Text(text) => format!("{text:?}"),
            Value::Flag(flag) => format!("{flag}"),
            Value::List(elements) => {
                let inner: Vec<String> = elements.iter().take(6).map(Node::shown).collect();
                format!("[{}{}]", inner.join(", "), if elements.len() > 6 { ", ..." } else { "" })
            }
            Value::Table(_) => "{ ... }".to_owned(),
        }
    }

    /// `self` with everything that `over` states put over it: tables are merged, all else is replaced.
    pub fn overlaid(&self, over: &Node) -> Node {
        let (Value::Table(base), Value::Table(changes)) = (&self.value, &over.value) else { return over.clone() };
        let mut entries = base.clone();
        for (key, change) in changes {
            match entries.iter_mut().find(|(name, _)| name == key) {
                Some((_, node)) => *node = node.overlaid(change),
                None => entries.push((key.clone(), change.clone())),
            }
        }
        Node { value: Value::Table(entries), line: self.line }
    }
}

/// Reads TOML. What is not TOML is a mistake with its line.
pub fn parse(text: &str) -> Result<Node, Mistake> {
    let lines = Lines::new(text);
    match DeTable::parse(text) {
        Ok(table) => Ok(from_table(table.get_ref(), 1, &lines)?),
        Err(error) => {
            let line = error.span().map_or(1, |span| lines.of(span.start));
            Err(Mistake { line, text: format!("not TOML: {}", error.message().replace('\n', " ")) })
        }
    }
}

/// Where lines begin, to turn byte offsets into line numbers.
struct Lines(Vec<usize>);

impl Lines {
    fn new(text: &str) -> Self {
        Self(std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect())
    }

    fn of(&self, offset: usize) -> usize {
        self.0.partition_point(|&start| start <= offset)
    }
}

fn from_table(table: &DeTable<'_>, line: usize, lines: &Lines) -> Result<Node, Mistake> {
    let mut entries = Vec::with_capacity(table.len());
    for (key, value) in table {
        // The key's line, not the value's: a table's span is its header's, which may come later.
        let mut node = from_value(value, lines)?;
        node.line = lines.of(key.span().start);
        entries.push((key.get_ref().to_string(), node));
    }
    entries.sort_by_key(|(_, node)| node.line);
    Ok(Node { value: Value::Table(entries), line })
}

fn from_value(value: &Spanned<DeValue<'_>>, lines: &Lines) -> Result<Node, Mistake> {
    let line = lines.of(value.span().start);
    let number = |text: &str, parsed: Option<f64>| {
        parsed
            .map(Value::Number)
            .ok_or_else(|| Mistake { line, text: format!("{text}: not a number that can be held") })
    };
    let value = match value.get_ref() {
        DeValue::String(text) => Value::Text(text.to_string()),
        DeValue::Boolean(flag) => Value::Flag(*flag),
        DeValue::Integer(integer) => {
            let parsed = i64::from_str_radix(integer.as_str(), integer.radix()).ok();
            // Scenes hold no integer above 2^53; one that is would silently change.
            number(integer.as_str(), parsed.filter(|i| i.unsigned_abs() <= 1 << 53).map(|i| i as f64))?
        }
        DeValue::Float(float) => number(float.as_str(), float.as_str().parse().ok())?,
        DeValue::Datetime(_) => return Err(Mistake { line, text: "dates are not used in scenes".to_owned() }),
        DeValue::Array(array) => {
            Value::List(array.iter().map(|element| from_value(element, lines)).collect::<Result<_, _>>()?)
        }
        DeValue::Table(table) => return from_table(table, line, lines),
    };
    Ok(Node { value, line })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_knows_its_line() {
        let tree = parse("a = 1\n\n[b]\nc = \"x\"\nd = [1,\n 2.5]\n[[e]]\nf = true\n[[e]]\ng = -3\n").unwrap();
        let line = |node: Option<&Node>| node.map(|n| n.line);
        assert_eq!(line(tree.get("a")), Some(1));
        assert_eq!(line(tree.get("b").and_then(|b| b.get("c"))), Some(4));
        assert_eq!(line(tree.get("b").and_then(|b| b.get("d")).and_then(|d| d.elements().get(1))), Some(6));
        assert_eq!(line(tree.get("e").and_then(|e| e.elements()[1].get("g"))), Some(10));
    }

    #[test]
    fn what_is_not_toml_has_a_line() {
        assert_eq!(parse("a = 1\nb = = 2\n").unwrap_err().line, 2);
        assert_eq!(parse("a = 1\n[b]\nc = 1\nc = 2\n").unwrap_err().line, 4);
        assert_eq!(parse("a = 9007199254740993\n").unwrap_err().line, 1);
    }

    #[test]
    fn overlays_merge_tables_and_replace_the_rest() {
        let base = parse("a = 1\n[t]\nx = 1\ny = [1, 2]\n").unwrap();
        let over = parse("[t]\ny = [3]\nz = 4\n").unwrap();
        let both = base.overlaid(&over);
        let t = both.get("t").unwrap();
        assert_eq!(t.get("x").and_then(Node::number), Some(1.0));
        assert_eq!(t.get("y").map(|y| y.elements().len()), Some(1));
        assert_eq!(t.get("z").and_then(Node::number), Some(4.0));
    }

    #[test]
    fn multiples_of_pi() {
        let tree = parse("a = \"32 pi\"\nb = \"pi\"\nc = \"32 p\"\n").unwrap();
        let number = |key| tree.get(key).and_then(Node::number);
        assert_eq!(
            (number("a"), number("b"), number("c")),
            (Some(32.0 * std::f64::consts::PI), Some(std::f64::consts::PI), None)
        );
    }
}
