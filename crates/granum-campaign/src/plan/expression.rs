//! Expressions of variables and conditions on them: `0.5 * friction`, `rolling_friction < friction`, `pressure <= 200 kPa`.

use granum_io::safe_text::quoted;
use granum_simd::{exp, power};

use super::units::any_quantity;

/// Deepest nesting of an expression.
const DEEPEST: usize = 64;
/// Most numbers, names, operators and functions of an expression or of a side of a condition.
const MOST_PARTS: usize = 1000;

/// An expression of named numbers: `+ - * / ^`, parentheses, `min`, `max`, `abs`, `sqrt` and `exp`. A number may have a unit
/// (`50 kPa`); names stand for values in SI units. The same expression gives the same bits on every machine. An expression has at most 1000
/// parts (numbers, names, operators and functions) and is nested at most 64 times.
///
/// ```
/// use granum_campaign::plan::Expression;
///
/// let expression = Expression::parse("min(0.5 * friction, 0.2)")?;
/// assert_eq!(expression.names().collect::<Vec<_>>(), ["friction"]);
/// assert_eq!(expression.value(&|_| Some(0.3)), Ok(0.15));
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Expression {
    text: String,
    root: Node,
}

#[derive(Clone, Debug, PartialEq)]
enum Node {
    Number(f64),
    Name(String),
    Negative(Box<Node>),
    Operation(Operator, Box<[Node; 2]>),
    Call(Function, Vec<Node>),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Operator {
    Plus,
    Minus,
    Times,
    Over,
    Power,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Function {
    Min,
    Max,
    Abs,
    Root,
    Exponential,
}

/// The functions with their names.
const FUNCTIONS: [(&str, Function); 5] = [
    ("min", Function::Min),
    ("max", Function::Max),
    ("abs", Function::Abs),
    ("sqrt", Function::Root),
    ("exp", Function::Exponential),
];

/// How two numbers are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Comparison {
    Less,
    AtMost,
    Greater,
    AtLeast,
}

/// The comparisons with their signs, the longer ones first.
const COMPARISONS: [(&str, Comparison); 4] = [
    ("<=", Comparison::AtMost),
    (">=", Comparison::AtLeast),
    ("<", Comparison::Less),
    (">", Comparison::Greater),
];

/// A comparison of two expressions, `rolling_friction < friction`.
///
/// ```
/// use granum_campaign::plan::Condition;
///
/// let condition = Condition::parse("pressure <= 200 kPa")?;
/// assert_eq!(condition.holds(&|_| Some(1e5)), Ok(true));
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    text: String,
    sides: [Expression; 2],
    comparison: Comparison,
}

impl Expression {
    /// Reads an expression.
    ///
    /// # Errors
    /// A sentence that says what is wrong and where.
    pub fn parse(text: &str) -> Result<Expression, String> {
        let mut reader = Reader::new(text);
        let root = reader.sum()?;
        reader.end()?;
        Ok(Expression { text: text.trim().to_string(), root })
    }

    /// The text that was read.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The names that occur in it, in their order, each as often as it occurs.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        let mut found = Vec::new();
        self.root.names(&mut found);
        found.into_iter()
    }

    /// Its value, where `of` gives the value of a name.
    ///
    /// # Errors
    /// A sentence if a name has no value or the result is no finite number.
    pub fn value(&self, of: &dyn Fn(&str) -> Option<f64>) -> Result<f64, String> {
        let value = self.root.value(of)?;
        if value.is_finite() {
            return Ok(value);
        }
        Err(format!("{} is no finite number", quoted(&self.text)))
    }
}

impl Condition {
    /// Reads a condition.
    ///
    /// # Errors
    /// A sentence that says what is wrong and where.
    pub fn parse(text: &str) -> Result<Condition, String> {
        let mut reader = Reader::new(text);
        let left = reader.sum()?;
        let middle = reader.at;
        let Some(comparison) = reader.comparison() else {
            return Err(format!(
                "\"{}\": <, <=, > or >= is needed between two expressions",
                quoted(text.trim())
            ));
        };
        let after = reader.at;
        reader.parts = 0;
        let right = reader.sum()?;
        reader.end()?;
        let side = |part: &str, root| Expression { text: part.trim().to_string(), root };
        let sides = [side(&text[..middle], left), side(&text[after..], right)];
        Ok(Condition { text: text.trim().to_string(), sides, comparison })
    }

