//! Many lives in one process, which nothing else shares: its open files, threads and memory are counted.

mod cycles;
mod restarts;
