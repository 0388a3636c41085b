//! PX4 over DDS against a foreign participant: Cyclone DDS plays what PX4's agent offers, the link flies it, and its truth judges.

mod admission;
mod flight;
mod returns;
mod rig;
mod strangers;
