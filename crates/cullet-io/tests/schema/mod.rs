//! Objects of extensions held against their schema in `docs/schema`.

use serde_json::Value;

/// The schema of an extension.
pub(crate) fn of(extension: &str) -> Value {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/schema");
    let text = std::fs::read_to_string(format!("{folder}/{extension}.schema.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

/// Where a value is not as the schema wants it: as much of JSON Schema as that file uses.
pub(crate) fn held(schema: &Value, value: &Value, at: &str) -> Vec<String> {
    fn judge(root: &Value, schema: &Value, value: &Value, at: &str, out: &mut Vec<String>) {
        for (key, rule) in schema.as_object().unwrap() {
            let mut wrong = |what: &str| out.push(format!("{at}: {what} {rule}"));
            let count = value.as_array().map(Vec::len);
            match key.as_str() {
                "$ref" => {
                    let path = rule.as_str().unwrap().strip_prefix('#').unwrap();
                    judge(root, root.pointer(path).unwrap(), value, at, out);
                }
                "type" => {
                    let fits = match rule.as_str().unwrap() {
                        "object" => value.is_object(),
                        "array" => value.is_array(),
                        "string" => value.is_string(),
                        "number" => value.is_number(),
                        "integer" => value.is_u64() || value.is_i64(),
                        "boolean" => value.is_boolean(),
                        other => panic!("type {other}"),
                    };
                    if !fits {
                        wrong("is not of type");
                    }
                }
                "minItems" if count.is_some_and(|c| (c as u64) < rule.as_u64().unwrap()) => {
                    wrong("has fewer than");
                }
                "maxItems" if count.is_some_and(|c| (c as u64) > rule.as_u64().unwrap()) => {
                    wrong("has more than");
                }
                "enum" if !rule.as_array().unwrap().contains(value) => wrong("is none of"),
                "minimum" if value.as_f64().is_some_and(|v| v < rule.as_f64().unwrap()) => {
                    wrong("is below");
                }
                "required" => {
                    for name in rule.as_array().unwrap() {
                        if value.get(name.as_str().unwrap()).is_none() {
                            out.push(format!("{at}: lacks {name}"));
                        }
                    }
                }
                "properties" => {
                    for (name, member) in value.as_object().into_iter().flatten() {
                        match rule.get(name) {
                            Some(rule) => judge(root, rule, member, &format!("{at}/{name}"), out),
                            None => out.push(format!("{at}: {name} is unknown")),
                        }
                    }
                }
                "items" => {
                    for (i, item) in value.as_array().into_iter().flatten().enumerate() {
                        judge(root, rule, item, &format!("{at}/{i}"), out);
                    }
                }
                "oneOf" => {
                    let fits = |rule: &&Value| {
                        let mut inner = Vec::new();
                        judge(root, rule, value, at, &mut inner);
                        inner.is_empty()
                    };
                    if rule.as_array().unwrap().iter().filter(fits).count() != 1 {
                        wrong("is not one of");
                    }
                }
                "$schema" | "$id" | "$defs" | "title" | "description" | "default" | "minItems"
                | "maxItems" | "minimum" | "enum" => {}
                other => panic!("the schema has {other}, which is not judged here"),
            }
        }
    }
    let mut out = Vec::new();
    judge(schema, schema, value, at, &mut out);
    out
}
