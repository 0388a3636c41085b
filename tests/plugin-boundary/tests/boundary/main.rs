//! Built plugin libraries, good and misbehaving, through the host and the program's commands. One after the other: several hang or abort on purpose.

mod command_line;
mod detectors;
mod evaluation;
mod example_c;
mod instances;
mod loading;
mod logs;
mod outcomes;
mod tutorial;
