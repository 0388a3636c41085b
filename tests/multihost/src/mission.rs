//! The parts of a flight: given at a gateway, waited for in the truth.
//!
//! Must never do: take a node's word for what its vehicle does.

use crate::field::Field;
use crate::judge::shape_error_m;
use crate::operator::{Answer, Operator};
use reqwest::Method;
use serde_json::{Value, json};
use skein_domain::{PositionNed, Shape};

/// Height of the flights, in metres.
pub const HEIGHT_M: f64 = 8.0;
/// Distance between neighbours in a formation, in metres.
pub const SPACING_M: f64 = 6.0;
/// How far the shape may be from what was asked for, when it stands, in metres.
const SHAPE_M: f64 = 1.0;
/// A vehicle slower than this stands, in metres per second.
const STANDS_M_S: f64 = 0.4;
/// So often an operator asks in bad air, where an order can be lost with the node that took it.
const TRIES_IN_BAD_AIR: usize = 3;
/// So often it is looked whether a formation is shown, and the time between two looks, in seconds.
const SHOWN_WITHIN_LOOKS: usize = 60;
const LOOK_S: f64 = 0.25;
/// Start, arming, climb; a change of shape; descent: each with much room, because the machine may do other things as well.
const PART_WITHIN_S: f64 = 60.0;

/// One operator's flight.
#[derive(Debug)]
pub struct Mission<'f> {
    /// The hosts.
    pub field: &'f mut Field,
    /// Where the operator stands.
    pub gateway: u8,
    /// The vehicles flown.
    pub vehicles: Vec<u8>,
    /// So often the operator asks for what does not come about: once, unless the air is bad.
    tries: usize,
}

impl<'f> Mission<'f> {
    /// Of all vehicles of these hosts, commanded at this gateway.
    pub fn new(field: &'f mut Field, gateway: u8) -> Self {
        let vehicles = field.vehicles();
        Self::of(field, gateway, vehicles)
    }

    /// Of these vehicles, commanded at this gateway.
    pub fn of(field: &'f mut Field, gateway: u8, vehicles: Vec<u8>) -> Self {
        Self {
            field,
            gateway,
            vehicles,
            tries: 1,
        }
    }

    /// Flown by an operator who asks again, as one does in bad air.
    #[must_use]
    pub fn in_bad_air(self) -> Self {
        Self {
            tries: TRIES_IN_BAD_AIR,
            ..self
        }
    }

    /// Waits until the gateway shows all vehicles, ready to be armed.
    pub async fn ready(&mut self) {
        let (gateway, vehicles) = (self.gateway, self.vehicles.clone());
        let all_ready = async |field: &mut Field| {
            let fleet = field.host(gateway).operator().fleet().await;
            let known = fleet["vehicles"].as_array().cloned().unwrap_or_default();
            let is_ready = |id: &u8| {
                known
                    .iter()
                    .any(|v| v["id"] == json!(id) && v["ready_to_arm"] == json!(true))
            };
            vehicles.iter().all(is_ready)
        };
        self.field
            .until("all vehicles ready at the gateway", PART_WITHIN_S, all_ready)
            .await;
        // the ready lines of the autopilots come before their estimates have settled
        self.field.pass(3.0).await;
    }

    /// Has all take off together; waits until they are up.
    pub async fn take_off(&mut self) {
        self.ready().await;
        self.command_all(json!({ "command": "take_off", "height_m": HEIGHT_M }))
            .await;
        let vehicles = self.vehicles.clone();
        let up = async |field: &mut Field| {
            let places = field.places(&vehicles);
            let is_up = places
                .iter()
                .all(|(at, v)| -at.down_m > HEIGHT_M - 1.0 && v.vector().norm() < STANDS_M_S);
            is_up && holding(field, &vehicles).await
        };
        self.field.until("all up and holding", PART_WITHIN_S, up).await;
    }

    /// Asks for a formation.
    ///
    /// # Panics
    /// If it is refused.
    pub async fn ask_formation(&mut self, shape: Shape) -> Value {
        let body = json!({ "shape": shape, "spacing_m": SPACING_M });
        let operator = self.field.host(self.gateway).operator();
        let answer = operator.ask(Method::PUT, "/api/v1/formation", Some(body)).await;
        assert!(answer.is_success(), "the formation is refused: {answer:?}");
        answer.body
    }

    /// Asks for a formation and waits until it stands. In bad air, one that a successor had not heard of is asked for again.
    ///
    /// # Panics
    /// If it is not flown.
    pub async fn form_up(&mut self, shape: Shape) {
        for _ in 0..self.tries {
            self.ask_formation(shape).await;
            for _ in 0..SHOWN_WITHIN_LOOKS {
                self.field.pass(LOOK_S).await;
                if self.formation().await["request"]["shape"] == json!(shape) {
                    return self.stands_as(shape).await;
                }
            }
            println!("{shape:?} was lost");
        }
        panic!("{shape:?} is asked for and not flown: {}", self.formation().await);
    }

    /// Waits until the vehicles have this shape and stand.
    pub async fn stands_as(&mut self, shape: Shape) {
        let vehicles = self.vehicles.clone();
        let stands = async |field: &mut Field| {
            let places = field.places(&vehicles);
            let at: Vec<PositionNed> = places.iter().map(|(at, _)| *at).collect();
            places.iter().all(|(_, v)| v.vector().norm() < STANDS_M_S) && shape_error_m(&at, shape, SPACING_M) < SHAPE_M
        };
        let what = format!("vehicles {vehicles:?} to stand as {shape:?}");
        self.field.until(&what, PART_WITHIN_S, stands).await;
    }

