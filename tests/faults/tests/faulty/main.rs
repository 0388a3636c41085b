//! Actors and plugins killed, links cut, vehicles lost: one program for all flights, so that several fly at a time and none is linked twice.

mod black_box;
mod crashes;
mod disk;
mod failsafe;
mod killed;
mod losses;
mod recording;
