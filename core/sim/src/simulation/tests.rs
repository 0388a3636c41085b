//! The simulation over real sockets on the loopback interface.
