//! The OpenAPI 3.1 document, made from the table of routes and the types themselves.
//!
//! Types that are read and types that are written differ (a field with a default may be left out of a request, but is always in an
//! answer). Where one type is both and it matters, the one for requests has the suffix `Input`.

use crate::endpoints::{self, Endpoint};
use crate::protocol::{ClientMessage, ErrorBody, VideoRequest};
use schemars::generate::SchemaSettings;
use schemars::{Schema, SchemaGenerator};
use serde_json::{Map, Value};
use std::collections::{BTreeMap, BTreeSet};
use utoipa::openapi::path::{OperationBuilder, Parameter, ParameterBuilder, ParameterIn, PathsBuilder};
use utoipa::openapi::request_body::{RequestBody, RequestBodyBuilder};
use utoipa::openapi::{
    ContentBuilder, InfoBuilder, KnownFormat, LicenseBuilder, ObjectBuilder, OpenApiBuilder, PathItem, Ref, RefOr,
    Required, ResponseBuilder, Schema as ApiSchema, SchemaFormat, ServerBuilder, Type,
};

/// Where the schemas of the document stand.
const SCHEMAS: &str = "#/components/schemas/";
/// Where routes that become a WebSocket stand: a client that takes them for plain requests is only told to upgrade.
const WEBSOCKETS: &str = "x-websockets";
/// Errors that any route may give.
const ERRORS_OF_ALL: &[u16] = &[403];
/// Errors that any route with a body may give.
const ERRORS_OF_BODIES: &[u16] = &[400, 408, 409, 413, 415, 422];

/// The document as JSON text, the same at every call.
#[must_use]
pub fn document() -> String {
    let mut schemas = Schemas::new();
    let (mut paths, mut websockets) = (PathsBuilder::new(), Map::new());
    for endpoint in endpoints::all() {
        let (path, method, is_websocket) = (endpoint.path, endpoint.method.clone(), endpoint.is_websocket);
        let operation = operation(endpoint, &mut schemas);
        if is_websocket {
            let operation = serde_json::to_value(operation).unwrap_or_default();
            websockets.insert(path.to_owned(), operation);
        } else {
            paths = paths.path(path, PathItem::new(method, operation));
        }
    }
    schemas.answers.subschema_for::<ErrorBody>();
    schemas.requests.subschema_for::<ClientMessage>();
    schemas.requests.subschema_for::<VideoRequest>();
    let info = InfoBuilder::new()
        .title("Skein")
        .version(env!("CARGO_PKG_VERSION"))
        .description(Some("One node of a swarm: vehicles, commands, formations, events."))
        .license(Some(
            LicenseBuilder::new()
                .name("Apache-2.0")
                .identifier(Some("Apache-2.0"))
                .build(),
        ))
        .build();
    let document = OpenApiBuilder::new()
        .info(info)
        .servers(Some([ServerBuilder::new().url("/").build()]))
        .paths(paths)
        .build();
    let mut document = serde_json::to_value(document).unwrap_or_default();
    document[WEBSOCKETS] = Value::Object(websockets);
    schemas.put_into(&mut document);
    // Sorted, so that the text does not depend on how serde_json was built.
    serde_json::to_string_pretty(&sorted(document)).unwrap_or_default() + "\n"
}

/// Collects the schemas of what is read and of what is written.
struct Schemas {
    requests: SchemaGenerator,
    answers: SchemaGenerator,
}

impl Schemas {
    fn new() -> Self {
        let settings =
            SchemaSettings::draft2020_12().with(|settings| settings.definitions_path = "/components/schemas".into());
        Self {
            requests: settings.clone().for_deserialize().into_generator(),
            answers: settings.for_serialize().into_generator(),
        }
    }