    /// The text that was read.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The names that occur in it.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.sides.iter().flat_map(Expression::names)
    }

    /// True if it holds, where `of` gives the value of a name.
    ///
    /// # Errors
    /// As [`Expression::value`].
    pub fn holds(&self, of: &dyn Fn(&str) -> Option<f64>) -> Result<bool, String> {
        let [left, right] = [self.sides[0].value(of)?, self.sides[1].value(of)?];
        Ok(match self.comparison {
            Comparison::Less => left < right,
            Comparison::AtMost => left <= right,
            Comparison::Greater => left > right,
            Comparison::AtLeast => left >= right,
        })
    }
}

impl Node {
    fn names<'a>(&'a self, found: &mut Vec<&'a str>) {
        match self {
            Node::Number(_) => {}
            Node::Name(name) => found.push(name),
            Node::Negative(inner) => inner.names(found),
            Node::Operation(_, sides) => sides.iter().for_each(|side| side.names(found)),
            Node::Call(_, arguments) => arguments.iter().for_each(|argument| argument.names(found)),
        }
    }

    fn value(&self, of: &dyn Fn(&str) -> Option<f64>) -> Result<f64, String> {
        Ok(match self {
            Node::Number(number) => *number,
            Node::Name(name) => of(name).ok_or_else(|| format!("{name} has no value that is a number"))?,
            Node::Negative(inner) => -inner.value(of)?,
            Node::Operation(operator, sides) => operator.apply(sides[0].value(of)?, sides[1].value(of)?),
            Node::Call(function, arguments) => {
                let values: Vec<f64> =
                    arguments.iter().map(|argument| argument.value(of)).collect::<Result<_, _>>()?;
                function.apply(&values)
            }
        })
    }
}

impl Operator {
    fn apply(self, a: f64, b: f64) -> f64 {
        match self {
            Operator::Plus => a + b,
            Operator::Minus => a - b,
            Operator::Times => a * b,
            Operator::Over => a / b,
            Operator::Power => raised(a, b),
        }
    }
}

/// A number to a power: by products where the power is whole, otherwise by the function that has the same bits everywhere.
fn raised(base: f64, exponent: f64) -> f64 {
    if exponent.fract() == 0.0 && exponent.abs() <= 64.0 {
        let product = (0..exponent.abs() as u32).fold(1.0, |product, _| product * base);
        return if exponent < 0.0 { 1.0 / product } else { product };
    }
    if base > 0.0 { power(base, exponent) } else { f64::NAN }
}

impl Function {
    fn apply(self, values: &[f64]) -> f64 {
        let first = values.first().copied().unwrap_or(f64::NAN);
        match self {
            Function::Min => values.iter().copied().fold(f64::INFINITY, f64::min),
            Function::Max => values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            Function::Abs => first.abs(),
            Function::Root => first.sqrt(),
            Function::Exponential => exp(first),
        }
    }

    fn takes_several(self) -> bool {
        matches!(self, Function::Min | Function::Max)
    }
}

/// Reads an expression from left to right.
struct Reader<'a> {
    text: &'a str,
    /// The next byte.
    at: usize,
    depth: usize,
    /// Number of parts so far.
    parts: usize,
}

impl<'a> Reader<'a> {
    fn new(text: &'a str) -> Reader<'a> {
        Reader { text, at: 0, depth: 0, parts: 0 }
    }

    /// Counts a number, a name, an operator or a function.
    fn count(&mut self) -> Result<(), String> {
        self.parts += 1;
        if self.parts <= MOST_PARTS {
            return Ok(());
        }
        Err(format!(
            "\"{}\" has more than {MOST_PARTS} numbers, names, operators and functions; divide it among several variables",
            quoted(self.text.trim())
        ))
    }

    fn rest(&mut self) -> &'a str {
        let rest = self.text[self.at..].trim_start();
        self.at = self.text.len() - rest.len();
        rest
    }

    fn wrong(&mut self, needed: &str) -> String {
        let rest = self.rest();
        let shown: String = rest.chars().take(20).collect();
        match rest.is_empty() {
            true => format!("\"{}\": {needed} is needed at the end", quoted(self.text.trim())),
            false => format!("\"{}\": {needed} is needed where {shown:?} stands", quoted(self.text.trim())),
        }
    }

    fn end(&mut self) -> Result<(), String> {
        if self.rest().is_empty() { Ok(()) } else { Err(self.wrong("an operator or the end")) }
    }

    fn takes(&mut self, sign: &str) -> bool {
        let found = self.rest().starts_with(sign);
        self.at += if found { sign.len() } else { 0 };
        found
    }

