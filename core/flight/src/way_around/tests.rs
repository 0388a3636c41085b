//! Ways around: clear of everything, no longer than need be, and refused with the zone where there is none.
