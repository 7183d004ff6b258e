//! What the guide's plugin uses of serde_json: text to values, and their members.
use std::{collections::BTreeMap, ops::Index};

pub enum Value {
    Null,
    Number(f64),
    Text(String),
    Array(Vec<Value>),
    Object(BTreeMap<String, Value>),
}

static NULL: Value = Value::Null;

impl Value {
    pub fn as_array(&self) -> Option<&Vec<Value>> {
        match self {
            Value::Array(values) => Some(values),
            _ => None,
        }
    }
    pub fn as_f64(&self) -> Option<f64> {
        match self {
            Value::Number(value) => Some(*value),
            _ => None,
        }
    }
    pub fn as_str(&self) -> Option<&str> {
        match self {
            Value::Text(text) => Some(text),
            _ => None,
        }
    }
}
impl Index<&str> for Value {
    type Output = Value;
    fn index(&self, key: &str) -> &Value {
        match self {
            Value::Object(members) => members.get(key).unwrap_or(&NULL),
            _ => &NULL,
        }
    }
}
impl Index<usize> for Value {
    type Output = Value;
    fn index(&self, at: usize) -> &Value {
        self.as_array().and_then(|values| values.get(at)).unwrap_or(&NULL)
    }
}
impl PartialEq<&str> for Value {
    fn eq(&self, other: &&str) -> bool {
        self.as_str() == Some(*other)
    }
}
impl PartialEq<str> for Value {
    fn eq(&self, other: &str) -> bool {
        self.as_str() == Some(other)
    }
}

pub fn from_str(text: &str) -> Result<Value, String> {
    let mut rest = text.trim();
    let value = read(&mut rest)?;
    if rest.trim().is_empty() { Ok(value) } else { Err("more than a value".to_string()) }
}

/// Reads JSON of lightcook: no escapes but those of quotation marks and backslashes.
fn read(rest: &mut &str) -> Result<Value, String> {
    *rest = rest.trim_start();
    if take(rest, "{") || rest.starts_with('[') {
        let is_array = take(rest, "[");
        let (mut values, mut members) = (Vec::new(), BTreeMap::new());
        let end = if is_array { "]" } else { "}" };
        while !take(rest, end) {
            let key = if is_array { String::new() } else { text_of(read(rest)?)? };
            if !is_array && !take(rest, ":") {
                return Err("no colon".to_string());
            }
            let value = read(rest)?;
            if is_array {
                values.push(value);
            } else {
                members.insert(key, value);
            }
            if !take(rest, ",") && !rest.trim_start().starts_with(end) {
                return Err("no comma".to_string());
            }
        }
        return Ok(if is_array { Value::Array(values) } else { Value::Object(members) });
    }
    if take(rest, "\"") {
        let (mut text, mut characters) = (String::new(), rest.char_indices());
        while let Some((at, character)) = characters.next() {
            match character {
                '"' => {
                    *rest = &rest[at + 1..];
                    return Ok(Value::Text(text));
                }
                '\\' => text.extend(characters.next().map(|(_, each)| each)),
                _ => text.push(character),
            }
        }
        return Err("no end of a text".to_string());
    }
    let end = rest.find(|c: char| c == ',' || c == ']' || c == '}' || c.is_whitespace()).unwrap_or(rest.len());
    let (word, after) = rest.split_at(end);
    *rest = after;
    Ok(word.parse().map(Value::Number).unwrap_or(Value::Null))
}

fn take(rest: &mut &str, word: &str) -> bool {
    let trimmed = rest.trim_start();
    let is_there = trimmed.starts_with(word);
    if is_there {
        *rest = &trimmed[word.len()..];
    }
    is_there
}

fn text_of(value: Value) -> Result<String, String> {
    match value {
        Value::Text(text) => Ok(text),
        _ => Err("no key".to_string()),
    }
}
