//! Tests of the OpenAPI document: every route in it, nothing else, and no drift from the committed copy.

use super::*;

fn parsed() -> Value {
    serde_json::from_str(&document()).unwrap()
}

/// Every `$ref` anywhere in a value.
fn references(value: &Value, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(object) => {
            for (key, value) in object {
                match value {
                    Value::String(target) if key == "$ref" => {
                        found.insert(target.clone());
                    }
                    _ => references(value, found),
                }
            }
        }
        Value::Array(items) => items.iter().for_each(|item| references(item, found)),
        _ => {}
    }
}

#[test]
fn it_is_one_document_whose_references_all_lead_somewhere_and_whose_schemas_are_all_used() {
    let document = parsed();
    assert_eq!(document["openapi"], "3.1.0");
    let mut found = BTreeSet::new();
    references(&document, &mut found);
    for target in &found {
        assert!(
            document.pointer(target.trim_start_matches('#')).is_some(),
            "{target} leads nowhere"
        );
    }
    for name in document["components"]["schemas"].as_object().unwrap().keys() {
        // What is sent over a WebSocket is said in words: OpenAPI has no place for it.
        let over_socket = ["ClientMessage", "VideoRequest"].contains(&name.as_str());
        let used = found.contains(&format!("{SCHEMAS}{name}")) || over_socket;
        assert!(used, "{name} is not used");
    }
}

#[test]
fn every_route_of_the_table_is_in_it_with_bodies_answers_and_errors() {
    let document = parsed();
    let mut operations = 0;
    for endpoint in endpoints::all() {
        let method = serde_json::to_value(&endpoint.method).unwrap();
        let operation = if endpoint.is_websocket {
            &document[WEBSOCKETS][endpoint.path]
        } else {
            &document["paths"][endpoint.path][method.as_str().unwrap()]
        };
        assert_eq!(operation["operationId"], endpoint.id, "{} {method}", endpoint.path);
        assert_eq!(
            operation.get("requestBody").is_some(),
            endpoint.body.is_some() || endpoint.file.is_some()
        );
        assert!(operation["responses"]["403"]["content"]["application/json"]["schema"]["$ref"].is_string());
        operations += usize::from(!endpoint.is_websocket);
    }
    let paths = document["paths"].as_object().unwrap();
    assert_eq!(
        paths
            .values()
            .map(|item| item.as_object().unwrap().len())
            .sum::<usize>(),
        operations
    );
}

#[test]
fn a_request_may_leave_out_what_an_answer_always_has() {
    let document = parsed();
    let schemas = &document["components"]["schemas"];
    let required = |name: &str| -> Vec<&str> {
        schemas[name]["required"]
            .as_array()
            .unwrap()
            .iter()
            .map(|field| field.as_str().unwrap())
            .collect()
    };
    assert_eq!(required("FormationRequestInput"), ["shape", "spacing_m"]);
    assert!(required("FormationRequest").contains(&"heading"));
    let body = &document["paths"]["/api/v1/formation"]["put"]["requestBody"]["content"]["application/json"]["schema"];
    assert_eq!(body["$ref"], "#/components/schemas/FormationRequestInput");
    assert_eq!(schemas["CommandBody"]["additionalProperties"], false);
}

#[test]
fn a_query_becomes_parameters() {
    let document = parsed();
    let parameters = document["paths"]["/api/v1/events"]["get"]["parameters"]
        .as_array()
        .unwrap()
        .clone();
    assert_eq!(parameters.len(), 1);
    assert_eq!(parameters[0]["name"], "after");
    assert_eq!(parameters[0]["in"], "query");
    assert_eq!(parameters[0]["schema"]["type"], "integer");
    let variable = &document["paths"]["/api/v1/vehicles/{id}"]["get"]["parameters"][0];
    assert_eq!(variable["in"], "path");
    assert_eq!(variable["required"], true);
}
