//! One vehicle in simulated time.
