//! A scene's tree against the schema: every mistake with line, key and what is allowed.

use super::mistake::Mistake;
use super::schema::{Field, Kind, Need, SCENE};
use super::tree::{Node, Value};

/// All mistakes of a whole scene (no `case`, no `quick` in it any more).
pub fn check(tree: &Node) -> Vec<Mistake> {
    let mut checker = Checker { dimension: None, mistakes: Vec::new() };
    checker.dimension =
        tree.get("dimension").and_then(Node::number).filter(|d| [1.0, 2.0, 3.0].contains(d)).map(|d| d as usize);
    checker.table("", tree, SCENE);
    checker.mistakes
}

struct Checker {
    dimension: Option<usize>,
    mistakes: Vec<Mistake>,
}

impl Checker {
    fn wrong(&mut self, line: usize, text: String) {
        self.mistakes.push(Mistake { line, text });
    }

    fn table(&mut self, path: &str, table: &Node, fields: &[Field]) {
        if !matches!(table.value, Value::Table(_)) {
            return self
                .wrong(table.line, format!("{} = {}: must be a table", path.trim_end_matches('.'), table.shown()));
        }
        let used = |field: &&Field| {
            field.when.is_none_or(|(key, values)| match table.get(key).map(|node| &node.value) {
                Some(Value::Text(text)) => values.contains(&text.as_str()),
                // The deciding key is missing or wrong: that is one mistake, not one more for each key beside it.
                _ => true,
            })
        };
        let allowed = || fields.iter().filter(used).map(|field| field.key).collect::<Vec<_>>().join(", ");
        for (key, node) in table.entries() {
            let name = format!("{path}{key}");
            match fields.iter().find(|field| field.key == key) {
                None => self.wrong(node.line, format!("{name}: unknown key; allowed here: {}", allowed())),
                Some(field) if !used(&field) => {
                    let decided = field.when.map_or("", |(key, _)| key);
                    let value = table.get(decided).map(Node::shown).unwrap_or_default();
                    self.wrong(
                        node.line,
                        format!("{name}: not used with {path}{decided} = {value}; allowed here: {}", allowed()),
                    );
                }
                Some(field) => self.value(&name, node, field.kind),
            }
        }
        for field in fields.iter().filter(used) {
            if matches!(field.need, Need::Required) && table.get(field.key).is_none() {
                self.wrong(
                    table.line,
                    format!("{path}{}: missing; {}: {}", field.key, super::schema::words(field.kind), field.doc),
                );
            }
        }
    }

    fn value(&mut self, name: &str, node: &Node, kind: Kind) {
        let shown = format!("{name} = {}", node.shown());
        let whole = |node: &Node, low: u64, high: u64| match node.value {
            Value::Number(number) => number.fract() == 0.0 && number >= low as f64 && number <= high as f64,
            _ => false,
        };
        let problem = match kind {
            Kind::Number(range) => match node.number() {
                Some(number) if range.holds(number) => None,
                Some(_) => Some(range.words()),
                None => Some("must be a number, or text like \"8 pi\"".to_owned()),
            },
            Kind::Count(low, high) => {
                (!whole(node, low, high)).then(|| format!("must be a whole number from {low} to {high}"))
            }
            Kind::Counts(count, low, high) => {
                let fits = node.elements().len() == count && node.elements().iter().all(|node| whole(node, low, high));
                (!fits).then(|| format!("must be {count} whole numbers from {low} to {high}"))
            }
            Kind::Text => (!matches!(node.value, Value::Text(_))).then(|| "must be text".to_owned()),
            Kind::Flag => (!matches!(node.value, Value::Flag(_))).then(|| "must be true or false".to_owned()),
            Kind::Choice(values) => {
                let fits = matches!(&node.value, Value::Text(text) if values.contains(&text.as_str()));
                (!fits).then(|| format!("must be one of {}", values.join(", ")))
            }
            Kind::Choices(values) => {
                let one = |node: &Node| matches!(&node.value, Value::Text(text) if values.contains(&text.as_str()));
                let fits = matches!(node.value, Value::List(_)) && node.elements().iter().all(one);
                (!fits).then(|| format!("must be a list of some of {}", values.join(", ")))
            }
            Kind::Numbers(range) => match &node.value {
                Value::List(elements) => self.numbers(name, elements, range),
                _ => Some("must be a list of numbers".to_owned()),
            },
            Kind::Vector(range) => match (&node.value, self.dimension) {
                (Value::List(elements), Some(d)) if elements.len() != d => {
                    Some(format!("must hold {d} numbers, one for each dimension"))
                }
                (Value::List(elements), _) => self.numbers(name, elements, range),
                _ => Some("must be a list of numbers, one for each dimension".to_owned()),
            },
            Kind::Pair(range) => match &node.value {
                Value::List(elements) if elements.len() == 2 => self.numbers(name, elements, range),
                _ => Some("must be a list of two numbers".to_owned()),
            },
            Kind::Points => {
                let d = self.dimension;
                let point = |node: &Node| {
                    d.is_none_or(|d| node.elements().len() == d)
                        && node.elements().iter().all(|x| x.number().is_some_and(f64::is_finite))
                };
                let fits = !node.elements().is_empty() && node.elements().iter().all(point);
                (!fits)
                    .then(|| "must be a list of points, each a list of one finite number for each dimension".to_owned())
            }
            Kind::Interval => match node.elements() {
                [low, high] => match (low.number(), high.number()) {
                    (Some(low), Some(high)) if low < high && low.is_finite() && high.is_finite() => None,
                    _ => Some("must be [low, high] with low below high".to_owned()),
                },
                _ => Some("must be [low, high] with low below high".to_owned()),
            },
            Kind::Table(fields) => {
                self.table(&format!("{name}."), node, fields);
                None
            }
            Kind::Tables(fields) => match &node.value {
                Value::List(elements) if elements.is_empty() => Some("must hold at least one table".to_owned()),
                Value::List(elements) => {
                    for (index, element) in elements.iter().enumerate() {
                        self.table(&format!("{name}[{index}]."), element, fields);
                    }
                    None
                }
                _ => Some(format!("must be a list of tables: [[{name}]]")),
            },
            // Overlays are taken out before a scene is checked.
            Kind::Overlay | Kind::Overlays => Some("cases and quick sizes don't nest".to_owned()),
        };
        if let Some(problem) = problem {
            self.wrong(node.line, format!("{shown}: {problem}"));
        }
    }

    fn numbers(&mut self, name: &str, elements: &[Node], range: super::schema::Range) -> Option<String> {
        for (index, element) in elements.iter().enumerate() {
            if !element.number().is_some_and(|number| range.holds(number)) {
                self.wrong(element.line, format!("{name}[{index}] = {}: {}", element.shown(), range.words()));
            }
        }
        elements.is_empty().then(|| "must hold at least one number".to_owned())
    }
}
