//! A JSON schema in the few words that every viewer of recordings knows: each place in a message has one type, spelt out where it stands. Lichtblick reads
//! neither references nor alternatives, and shows nothing of a topic whose schema has any.
//!
//! Must never do: say less of a message than that it is an object.

use serde_json::{Map, Value, json};

/// The same schema without references, alternatives and types that may be absent. What differs by its kind has all fields of all kinds; what holds itself is an
/// object there.
pub(crate) fn plain(schema: &Value) -> Value {
    Plain {
        definitions: schema["$defs"].as_object(),
    }
    .of(schema, &mut Vec::new())
}

struct Plain<'a> {
    definitions: Option<&'a Map<String, Value>>,
}

impl<'a> Plain<'a> {
    fn of(&self, schema: &'a Value, within: &mut Vec<&'a str>) -> Value {
        if let Some(name) = schema["$ref"].as_str().and_then(|path| path.rsplit('/').next()) {
            let definition = self.definitions.and_then(|all| all.get(name));
            let Some(definition) = definition.filter(|_| !within.contains(&name)) else {
                return object(Map::new());
            };
            within.push(name);
            let plain = self.of(definition, within);
            within.pop();
            return plain;
        }
        let alternatives = ["oneOf", "anyOf", "allOf"]
            .iter()
            .find_map(|word| schema[word].as_array());
        if let Some(alternatives) = alternatives {
            return self.any_of(schema, alternatives, within);
        }
        match kind(schema) {
            "object" => object(self.fields(schema, within)),
            "array" => {
                let items = schema.get("items").or_else(|| schema["prefixItems"].get(0));
                let items = items.map_or_else(|| object(Map::new()), |items| self.of(items, within));
                // A list of lists has no plain form.
                let items = if items["type"] == "array" {
                    object(Map::new())
                } else {
                    items
                };
                json!({"type": "array", "items": items})
            }
            simple => json!({"type": simple}),
        }
    }

    fn fields(&self, schema: &'a Value, within: &mut Vec<&'a str>) -> Map<String, Value> {
        let fields = schema["properties"].as_object().into_iter().flatten();
        fields
            .map(|(name, field)| (name.clone(), self.of(field, within)))
            .collect()
    }

    fn any_of(&self, schema: &'a Value, alternatives: &'a [Value], within: &mut Vec<&'a str>) -> Value {
        let there = alternatives.iter().filter(|alternative| alternative["type"] != "null");
        let plain: Vec<Value> = there.map(|alternative| self.of(alternative, within)).collect();
        if plain.iter().any(|alternative| alternative["type"] == "object") {
            let mut fields = self.fields(schema, within);
            for alternative in plain {
                for (name, field) in alternative["properties"].as_object().into_iter().flatten() {
                    fields.entry(name.clone()).or_insert_with(|| field.clone());
                }
            }
            return object(fields);
        }
        plain.into_iter().next().unwrap_or_else(|| object(Map::new()))
    }
}

fn object(fields: Map<String, Value>) -> Value {
    json!({"type": "object", "properties": fields})
}

/// The one type that a schema without alternatives has; of several that which is not null.
fn kind(schema: &Value) -> &str {
    let told = match &schema["type"] {
        Value::Array(types) => types.iter().find(|kind| *kind != "null").and_then(Value::as_str),
        told => told.as_str(),
    };
    told.unwrap_or(match &schema["const"] {
        Value::Bool(_) => "boolean",
        Value::Number(_) => "number",
        Value::String(_) => "string",
        _ if schema["enum"].is_array() => "string",
        _ => "object",
    })
}

#[cfg(test)]
mod tests {
    use super::plain;
    use crate::Topic;
    use serde_json::{Value, json};
    use skein_domain::VehicleId;

    /// What Lichtblick's reader accepts of a schema (`parseJsonSchema`); the path of what it does not.
    fn unknown(schema: &Value, path: &str, out: &mut Vec<String>) {
        let kind = schema["type"].as_str().unwrap_or_default();
        let known = ["boolean", "string", "number", "integer", "object", "array"];
        let foreign = ["$ref", "oneOf", "anyOf", "allOf"]
            .iter()
            .any(|word| schema.get(word).is_some());
        if !known.contains(&kind) || foreign {
            out.push(format!("{path}: {schema}"));
        }
        for (name, field) in schema["properties"].as_object().into_iter().flatten() {
            unknown(field, &format!("{path}.{name}"), out);
        }
        if kind == "array" {
            if schema["items"]["type"] == "array" {
                out.push(format!("{path}: a list of lists"));
            }
            unknown(&schema["items"], &format!("{path}[]"), out);
        }
    }

    #[test]
    fn every_topic_is_told_in_words_that_viewers_know() {
        let vehicle = VehicleId(1);
        let topics = [
            Topic::Fleet,
            Topic::Events,
            Topic::Audit,
            Topic::Clock,
            Topic::Recorder,
            Topic::Gate,
        ];
        let more = [Topic::Peers, Topic::Failsafe, Topic::Formation, Topic::Leadership];
        let of_vehicles = [Topic::Telemetry(vehicle), Topic::Setpoint(vehicle)];
        for topic in topics.into_iter().chain(more).chain(of_vehicles) {
            let schema: Value = serde_json::from_slice(&topic.schema().data).expect("is JSON");
            let mut out = Vec::new();
            unknown(&schema, "", &mut out);
            assert!(out.is_empty(), "{topic}: {out:#?}");
        }
    }

    #[test]
    fn fields_can_be_found_by_name() {
        let schema: Value = serde_json::from_slice(&Topic::Telemetry(VehicleId(1)).schema().data).expect("is JSON");
        let north = &schema["properties"]["kinematics"]["properties"]["position"]["properties"]["north_m"];
        assert_eq!(north["type"], "number", "{schema:#}");
    }

    #[test]
    fn alternatives_become_one_object_and_what_holds_itself_ends() {
        let schema = json!({
            "type": "object",
            "properties": {
                "kind": {"oneOf": [
                    {"type": "object", "properties": {"kind": {"const": "a"}, "height_m": {"type": ["number", "null"]}}},
                    {"type": "object", "properties": {"kind": {"const": "b"}, "inner": {"$ref": "#/$defs/Inner"}}},
                ]},
                "pairs": {"type": "array", "items": {"type": "array", "items": {"type": "number"}}},
                "anything": true,
            },
            "$defs": {"Inner": {"type": "object", "properties": {"again": {"anyOf": [{"$ref": "#/$defs/Inner"}, {"type": "null"}]}}}},
        });
        let nothing = json!({"type": "object", "properties": {}});
        let wanted = json!({"type": "object", "properties": {
            "kind": {"type": "object", "properties": {
                "kind": {"type": "string"},
                "height_m": {"type": "number"},
                "inner": {"type": "object", "properties": {"again": nothing}},
            }},
            "pairs": {"type": "array", "items": nothing},
            "anything": nothing,
        }});
        assert_eq!(plain(&schema), wanted);
    }
}
