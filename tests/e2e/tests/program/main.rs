//! The program as it ships, started as a person starts it.

mod bad_input;
mod demo;
mod doctor;
mod scenarios;
mod service;
mod traces;
