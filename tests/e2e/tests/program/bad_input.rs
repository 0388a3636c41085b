//! Wrong arguments, configurations and ports: a clear message and the documented exit code.

use skein_testkit::{Process, plugins_dir};
use std::net::{TcpListener, UdpSocket};
use std::path::Path;
use std::time::Duration;

const SOON: Duration = Duration::from_secs(20);

async fn run_with(config: &str) -> (i32, String) {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("node.toml");
    std::fs::write(&file, config).expect("is written");
    run_file(&file).await
}

async fn run_file(file: &Path) -> (i32, String) {
    let mut process = Process::skein(&["run", "--config", file.to_str().expect("is text")]);
    let code = process.exit_code(SOON).await;
    (code, process.output())
}

/// A configuration that is right but for what a test adds.
fn config(web: &str, more: &str) -> String {
    format!(
        "{more}\n[web]\nlisten = \"{web}\"\n[plugins]\ndirectories = [{:?}]\n",
        plugins_dir()
    )
}

#[tokio::test]
async fn wrong_arguments_exit_with_2() {
    for arguments in [
        &["fly"] as &[&str],
        &["demo", "--vehicles", "0"],
        &["run"],
        &["sim", "--vehicles", "many"],
    ] {
        let mut process = Process::skein(arguments);
        assert_eq!(process.exit_code(SOON).await, 2, "{arguments:?}: {}", process.output());
    }
}

#[tokio::test]
async fn a_missing_file_and_an_unknown_key_exit_with_64() {
    let (code, output) = run_file(Path::new("/nowhere/node.toml")).await;
    assert_eq!(code, 64, "{output}");
    assert!(output.contains("/nowhere/node.toml"), "{output}");
    let (code, output) = run_with("[node]\nnmae = \"x\"\n").await;
    assert_eq!(code, 64, "{output}");
    assert!(output.contains("nmae") && output.contains("line 2"), "{output}");
}

#[tokio::test]
async fn a_missing_plugin_and_a_meaningless_address_exit_with_64() {
    let rule = "[[adopt]]\nmodel = \"submarine\"\n";
    let (code, output) = run_with(&config("127.0.0.1:0", rule)).await;
    assert_eq!(code, 64, "{output}");
    assert!(output.contains("submarine"), "{output}");
    let endpoint = "[[endpoints]]\naddress = \"carrier-pigeon://coop\"\n";
    let (code, output) = run_with(&config("127.0.0.1:0", endpoint)).await;
    assert_eq!(code, 64, "{output}");
    assert!(output.contains("carrier-pigeon"), "{output}");
}

#[tokio::test]
async fn a_port_in_use_exits_with_69_and_names_it() {
    let taken = TcpListener::bind("127.0.0.1:0").expect("binds");
    let address = taken.local_addr().expect("is bound").to_string();
    let (code, output) = run_with(&config(&address, "")).await;
    assert_eq!(code, 69, "{output}");
    assert!(output.contains(&address), "{output}");
    let taken = UdpSocket::bind("127.0.0.1:0").expect("binds");
    let address = taken.local_addr().expect("is bound");
    let endpoint = format!("[[endpoints]]\naddress = \"udp-listen://{address}\"\n");
    let (code, output) = run_with(&config("127.0.0.1:0", &endpoint)).await;
    assert_eq!(code, 69, "{output}");
    assert!(output.contains(&address.to_string()), "{output}");
}

#[tokio::test]
async fn doctor_names_what_is_wrong_and_how_to_mend_it() {
    let plugins = plugins_dir();
    let mut good = Process::skein(&["doctor", "--plugins", plugins.to_str().expect("is text")]);
    let code = good.exit_code(SOON).await;
    assert!(good.output().contains("generic-uav"), "{}", good.output());
    assert!(
        code == 0 || good.output().contains("8080"),
        "only a taken port may be wrong: {}",
        good.output()
    );
    let mut bad = Process::skein(&["doctor", "--plugins", "/nowhere"]);
    assert_eq!(bad.exit_code(SOON).await, 1);
    assert!(bad.output().contains("mend:"), "{}", bad.output());
}

#[tokio::test]
async fn a_node_listens_on_loopback_only_and_ends_cleanly() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("node.toml");
    let endpoint = "[[endpoints]]\naddress = \"udp-listen://127.0.0.1:0\"\n";
    std::fs::write(&file, config("127.0.0.1:0", endpoint)).expect("is written");
    let mut process = Process::skein(&["run", "--config", file.to_str().expect("is text")]);
    process.line("Stop with Ctrl-C").await;
    let id = process.id().expect("runs");
    for table in ["tcp", "udp", "tcp6", "udp6"] {
        let own = own_sockets(id, table);
        // 0100007F is 127.0.0.1 as the kernel writes it.
        assert!(
            own.iter().all(|address| address.starts_with("0100007F")),
            "{table}: {own:?}"
        );
    }
    process.signal("TERM").await;
    assert_eq!(process.exit_code(SOON).await, 0, "{}", process.output());
}

