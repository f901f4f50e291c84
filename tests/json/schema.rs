//! As much of JSON Schema as `docs/messages.schema.json` uses. A word that is not known here is a mistake, so nothing in the schema
//! is passed over.

use serde_json::{Map, Value};

/// What is wrong with a value.
pub(crate) fn mistakes(value: &Value, schema: &Value) -> Vec<String> {
    let mut found = Vec::new();
    look(value, schema, schema, "message", &mut found);
    found
}

fn look(value: &Value, schema: &Value, root: &Value, path: &str, found: &mut Vec<String>) {
    let Some(schema) = schema.as_object() else { return found.push(format!("{path}: its schema is no object")) };
    for (word, rule) in schema {
        let is_fine = match word.as_str() {
            "$schema" | "$defs" | "title" | "description" => true,
            "$ref" => {
                let name = rule.as_str().and_then(|it| it.strip_prefix("#/$defs/")).unwrap();
                look(value, &root["$defs"][name], root, path, found);
                true
            }
            "type" => match rule {
                Value::Array(kinds) => kinds.iter().any(|it| is_kind(value, it)),
                kind => is_kind(value, kind),
            },
            "enum" => rule.as_array().unwrap().contains(value),
            // Only codes have one.
            "pattern" => {
                assert_eq!(rule, "^[EW][0-9]{4}$");
                value.as_str().is_none_or(|it| {
                    it.len() == 5 && it.starts_with(['E', 'W']) && it[1..].bytes().all(|it| it.is_ascii_digit())
                })
            }
            "minimum" => value.as_i64().is_none_or(|it| it >= rule.as_i64().unwrap()),
            "required" => {
                let names = rule.as_array().unwrap().iter().map(|it| it.as_str().unwrap());
                value.as_object().is_none_or(|it| names.into_iter().all(|name| it.contains_key(name)))
            }
            "additionalProperties" => {
                assert_eq!(rule, &Value::Bool(false));
                let known = schema["properties"].as_object().unwrap();
                value.as_object().is_none_or(|it| it.keys().all(|it| known.contains_key(it)))
            }
            "properties" => {
                properties(value, rule.as_object().unwrap(), root, path, found);
                true
            }
            "items" => {
                for (number, item) in value.as_array().into_iter().flatten().enumerate() {
                    look(item, rule, root, &format!("{path}[{number}]"), found);
                }
                true
            }
            _ => panic!("{word} is not known here"),
        };
        if !is_fine {
            found.push(format!("{path} breaks {word}: {rule}, being {value}"));
        }
    }
}

fn properties(value: &Value, rules: &Map<String, Value>, root: &Value, path: &str, found: &mut Vec<String>) {
    for (name, rule) in rules {
        if let Some(value) = value.get(name) {
            look(value, rule, root, &format!("{path}.{name}"), found);
        }
    }
}

fn is_kind(value: &Value, kind: &Value) -> bool {
    match kind.as_str().unwrap() {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "integer" => value.is_u64() || value.is_i64(),
        "null" => value.is_null(),
        other => panic!("{other} is not known here"),
    }
}
