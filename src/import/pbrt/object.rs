//! Parameters, and what a directive describes with them.

use super::super::{Error, Location, Warnings};
use super::colours::ColourSpace;
use super::tokens::{Token, Tokens};
use glam::{DVec2, DVec3};
use std::cell::Cell;
use std::rc::Rc;

/// A parameter: `"float radius" 1`.
#[derive(Debug)]
pub(super) struct Parameter {
    /// "float".
    pub kind: String,
    /// "radius".
    pub name: String,
    pub values: Values,
    line: u32,
    used: Cell<bool>,
}

#[derive(Debug, PartialEq)]
pub(super) enum Values {
    Numbers(Vec<f64>),
    Texts(Vec<String>),
    Truths(Vec<bool>),
}

/// The parameters that follow, and how many tokens they have.
pub(super) fn parameters(tokens: &mut Tokens<'_>) -> Result<Vec<Parameter>, String> {
    let mut list = Vec::new();
    while let Some(Token::Text(_)) = tokens.peek()? {
        let Some(Token::Text(declaration)) = tokens.next()? else { break };
        let line = tokens.line();
        let mut words = declaration.split_whitespace();
        let (Some(kind), Some(name), None) = (words.next(), words.next(), words.next()) else {
            return Err(format!("\"{declaration}\" is not a type and a name"));
        };
        let values = values(kind, tokens).map_err(|reason| format!("{declaration}: {reason}"))?;
        list.push(Parameter {
            kind: kind.to_owned(),
            name: name.to_owned(),
            values,
            line,
            used: Cell::new(false),
        });
    }
    Ok(list)
}

/// One value, or several in brackets, all of one sort.
fn values(kind: &str, tokens: &mut Tokens<'_>) -> Result<Values, String> {
    let (mut numbers, mut texts, mut truths) = (Vec::new(), Vec::new(), Vec::new());
    let is_list = tokens.peek()? == Some(Token::Open);
    if is_list {
        tokens.next()?;
    }
    loop {
        match tokens.next()? {
            Some(Token::Close) if is_list => break,
            Some(Token::Word("true")) => truths.push(true),
            Some(Token::Word("false")) => truths.push(false),
            Some(Token::Text(text)) if kind == "bool" => match &*text {
                "true" => truths.push(true),
                "false" => truths.push(false),
                _ => return Err(format!("\"{text}\" is not true or false")),
            },
            Some(Token::Word(word)) => numbers.push(number(word)?),
            Some(Token::Text(text)) => texts.push(text.into_owned()),
            Some(Token::Open | Token::Close) => return Err("a bracket is out of place".to_owned()),
            None => return Err("the file ends in its values".to_owned()),
        }
        if !is_list {
            break;
        }
    }
    match (numbers.is_empty(), texts.is_empty(), truths.is_empty()) {
        (_, true, true) => Ok(Values::Numbers(numbers)),
        (true, false, true) => Ok(Values::Texts(texts)),
        (true, true, false) => Ok(Values::Truths(truths)),
        _ => Err("its values are of several sorts".to_owned()),
    }
}

/// A finite number.
pub(super) fn number(word: &str) -> Result<f64, String> {
    let value = word.parse::<f64>().ok().filter(|value| value.is_finite());
    value.ok_or_else(|| format!("\"{word}\" is not a finite number"))
}

/// What a directive describes.
#[derive(Debug, Default)]
pub(super) struct Object {
    /// The type: "trianglemesh".
    pub kind: String,
    pub location: Location,
    /// The colour space that its colours are in.
    pub colours: ColourSpace,
    pub parameters: Vec<Parameter>,
    /// What `Attribute` says of all objects of its sort; its own parameters precede.
    pub defaults: Rc<Vec<Rc<Parameter>>>,
}

impl Object {
    /// The parameter of a name. It counts as read.
    pub fn get(&self, name: &str) -> Option<&Parameter> {
        let defaults = self.defaults.iter().map(Rc::as_ref);
        let found = self.parameters.iter().chain(defaults).find(|p| p.name == name)?;
        found.used.set(true);
        Some(found)
    }

