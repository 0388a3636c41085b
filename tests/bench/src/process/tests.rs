//! Reading /proc.

use super::*;

#[test]
fn figures_of_a_process_are_read() {
    let stat = "812 (a (b) c) S 1 812 812 0 -1 4194560 3081 0 2 0 150 50 0 0 20 0 5 0 8817 231 842 184";
    let status = "Name:\ta\nVmHWM:\t   9000 kB\nVmRSS:\t    2048 kB\nThreads:\t5\n";
    assert_eq!(
        Usage::parse(stat, status, 100.0),
        Some(Usage {
            cpu_s: 2.0,
            rss_mib: 2.0,
            threads: 5
        })
    );
    assert_eq!(Usage::parse("", status, 100.0), None);
    assert_eq!(Usage::parse(stat, "", 100.0), None);
}

#[test]
fn figures_of_the_machine_are_read() {
    let stat = "cpu  10 20 30 1000 500 5 7 99 0 0\ncpu0 1 1 1 1\n";
    assert_eq!(busy_ticks(stat), Some(72.0));
    let snmp = "Tcp: A B\nTcp: 1 2\nUdp: InDatagrams RcvbufErrors SndbufErrors\nUdp: 100 42 0\n";
    assert_eq!(receive_buffer_errors(snmp), Some(42));
    assert_eq!((busy_ticks(""), receive_buffer_errors("Udp: A\n")), (None, None));
}

#[test]
fn this_process_has_used_something() {
    let used = Usage::of(std::process::id()).unwrap();
    assert!(used.rss_mib > 0.1 && used.threads >= 1);
    assert!(Machine::now().busy_s > 0.0);
}