    /// Sends the leader, and with it the formation, to a place so far from where it is. Gives leader and place.
    ///
    /// # Panics
    /// If it is refused.
    pub async fn set_out(&mut self, north_m: f64, east_m: f64) -> (u8, PositionNed) {
        let operator = self.field.host(self.gateway).operator();
        let formation = self.formation().await;
        let leader = formation["leader"].as_u64();
        let leader = leader.and_then(|id| u8::try_from(id).ok());
        let leader = leader.unwrap_or_else(|| panic!("the formation has no leader: {formation}"));
        let from = self.field.places(&[leader])[0].0;
        let to = PositionNed::new(from.north_m + north_m, from.east_m + east_m, -HEIGHT_M);
        let answer = ask_route(&operator, to).await;
        assert!(answer.is_success(), "the route is refused: {answer:?}");
        (leader, to)
    }

    /// The formation, as the node that coordinates at the gateway's side shows it.
    async fn formation(&self) -> Value {
        formation_at(self.field, self.gateway).await
    }

    /// Waits until the leader is there.
    pub async fn arrives(&mut self, leader: u8, at: PositionNed) {
        let there = async |field: &mut Field| {
            let (is, v) = field.places(&[leader])[0];
            is.horizontal_distance_m(&at) < 2.0 && v.vector().norm() < STANDS_M_S
        };
        let what = format!("the leader {leader} to come to {at:?}");
        self.field.until(&what, PART_WITHIN_S, there).await;
    }

    /// Waits until the vehicle that leads now is there: where much is lost, who leads may change on the way. In bad air, a route that a
    /// successor had not heard of is asked for again.
    pub async fn whoever_leads_arrives(&mut self, at: PositionNed) {
        let (gateway, tries) = (self.gateway, self.tries);
        let mut asked = 1;
        let there = async |field: &mut Field| {
            let formation = formation_at(field, gateway).await;
            let leader = formation["leader"].as_u64();
            let Some(leader) = leader.and_then(|id| u8::try_from(id).ok()) else {
                return false;
            };
            if formation["route"].is_null() && asked < tries {
                asked += 1;
                let answer = ask_route(&field.host(gateway).operator(), at).await;
                println!("the route was lost, and is asked for again: {}", answer.body);
            }
            let (is, v) = field.places(&[leader])[0];
            is.horizontal_distance_m(&at) < 2.0 && v.vector().norm() < STANDS_M_S
        };
        let what = format!("whoever leads to come to {at:?}");
        self.field.until(&what, PART_WITHIN_S, there).await;
    }

    /// Has all land; waits until they are down.
    pub async fn land(&mut self) {
        self.command_all(json!({ "command": "land" })).await;
        let vehicles = self.vehicles.clone();
        let down = async |field: &mut Field| field.are_down(&vehicles);
        self.field.until("all down", PART_WITHIN_S, down).await;
    }

    /// Gives all vehicles of the flight a command that none may refuse. In bad air, whose node does not answer is asked again.
    ///
    /// # Panics
    /// If one refuses, or its node does not answer.
    pub async fn command_all(&mut self, command: Value) {
        let operator = self.field.host(self.gateway).operator();
        let mut asked = self.vehicles.clone();
        let mut said = Value::Null;
        for _ in 0..self.tries {
            let answer = operator.command(Some(&asked), command.clone()).await;
            let receipts = answer.body["receipts"].as_array().cloned().unwrap_or_default();
            assert_eq!(receipts.len(), asked.len(), "{answer:?}");
            let refused: Vec<&Value> = receipts.iter().filter(|r| !r["refusal"].is_null()).collect();
            let what = |r: &&Value| r["refusal"]["what"].as_str().map(str::to_owned);
            let unanswered = |r: &&Value| what(r).is_some_and(|what| what.contains("does not answer"));
            assert!(
                refused.iter().all(unanswered),
                "{command} was not taken up by all: {answer:?}"
            );
            let vehicle = |r: &&Value| r["vehicle"].as_u64().and_then(|id| u8::try_from(id).ok());
            asked = refused.iter().filter_map(vehicle).collect();
            if asked.is_empty() {
                return;
            }
            println!("not answered: {asked:?}");
            said = answer.body;
        }
        panic!("{command} was not taken up by all: {said}");
    }
}

async fn ask_route(operator: &Operator, to: PositionNed) -> Answer {
    let route = json!({ "waypoints": [to], "speed_m_s": 4.0, "corner_radius_m": 8.0 });
    let body = json!({ "route": route });
    operator.ask(Method::PUT, "/api/v1/formation/route", Some(body)).await
}

/// The formation, as the node that this gateway obeys shows it.
async fn formation_at(field: &Field, gateway: u8) -> Value {
    let obeyed = field.host(gateway).operator().swarm().await["term"]["coordinator"].as_u64();
    let obeyed = obeyed.and_then(|node| u8::try_from(node).ok());
    let operator = field.host(obeyed.unwrap_or(gateway)).operator();
    operator.get("/api/v1/formation").await["formation"].clone()
}

/// Whether these vehicles' own nodes say that they hold: a vehicle that has just come up is not yet under the swarm's control.
async fn holding(field: &Field, vehicles: &[u8]) -> bool {
    for number in vehicles {
        let vehicle = field.host(*number).operator().vehicle(*number).await;
        if vehicle["flight_state"] != "holding" {
            return false;
        }
    }
    true
}