    fn comparison(&mut self) -> Option<Comparison> {
        COMPARISONS.iter().find(|(sign, _)| self.takes(sign)).map(|(_, comparison)| *comparison)
    }

    fn sum(&mut self) -> Result<Node, String> {
        let mut left = self.product()?;
        loop {
            let operator = match self.rest().as_bytes().first() {
                Some(b'+') => Operator::Plus,
                Some(b'-') => Operator::Minus,
                _ => return Ok(left),
            };
            self.at += 1;
            self.count()?;
            left = Node::Operation(operator, Box::new([left, self.product()?]));
        }
    }

    fn product(&mut self) -> Result<Node, String> {
        let mut left = self.signed()?;
        loop {
            let operator = match self.rest().as_bytes().first() {
                Some(b'*') => Operator::Times,
                Some(b'/') => Operator::Over,
                _ => return Ok(left),
            };
            self.at += 1;
            self.count()?;
            left = Node::Operation(operator, Box::new([left, self.signed()?]));
        }
    }

    fn signed(&mut self) -> Result<Node, String> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(format!("it is nested more than {DEEPEST} times"));
        }
        let node = if self.takes("-") { Node::Negative(Box::new(self.signed()?)) } else { self.raised()? };
        self.depth -= 1;
        Ok(node)
    }

    fn raised(&mut self) -> Result<Node, String> {
        let base = self.single()?;
        if self.takes("^") {
            return Ok(Node::Operation(Operator::Power, Box::new([base, self.signed()?])));
        }
        Ok(base)
    }

    /// A number, a name, a function or an expression in parentheses.
    fn single(&mut self) -> Result<Node, String> {
        self.count()?;
        if self.takes("(") {
            let inner = self.sum()?;
            return if self.takes(")") { Ok(inner) } else { Err(self.wrong("\")\"")) };
        }
        let rest = self.rest();
        match rest.chars().next() {
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_alphabetic() || c == '_' => {
                let name = word(rest);
                self.at += name.len();
                match FUNCTIONS.iter().find(|(known, _)| *known == name) {
                    Some((_, function)) if self.rest().starts_with('(') => self.call(*function),
                    _ => Ok(Node::Name(name.to_string())),
                }
            }
            _ => Err(self.wrong("a number, a name or \"(\"")),
        }
    }

    fn call(&mut self, function: Function) -> Result<Node, String> {
        self.at += 1;
        let mut arguments = vec![self.sum()?];
        while function.takes_several() && self.takes(",") {
            arguments.push(self.sum()?);
        }
        if self.takes(")") { Ok(Node::Call(function, arguments)) } else { Err(self.wrong("\")\"")) }
    }

    /// A number, with its unit where a word follows it.
    fn number(&mut self) -> Result<Node, String> {
        let rest = self.rest();
        let bytes = rest.as_bytes();
        let digits = |from: usize| {
            bytes[from..].iter().take_while(|byte| byte.is_ascii_digit() || **byte == b'.').count()
        };
        let mut length = digits(0);
        if matches!(bytes.get(length), Some(b'e' | b'E')) {
            let sign = usize::from(matches!(bytes.get(length + 1), Some(b'+' | b'-')));
            let exponent = digits(length + 1 + sign);
            length += if exponent > 0 { 1 + sign + exponent } else { 0 };
        }
        let number = &rest[..length];
        self.at += length;
        let unit = word(self.rest());
        let unit = if unit.is_empty() && self.rest().starts_with('%') { "%" } else { unit };
        if unit.is_empty() {
            return number
                .parse()
                .map(Node::Number)
                .map_err(|_| format!("\"{}\" is no number", quoted(number)));
        }
        self.at += unit.len();
        let quantity = format!("{number} {unit}");
        any_quantity(&quantity).map(Node::Number).ok_or_else(|| {
            format!("\"{}\" is no quantity; write * between a number and a name", quoted(&quantity))
        })
    }
}