    /// Puts all schemas into the document. Those for requests that differ from an answer's of the same name are renamed.
    fn put_into(mut self, document: &mut Value) {
        let mut requests = self.requests.take_definitions(true);
        let mut all = self.answers.take_definitions(true);
        let differing = differing(&requests, &all);
        for schema in requests.values_mut() {
            rename(schema, &differing);
        }
        if let Some(paths) = document.get_mut("paths").and_then(Value::as_object_mut) {
            for operation in paths
                .values_mut()
                .filter_map(Value::as_object_mut)
                .flat_map(|item| item.values_mut())
            {
                if let Some(body) = operation.get_mut("requestBody") {
                    rename(body, &differing);
                }
            }
        }
        for (name, schema) in requests {
            let name = if differing.contains(&name) {
                input_name(&name)
            } else {
                name
            };
            all.insert(name, schema);
        }
        document["components"]["schemas"] = Value::Object(all);
    }
}

fn input_name(name: &str) -> String {
    format!("{name}Input")
}

/// Names that mean different things in the two, by themselves or because they refer to one that does.
fn differing(requests: &Map<String, Value>, answers: &Map<String, Value>) -> BTreeSet<String> {
    let both = || requests.iter().filter(|(name, _)| answers.contains_key(*name));
    let mut differing: BTreeSet<String> = both()
        .filter(|(name, schema)| answers.get(*name) != Some(*schema))
        .map(|(name, _)| name.clone())
        .collect();
    loop {
        let more: Vec<String> = both()
            .filter(|(name, schema)| !differing.contains(*name) && refers_to(schema, &differing))
            .map(|(name, _)| name.clone())
            .collect();
        if more.is_empty() {
            return differing;
        }
        differing.extend(more);
    }
}

fn refers_to(schema: &Value, names: &BTreeSet<String>) -> bool {
    match schema {
        Value::Object(object) => object.iter().any(|(key, value)| match (key.as_str(), value) {
            ("$ref", Value::String(target)) => target.strip_prefix(SCHEMAS).is_some_and(|name| names.contains(name)),
            _ => refers_to(value, names),
        }),
        Value::Array(items) => items.iter().any(|item| refers_to(item, names)),
        _ => false,
    }
}

fn rename(schema: &mut Value, names: &BTreeSet<String>) {
    match schema {
        Value::Object(object) => {
            for (key, value) in object.iter_mut() {
                match value {
                    Value::String(target) if key == "$ref" => {
                        if let Some(name) = target.strip_prefix(SCHEMAS).filter(|name| names.contains(*name)) {
                            *target = format!("{SCHEMAS}{}", input_name(name));
                        }
                    }
                    _ => rename(value, names),
                }
            }
        }
        Value::Array(items) => items.iter_mut().for_each(|item| rename(item, names)),
        _ => {}
    }
}

fn sorted(value: Value) -> Value {
    match value {
        Value::Object(object) => {
            let by_key: BTreeMap<String, Value> = object.into_iter().map(|(key, value)| (key, sorted(value))).collect();
            Value::Object(by_key.into_iter().collect())
        }
        Value::Array(items) => Value::Array(items.into_iter().map(sorted).collect()),
        plain => plain,
    }
}

/// One route as the document has it.
fn operation(endpoint: Endpoint, schemas: &mut Schemas) -> utoipa::openapi::path::Operation {
    let mut operation = OperationBuilder::new()
        .operation_id(Some(endpoint.id))
        .tag(endpoint.tag)
        .summary(Some(endpoint.summary));
    for (name, schema) in &endpoint.variables {
        let parameter = ParameterBuilder::new()
            .name(*name)
            .parameter_in(ParameterIn::Path)
            .required(Required::True);
        operation = operation.parameter(parameter.schema(Some(embedded(schema(&mut schemas.requests)))));
    }
    if let Some(query) = endpoint.query {
        for parameter in query_parameters(query(&mut schemas.requests), &mut schemas.requests) {
            operation = operation.parameter(parameter);
        }
    }
    let mut errors: BTreeSet<u16> = endpoint.errors.iter().chain(ERRORS_OF_ALL).copied().collect();
    if let Some((body, example)) = endpoint.body {
        let content = ContentBuilder::new()
            .schema(Some(embedded(body(&mut schemas.requests))))
            .example(Some(example));
        operation = operation.request_body(Some(request_body("application/json", content)));
        errors.extend(ERRORS_OF_BODIES);
    }
    if let Some(kind) = endpoint.file {
        let file = ObjectBuilder::new()
            .schema_type(Type::String)
            .format(Some(SchemaFormat::KnownFormat(KnownFormat::Binary)));
        let content = ContentBuilder::new().schema(Some(file));
        operation = operation.request_body(Some(request_body(kind, content)));
    }
    for answer in endpoint.answers {
        let mut response = ResponseBuilder::new().description(answer.description);
        if let Some((kind, schema)) = answer.content {
            let content = ContentBuilder::new()
                .schema(Some(embedded(schema(&mut schemas.answers))))
                .build();
            response = response.content(kind, content);
        }
        errors.remove(&answer.status.as_u16());
        operation = operation.response(answer.status.as_str(), response.build());
    }
    errors.into_iter().fold(operation, with_error).build()
}

