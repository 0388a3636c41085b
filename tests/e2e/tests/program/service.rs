//! What a service manager hears of a node, by the datagrams that systemd defines (sd_notify(3)); and that nobody need hear what it prints.

use skein_testkit::{Process, patience, plugins_dir, skein_binary};
use std::path::Path;
use std::process::Stdio;
use tokio::net::UnixDatagram;
use tokio::process::Command;

/// How long the node may be silent, as the service manager tells it. Long: the machine may stand still.
const WATCHDOG_US: &str = "2000000";

/// Hears until one says so.
async fn heard(manager: &UnixDatagram, wanted: &str) {
    let listening = async {
        let mut buffer = [0; 4096];
        loop {
            let size = manager.recv(&mut buffer).await.expect("the socket is ours");
            let text = String::from_utf8_lossy(&buffer[..size]);
            if text.lines().any(|line| line == wanted) {
                return;
            }
        }
    };
    let in_time = tokio::time::timeout(patience(), listening).await;
    assert!(in_time.is_ok(), "never heard {wanted}");
}

fn node(folder: &Path) -> Process {
    Process::start("skein run", command(folder))
}

fn command(folder: &Path) -> Command {
    let config = format!(
        "[web]\nlisten = \"127.0.0.1:0\"\n[[endpoints]]\naddress = \"udp-listen://127.0.0.1:0\"\n[plugins]\ndirectories = [{:?}]\n",
        plugins_dir()
    );
    let file = folder.join("node.toml");
    std::fs::write(&file, config).expect("is written");
    let socket = folder.join("notify");
    let mut command = Command::new(skein_binary());
    command.args(["run", "--config"]).arg(file);
    command.env("NOTIFY_SOCKET", socket).env("WATCHDOG_USEC", WATCHDOG_US);
    command
}

#[tokio::test]
async fn a_service_manager_hears_that_the_node_is_up_goes_on_and_stops() {
    let folder = tempfile::tempdir().expect("a folder");
    let manager = UnixDatagram::bind(folder.path().join("notify")).expect("binds");
    let mut process = node(folder.path());
    heard(&manager, "READY=1").await;
    heard(&manager, "STATUS=0 vehicles, 0 armed").await;
    for _ in 0..3 {
        heard(&manager, "WATCHDOG=1").await;
    }
    process.signal("TERM").await;
    heard(&manager, "STOPPING=1").await;
    assert_eq!(process.exit_code(patience()).await, 0, "{}", process.output());
}

/// `skein run | tee log`, and Ctrl-C ends `tee` first: the node still ends as it should.
#[tokio::test]
async fn a_node_whose_output_nobody_reads_any_more_goes_on_and_stops_in_order() {
    let folder = tempfile::tempdir().expect("a folder");
    let manager = UnixDatagram::bind(folder.path().join("notify")).expect("binds");
    let (reader, unread) = std::io::pipe().expect("a pipe");
    drop(reader);
    let mut node = command(folder.path()).stdout(unread).spawn().expect("starts");
    heard(&manager, "READY=1").await;
    let id = node.id().expect("it runs").to_string();
    let told = Command::new("kill").args(["-TERM", &id]).status().await;
    assert!(told.is_ok_and(|status| status.success()));
    heard(&manager, "STOPPING=1").await;
    let ended = tokio::time::timeout(patience(), node.wait()).await;
    let ended = ended.expect("it ends").expect("it can be waited for");
    assert!(ended.success(), "{ended}");
}

/// `skein log list | head`: what is not read is no fault of the program's.
#[tokio::test]
async fn a_command_whose_output_nobody_reads_ends_without_a_word() {
    let folder = tempfile::tempdir().expect("a folder");
    let (reader, unread) = std::io::pipe().expect("a pipe");
    drop(reader);
    let mut command = Command::new(skein_binary());
    command.args(["log", "list"]).arg(folder.path()).stdout(unread);
    let ended = command.stderr(Stdio::piped()).output().await.expect("starts");
    assert!(ended.status.success(), "{ended:?}");
    assert_eq!(String::from_utf8_lossy(&ended.stderr), "");
}