/// The name at the beginning of a text: letters, digits, underscores and dots.
fn word(text: &str) -> &str {
    let begins = |c: char| c.is_alphabetic() || c == '_';
    if !text.starts_with(begins) {
        return "";
    }
    let is_in = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
    let end = text.find(|c| !is_in(c)).unwrap_or(text.len());
    &text[..end]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> f64 {
        let of = |name: &str| match name {
            "a" => Some(2.0),
            "grains.material.friction" => Some(0.3),
            _ => None,
        };
        Expression::parse(text).unwrap_or_else(|error| panic!("{error}")).value(&of).unwrap()
    }

    #[test]
    fn operators_bind_as_in_mathematics() {
        assert_eq!(value("1 + 2 * 3"), 7.0);
        assert_eq!(value("(1 + 2) * 3"), 9.0);
        assert_eq!(value("8 - 4 - 2"), 2.0);
        assert_eq!(value("8 / 4 / 2"), 1.0);
        assert_eq!(value("-2 ^ 2"), -4.0);
        assert_eq!(value("2 ^ -1"), 0.5);
        assert_eq!(value("2 ^ 3 ^ 2"), 512.0);
        assert_eq!(value("max(a, 3, min(7, 5)) - abs(-1) + sqrt(9)"), 7.0);
        assert_eq!(value("2e-1*a"), 0.4);
        assert_eq!(value("2 * grains.material.friction"), 0.6);
        assert!((value("a ^ 0.5") - 2f64.sqrt()).abs() < 1e-15);
        assert!((value("exp(1)") - std::f64::consts::E).abs() < 1e-15);
    }

    #[test]
    fn a_number_may_have_a_unit() {
        assert_eq!(value("50 kPa + 1e3"), 51e3);
        assert_eq!(value("20mm"), 0.02);
        assert_eq!(value("5 %"), 0.05);
    }

    /// Expressions that would take all of the stack or all of the time are refused, with a short message.
    #[test]
    fn what_is_too_long_is_refused_by_a_limit() {
        let error = |text: &str| {
            let error = Expression::parse(text).unwrap_err();
            assert!(error.len() < 400, "{}", error.len());
            error
        };
        let sum = |terms: usize| vec!["a"; terms].join("+");
        assert_eq!(value(&sum(500)), 1000.0);
        assert!(error(&sum(501)).contains("more than 1000 numbers, names, operators and functions"));
        assert!(error(&sum(30_000)).contains("more than 1000 numbers"));
        assert!(error(&format!("max({})", vec!["1"; 1001].join(","))).contains("more than 1000"));
        assert!(error(&vec!["2"; 100].join("^")).contains("nested more than 64 times"));
        assert!(
            error(&format!("{}1{}", "abs(".repeat(70), ")".repeat(70))).contains("nested more than 64 times")
        );
        assert!(error(&"9.".repeat(400)).contains("is no number"));
        let message = Condition::parse(&format!("{} < 1", sum(501))).unwrap_err();
        assert!(message.contains("more than 1000"), "{message}");
        assert!(Condition::parse(&format!("{0} < {0}", sum(500))).is_ok());
        assert!(!error("a \u{1b}[31m \u{202e}").contains(['\u{1b}', '\u{202e}']));
    }

    #[test]
    fn mistakes_are_told_with_their_place() {
        let error = |text: &str| Expression::parse(text).unwrap_err();
        assert_eq!(error("1 +"), "\"1 +\": a number, a name or \"(\" is needed at the end");
        assert_eq!(error("(a + 1"), "\"(a + 1\": \")\" is needed at the end");
        assert_eq!(error("a b"), "\"a b\": an operator or the end is needed where \"b\" stands");
        assert!(error("2 a").contains("write * between a number and a name"));
        assert!(error(&"(".repeat(100_000)).contains("nested more than"));
        assert!(error(&"-".repeat(100_000)).contains("nested more than"));
        assert_eq!(
            Expression::parse("b").unwrap().value(&|_| None).unwrap_err(),
            "b has no value that is a number"
        );
        assert_eq!(
            Expression::parse("1/0").unwrap().value(&|_| None).unwrap_err(),
            "1/0 is no finite number"
        );
        let error = |text: &str| Condition::parse(text).unwrap_err();
        assert!(error("a + 1").contains("<, <=, > or >= is needed"));
        assert!(error("a < 1 < 2").contains("an operator or the end is needed where \"< 2\" stands"));
    }

    #[test]
    fn conditions_compare() {
        let holds = |text: &str| Condition::parse(text).unwrap().holds(&|_| Some(0.5)).unwrap();
        assert!(holds("x < 0.6") && holds("x <= 0.5") && holds("x > 0.4") && holds("x >= 0.5"));
        assert!(!holds("x < 0.5") && !holds("2 * x > y + 0.5"));
        let condition = Condition::parse("a + b < c").unwrap();
        assert_eq!(condition.names().collect::<Vec<_>>(), ["a", "b", "c"]);
    }
}