/// Local addresses of the sockets of a process, as the kernel writes them.
fn own_sockets(id: u32, table: &str) -> Vec<String> {
    let links = std::fs::read_dir(format!("/proc/{id}/fd")).expect("is ours");
    let inodes: Vec<String> = links
        .filter_map(|link| std::fs::read_link(link.ok()?.path()).ok())
        .filter_map(|target| Some(target.to_str()?.strip_prefix("socket:[")?.strip_suffix(']')?.to_owned()))
        .collect();
    let text = std::fs::read_to_string(format!("/proc/{id}/net/{table}")).unwrap_or_default();
    text.lines()
        .skip(1)
        .filter_map(|line| {
            let fields: Vec<&str> = line.split_whitespace().collect();
            inodes
                .iter()
                .any(|inode| fields.get(9) == Some(&inode.as_str()))
                .then(|| fields.get(1).map(|f| (*f).to_owned()))?
        })
        .collect()
}

/// A member of a swarm whose secret is in this file.
fn member(secret: &Path) -> String {
    let file = secret.to_str().expect("is text");
    let swarm = format!("[swarm]\nid = \"f\"\nnode = 1\nsecret_file = {file:?}\n");
    config("127.0.0.1:0", &swarm)
}

#[tokio::test]
async fn a_secret_is_made_once_and_one_that_is_none_exits_with_64() {
    let folder = tempfile::tempdir().expect("a folder");
    let secret = folder.path().join("swarm.key");
    let file = secret.to_str().expect("is text");
    let (code, output) = run_with(&member(&secret)).await;
    assert!(code == 64 && output.contains("new-secret"), "{code}: {output}");
    let mut made = Process::skein(&["swarm", "new-secret", file]);
    assert_eq!(made.exit_code(SOON).await, 0, "{}", made.output());
    let first = std::fs::read_to_string(&secret).expect("was made");
    assert!(
        !made.output().contains(first.trim()),
        "the secret is not for the screen"
    );
    let mut again = Process::skein(&["swarm", "new-secret", file]);
    assert_eq!(again.exit_code(SOON).await, 1, "{}", again.output());
    assert_eq!(std::fs::read_to_string(&secret).expect("is still there"), first);

    std::fs::set_permissions(&secret, std::os::unix::fs::PermissionsExt::from_mode(0o644)).expect("are set");
    let (code, output) = run_with(&member(&secret)).await;
    assert!(code == 64 && output.contains("chmod 600"), "{code}: {output}");
    for text in ["geese", "00ff"] {
        std::fs::remove_file(&secret).expect("is gone");
        std::fs::write(&secret, text).expect("is written");
        std::fs::set_permissions(&secret, std::os::unix::fs::PermissionsExt::from_mode(0o600)).expect("are set");
        let (code, output) = run_with(&member(&secret)).await;
        assert!(
            code == 64 && output.contains("holds no secret"),
            "{text}: {code}: {output}"
        );
    }
}

#[tokio::test]
async fn a_configuration_is_made_once_and_the_program_says_what_shells_and_man_want_to_know() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("node.toml");
    let file = file.to_str().expect("is text");
    let run = async |arguments: &[&str]| {
        let mut process = Process::skein(arguments);
        let code = process.exit_code(SOON).await;
        (code, process.output())
    };
    // Nobody sits there: what is not said is the usual.
    let made = [
        "init",
        file,
        "--computer",
        "ground",
        "--vehicles",
        "1-6",
        "--swarm",
        "field",
    ];
    let (code, said) = run(&made).await;
    assert!(
        code == 0 && said.contains("skein run --config") && said.contains("new-secret"),
        "{said}"
    );
    let (code, said) = run(&made).await;
    assert!(code == 1 && said.contains("is there already"), "{said}");
    let (code, said) = run(&["completions", "bash"]).await;
    assert!(code == 0 && said.contains("complete -F _skein"), "{said}");
    let pages = folder.path().to_str().expect("is text");
    let (code, said) = run(&["man", pages]).await;
    assert!(code == 0, "{said}");
    let page = std::fs::read_to_string(folder.path().join("skein-demo.1")).expect("is written");
    assert!(page.contains("Fly a demonstration"), "{page}");
}