fn request_body(kind: &str, content: ContentBuilder) -> RequestBody {
    RequestBodyBuilder::new()
        .content(kind, content.build())
        .required(Some(Required::True))
        .build()
}

fn with_error(operation: OperationBuilder, status: u16) -> OperationBuilder {
    let content = ContentBuilder::new()
        .schema(Some(Ref::from_schema_name("ErrorBody")))
        .build();
    let reason = axum::http::StatusCode::from_u16(status)
        .ok()
        .and_then(|status| status.canonical_reason());
    let response = ResponseBuilder::new()
        .description(reason.unwrap_or("Error"))
        .content("application/json", content);
    operation.response(status.to_string(), response.build())
}

/// The properties of a query's object as parameters of their own.
fn query_parameters(query: Schema, generator: &mut SchemaGenerator) -> Vec<Parameter> {
    let query = query.to_value();
    let name = query
        .get("$ref")
        .and_then(Value::as_str)
        .and_then(|target| target.strip_prefix(SCHEMAS))
        .unwrap_or_default();
    // It stands in the operation itself: nobody else refers to it.
    let Some(Value::Object(object)) = generator.definitions_mut().remove(name) else {
        return Vec::new();
    };
    let Some(Value::Object(properties)) = object.get("properties") else {
        return Vec::new();
    };
    let required = object.get("required").and_then(Value::as_array);
    let is_required = |name: &String| required.is_some_and(|all| all.iter().any(|one| one == name));
    let parameter = |(name, schema): (&String, &Value)| {
        let mut schema = schema.clone();
        let description = schema.as_object_mut().and_then(|object| object.remove("description"));
        ParameterBuilder::new()
            .name(name)
            .parameter_in(ParameterIn::Query)
            .required(if is_required(name) {
                Required::True
            } else {
                Required::False
            })
            .description(description.as_ref().and_then(Value::as_str))
            .schema(serde_json::from_value::<ApiSchema>(with_lists(schema)).ok())
            .build()
    };
    properties.iter().map(parameter).collect()
}

/// A schema as utoipa has it: a reference to one of the document's, or an inline one of a plain type.
fn embedded(schema: Schema) -> RefOr<ApiSchema> {
    let schema = with_lists(schema.to_value());
    match schema.get("$ref").and_then(Value::as_str) {
        Some(target) => RefOr::Ref(Ref::new(target)),
        None => RefOr::T(serde_json::from_value(schema).unwrap_or_default()),
    }
}

/// One word that is permitted as a list of one: utoipa has no `const`, and would leave any word.
fn with_lists(schema: Value) -> Value {
    match schema {
        Value::Object(object) => {
            let part = |(key, value)| match key {
                key if key == "const" => ("enum".to_owned(), Value::Array(vec![value])),
                key => (key, with_lists(value)),
            };
            Value::Object(object.into_iter().map(part).collect())
        }
        Value::Array(items) => Value::Array(items.into_iter().map(with_lists).collect()),
        plain => plain,
    }
}

#[cfg(test)]
mod tests;
