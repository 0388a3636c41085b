//! Instances in processes of their own: what they can do, how they end, what they may use, and that nothing of them stays behind.

#[path = "host/orders.rs"]
mod orders;

use orders::{camera, child, create, events, runners, told, transmitted, ways};
use skein_domain::exchange::Event;
use skein_plugin_host::{ChildLimits, Instance, Isolation, PluginError, RunnerSettings, Runners};
use std::cell::Cell;
use std::time::{Duration, Instant};

async fn started(runners: &Runners) -> Instance {
    runners
        .create(camera(), child(), create("{}", None))
        .await
        .expect("is created")
}

/// Calls until the answer is an error, since a process that was just killed can still have an answer under way.
async fn lost(instance: &Instance) -> PluginError {
    loop {
        if let Err(error) = instance.call(events(vec![Event::Tick]), &[]).await {
            return error;
        }
    }
}

#[tokio::test]
async fn a_child_answers_as_the_same_library_does_here() {
    let runners = runners(Duration::from_secs(10));
    let payload = vec![7; 100];
    let mut answers = Vec::new();
    for isolation in ways() {
        let instance = runners
            .create(camera(), isolation, create("{}", Some(b"before ")))
            .await
            .expect("is created");
        assert_eq!(instance.snapshot().await.as_deref(), Ok(b"before ".as_slice()));
        let answer = told(&instance, r#"{"do": "remember", "text": "this"}"#)
            .await
            .expect("answers");
        assert_eq!(answer.snapshot, b"before this");
        let received = Event::Received { bytes: payload.clone() };
        answers.push(
            instance
                .call(events(vec![received]), &[])
                .await
                .expect("answers")
                .effects,
        );
        assert_eq!(instance.isolation(), isolation);
        assert_eq!(instance.pid().is_some(), isolation.is_child());
        assert_eq!(
            (instance.name(), instance.manifest().name.as_str()),
            ("vehicle-1/eye", "test-camera")
        );
        let statistics = instance.statistics();
        assert_eq!(statistics.failures, 0);
        assert!(statistics.calls >= 3);
        if !isolation.is_child() {
            assert!(!instance.kill(), "there is no process to end");
        }
    }
    assert_eq!(transmitted(&answers[0]), payload);
    assert_eq!(answers[0], answers[1]);
}

#[tokio::test]
async fn whatever_ends_a_child_is_named_and_ends_nothing_else() {
    let runners = runners(Duration::from_secs(10));
    let other = started(&runners).await;
    for (how, said) in [
        ("abort", "killed by signal 6 (SIGABRT)"),
        ("exit", "exit code 3"),
        ("segmentation_fault", "killed by signal 11 (SIGSEGV)"),
        ("stack_overflow", "killed by signal 6 (SIGABRT)"),
    ] {
        let instance = started(&runners).await;
        let error = told(&instance, &format!(r#"{{"do": "die", "how": "{how}"}}"#))
            .await
            .expect_err(how);
        assert!(error.needs_restart(), "{how}: {error}");
        let PluginError::ProcessEnded { how: ended, .. } = &error else {
            panic!("{how}: {error:?}")
        };
        assert_eq!(ended, said, "{how}");
        assert_eq!(instance.pid(), None);
        assert!(!instance.kill(), "it is gone already");
        assert_eq!(lost(&instance).await, error, "it stays lost, for the same reason");
        assert!(other.call(events(vec![Event::Tick]), &[]).await.is_ok());
    }
}

#[tokio::test]
async fn a_panic_is_told_with_its_message_and_leaves_the_process() {
    let runners = runners(Duration::from_secs(10));
    let instance = started(&runners).await;
    let error = told(&instance, r#"{"do": "die", "how": "panic"}"#)
        .await
        .expect_err("panics");
    assert!(
        matches!(&error, PluginError::Panicked { message } if message.contains("on purpose")),
        "{error}"
    );
    assert!(lost(&instance).await.needs_restart());
    let refused = runners
        .create(camera(), child(), create(r#"{"refuse": true}"#, None))
        .await;
    assert_eq!(
        refused.err(),
        Some(PluginError::Refused {
            detail: "refused on purpose".to_owned()
        })
    );
}

#[tokio::test]
async fn a_call_that_does_not_return_ends_the_child_and_delays_nobody() {
    // Far longer than healthy calls take: the ten have to come back before it is over, however long each of them takes.
    let deadline = Duration::from_secs(2);
    let runners = Runners::with_settings(RunnerSettings {
        call_deadline: deadline,
        create_deadline: Duration::from_secs(10),
        ..RunnerSettings::default()
    });
    runners.set_host_program(orders::host_program());
    let (hangs, other) = (started(&runners).await, started(&runners).await);
    let hang_is_over = Cell::new(false);
    let hang = async {
        let answer = told(&hangs, r#"{"do": "die", "how": "hang"}"#).await;
        hang_is_over.set(true);
        answer
    };
    let others = async {
        for _ in 0..10 {
            other.call(events(vec![Event::Tick]), &[]).await.expect("answers");
        }
        hang_is_over.get()
    };
    let (error, others_waited) = tokio::join!(hang, others);
    let Err(PluginError::DeadlineExceeded { after }) = error else {
        panic!("another error")
    };
    assert!(after >= deadline);
    assert!(!others_waited, "ten calls came back only after the one that hangs");
    assert_eq!(hangs.pid(), None, "its process is gone");
}

#[tokio::test]
async fn one_that_takes_no_end_is_ended() {
    // So long it is let try to end.
    let runners = runners(Duration::from_secs(3));
    let instance = runners
        .create(camera(), child(), create(r#"{"hang_at_end": true}"#, None))
        .await
        .expect("is created");
    let process = format!("/proc/{}", instance.pid().expect("is there"));
    let began = Instant::now();
    drop(instance);
    assert!(std::path::Path::new(&process).exists(), "somebody waited for its end");
    while std::path::Path::new(&process).exists() {
        assert!(began.elapsed() < Duration::from_secs(60), "it is still there");
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
}

#[tokio::test]
async fn a_killed_child_says_so() {
    let runners = runners(Duration::from_secs(10));
    let instance = started(&runners).await;
    assert!(instance.kill());
    let error = lost(&instance).await;
    assert!(
        matches!(&error, PluginError::ProcessEnded { how, .. } if how == "killed by signal 9 (SIGKILL)"),
        "{error}"
    );
}

#[tokio::test]
async fn a_child_may_use_no_more_than_its_limits() {
    let runners = runners(Duration::from_secs(60));
    let limits = ChildLimits {
        memory_mib: 64,
        open_files: 20,
        ..ChildLimits::default()
    };
    let isolation = Isolation::Child(limits);
    let instance = runners
        .create(camera(), isolation, create("{}", None))
        .await
        .expect("is created");
    let answer = told(&instance, r#"{"do": "open_files"}"#).await.expect("answers");
    let opened: u64 = String::from_utf8(transmitted(&answer.effects))
        .expect("text")
        .parse()
        .expect("a number");
    assert!((5..20).contains(&opened), "{opened} files beside its own");
    let error = told(&instance, r#"{"do": "take_memory"}"#)
        .await
        .expect_err("there is no more");
    assert!(
        matches!(&error, PluginError::ProcessEnded { how, said } if how.contains("SIGABRT") && said.contains("memory allocation")),
        "{error:?}"
    );
}

#[tokio::test]
async fn a_child_that_takes_too_much_of_a_core_is_ended() {
    let runners = runners(Duration::from_secs(60));
    let limits = ChildLimits {
        cpu_share: 0.05,
        ..ChildLimits::default()
    };
    let isolation = Isolation::Child(limits);
    let created = runners.create(camera(), isolation, create("{}", None)).await;
    let instance = created.expect("is created");
    told(&instance, r#"{"do": "spin"}"#).await.expect("answers");
    // Nobody calls it meanwhile: it is watched all the same.
    let began = Instant::now();
    while instance.pid().is_some() {
        assert!(began.elapsed() < Duration::from_secs(120), "it is still there");
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    let error = lost(&instance).await;
    assert!(error.needs_restart());
    let said = error.to_string();
    assert!(said.contains("of a core over 10 s, the limit is 5 %"), "{said}");
}

#[tokio::test]
async fn a_child_has_nothing_of_its_node_at_hand() {
    let runners = runners(Duration::from_secs(10));
    let instance = started(&runners).await;
    let answer = told(&instance, r#"{"do": "look_around"}"#).await.expect("answers");
    let seen = String::from_utf8(transmitted(&answer.effects)).expect("text");
    let mut words = seen.splitn(3, ' ');
    assert_eq!(words.next(), Some("/"));
    let variables: usize = words.next().expect("there").parse().expect("a number");
    assert!(variables <= 1, "{variables} variables of the environment");
    // Its three standard ones, the log, the frames, and the folder it looks into.
    let files = words.next().expect("there");
    assert_eq!(files.split(", ").count(), 6, "{files}");
}

#[tokio::test]
async fn floods_of_lines_block_nobody() {
    let runners = runners(Duration::from_secs(10));
    let instance = started(&runners).await;
    let flood = format!(r#"{{"do": "stderr", "text": "{}", "times": 2000}}"#, "x".repeat(200));
    told(&instance, &flood).await.expect("answers");
    told(&instance, r#"{"do": "log", "lines": 10000}"#)
        .await
        .expect("answers");
    assert!(instance.statistics().dropped_log_lines > 0);
    told(&instance, r#"{"do": "stderr", "text": "last words", "times": 1}"#)
        .await
        .expect("answers");
    let error = told(&instance, r#"{"do": "die", "how": "exit"}"#)
        .await
        .expect_err("ends");
    assert!(
        matches!(&error, PluginError::ProcessEnded { said, .. } if said == "last words"),
        "{error}"
    );
}

#[tokio::test]
async fn a_program_that_is_no_host_is_named() {
    let runners = runners(Duration::from_secs(10));
    runners.set_host_program("/nowhere/skein".into());
    let error = runners
        .create(camera(), child(), create("{}", None))
        .await
        .expect_err("is not there");
    assert!(
        matches!(&error, PluginError::NotStarted { detail } if detail.contains("/nowhere/skein")),
        "{error}"
    );
    // One that ends at once, and one that says nothing anyone asked for.
    for program in ["/bin/true", "/bin/echo"] {
        runners.set_host_program(program.into());
        let error = runners
            .create(camera(), child(), create("{}", None))
            .await
            .expect_err("is none");
        assert!(
            matches!(&error, PluginError::ProcessEnded { how, .. } if how == "exit code 0"),
            "{error:?}"
        );
    }
}