    /// Warns of parameters that nobody has asked for.
    pub fn finish(&self, warnings: &mut Warnings) -> Result<(), Error> {
        for parameter in self.parameters.iter().filter(|parameter| !parameter.used.get()) {
            let Parameter { name, line, .. } = parameter;
            let reason =
                format!("the parameter {name} (line {line}) is not supported here and left out");
            warnings.warn(self.location.clone(), reason)?;
        }
        Ok(())
    }

    /// Takes note of parameters that change nothing in this crate.
    pub fn ignore(&self, names: &[&str]) {
        for name in names {
            let _ = self.get(name);
        }
    }

    pub fn error(&self, reason: impl Into<String>) -> Error {
        Error::new(self.location.clone(), reason)
    }

    /// An error of what asks for more than a limit admits.
    pub fn limit(&self, reason: impl Into<String>) -> Error {
        Error::limit(self.location.clone(), reason)
    }

    pub fn caused(&self, source: impl std::error::Error + Send + Sync + 'static) -> Error {
        Error::caused(self.location.clone(), source)
    }

    pub fn numbers(&self, name: &str) -> Result<Option<&[f64]>, Error> {
        match self.get(name).map(|parameter| &parameter.values) {
            None => Ok(None),
            Some(Values::Numbers(values)) => Ok(Some(values)),
            Some(_) => Err(self.error(format!("{name} must have numbers"))),
        }
    }

    /// A single number.
    pub fn number(&self, name: &str) -> Result<Option<f64>, Error> {
        match self.numbers(name)? {
            None => Ok(None),
            Some([value]) => Ok(Some(*value)),
            Some(_) => Err(self.error(format!("{name} must be one number"))),
        }
    }

    pub fn number_or(&self, name: &str, default: f64) -> Result<f64, Error> {
        Ok(self.number(name)?.unwrap_or(default))
    }

    /// A number that is counted with; what is beyond the range is its end.
    pub fn count(&self, name: &str) -> Result<Option<u32>, Error> {
        Ok(self.number(name)?.map(|value| value as u32))
    }

    pub fn text(&self, name: &str) -> Result<Option<&str>, Error> {
        match self.get(name).map(|parameter| &parameter.values) {
            None => Ok(None),
            Some(Values::Texts(values)) if values.len() == 1 => Ok(Some(&values[0])),
            Some(_) => Err(self.error(format!("{name} must be one text"))),
        }
    }

    pub fn truth(&self, name: &str) -> Result<Option<bool>, Error> {
        match self.get(name).map(|parameter| &parameter.values) {
            None => Ok(None),
            Some(Values::Truths(values)) if values.len() == 1 => Ok(Some(values[0])),
            Some(_) => Err(self.error(format!("{name} must be true or false"))),
        }
    }

    pub fn points(&self, name: &str) -> Result<Option<Vec<DVec3>>, Error> {
        Ok(self.tuples(name)?.map(|tuples| tuples.iter().copied().map(DVec3::from_array).collect()))
    }

    /// A single point or vector.
    pub fn point(&self, name: &str) -> Result<Option<DVec3>, Error> {
        match self.tuples::<3>(name)? {
            None => Ok(None),
            Some([value]) => Ok(Some(DVec3::from_array(*value))),
            Some(_) => Err(self.error(format!("{name} must be three numbers"))),
        }
    }

    pub fn uvs(&self, name: &str) -> Result<Option<Vec<DVec2>>, Error> {
        Ok(self.tuples(name)?.map(|tuples| tuples.iter().copied().map(DVec2::from_array).collect()))
    }

    /// Numbers in groups of N.
    fn tuples<const N: usize>(&self, name: &str) -> Result<Option<&[[f64; N]]>, Error> {
        let Some(numbers) = self.numbers(name)? else { return Ok(None) };
        match numbers.as_chunks::<N>() {
            (tuples, []) => Ok(Some(tuples)),
            _ => Err(self.error(format!("{name} has a number of values that {N} does not divide"))),
        }
    }

    /// Indices of vertices.
    pub fn indices(&self, name: &str) -> Result<Option<Vec<u32>>, Error> {
        let Some(numbers) = self.numbers(name)? else { return Ok(None) };
        let index = |value: &f64| {
            let index = *value as u32;
            (f64::from(index) == *value).then_some(index)
        };
        let indices = numbers.iter().map(index).collect::<Option<Vec<_>>>();
        indices.map(Some).ok_or_else(|| self.error(format!("{name} must be whole numbers")))
    }
}
