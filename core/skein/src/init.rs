//! `skein init`: a few questions, and a configuration with comments that has been checked.
//!
//! Must never do: write over a file, or write a configuration that does not load.

use anyhow::{Context, bail};
use clap::{Args, ValueEnum};
use skein_config::NodeConfig;
use skein_link_mavlink::EndpointAddress;
use skein_node::plugins_beside_program;
use std::fs::OpenOptions;
use std::io::{self, BufRead, IsTerminal, Write};
use std::path::PathBuf;

/// PX4's simulation sends its first vehicle to this port, the next to the one after it, and has ports for so many.
const FIRST_SIMULATED_PORT: u16 = 14_540;
const MOST_SIMULATED: u16 = 10;
/// The number of a ground station's node; those of vehicles are their system ids.
const GROUND_NODE: u16 = 255;

/// `skein init`
#[derive(Debug, Clone, Args)]
pub struct InitArguments {
    /// The file to be made; it must not be there yet.
    #[arg(default_value = "node.toml", value_name = "FILE")]
    pub file: PathBuf,
    /// What this computer is.
    #[arg(long, value_enum, value_name = "KIND")]
    pub computer: Option<Computer>,
    /// Where autopilots are heard, such as `serial:///dev/ttyAMA0?baud=921600` or `udp-listen://0.0.0.0:14550`.
    #[arg(long, value_name = "ADDRESS")]
    pub address: Option<String>,
    /// System ids of the vehicles to be flown, such as `7` or `1-6,9`.
    #[arg(long, value_name = "IDS")]
    pub vehicles: Option<String>,
    /// The UAV model that flies them.
    #[arg(long, value_name = "PLUGIN")]
    pub model: Option<String>,
    /// The swarm that the node joins; `none` flies its vehicles alone.
    #[arg(long, value_name = "NAME")]
    pub swarm: Option<String>,
}

/// What a computer is in a swarm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Computer {
    /// A companion computer on a vehicle, wired to its autopilot.
    Vehicle,
    /// A ground station that hears its vehicles by radio or network.
    Ground,
    /// A computer with simulated vehicles: `skein sim`, or PX4's software in the loop.
    Simulation,
}

/// What is written.
struct Answers {
    computer: Computer,
    addresses: Vec<String>,
    vehicles: String,
    model: String,
    swarm: Option<String>,
}

/// `skein init`.
///
/// # Errors
/// The file is there already or cannot be written, or an answer makes no configuration.
pub fn init(arguments: &InitArguments) -> anyhow::Result<()> {
    if arguments.file.exists() {
        bail!("{} is there already; name another file", arguments.file.display());
    }
    let answers = answers(arguments)?;
    let text = configuration(&answers);
    NodeConfig::parse(&text).context("these answers make no configuration")?;
    for address in &answers.addresses {
        let sound = address.parse::<EndpointAddress>();
        sound.with_context(|| format!("{address:?} is no address of autopilots"))?;
    }
    let mut made = OpenOptions::new()
        .write(true)
        .create_new(true)
        .open(&arguments.file)
        .with_context(|| format!("cannot make {}", arguments.file.display()))?;
    made.write_all(text.as_bytes())?;
    let file = arguments.file.display();
    println!("{file} is written and loads. Next:");
    if answers.swarm.is_some() {
        println!(
            "  skein swarm new-secret swarm.key    once for the whole swarm; copy it to every node, beside {file}"
        );
    }
    if answers.computer == Computer::Simulation {
        println!("  skein sim --vehicles N              in another terminal, or PX4's software in the loop");
    }
    println!("  skein doctor --config {file}    what is wrong on this machine, and how to mend it");
    println!("  skein run --config {file}       fly");
    Ok(())
}

fn answers(arguments: &InitArguments) -> anyhow::Result<Answers> {
    let mut person = Person {
        is_there: io::stdin().is_terminal(),
    };
    let computer = match arguments.computer {
        Some(computer) => computer,
        None => {
            let said = person.ask("What is this computer: vehicle, ground or simulation?", "vehicle")?;
            Computer::from_str(&said, true).map_err(|_| anyhow::anyhow!("{said:?} is none of them"))?
        }
    };
    let or_ask = |given: &Option<String>, question: &str, usual: &str, person: &mut Person| match given {
        Some(given) => Ok(given.clone()),
        None => person.ask(question, usual),
    };
    let (usual_address, usual_vehicles) = match computer {
        Computer::Vehicle => ("serial:///dev/ttyAMA0?baud=921600", "1"),
        Computer::Ground => ("udp-listen://0.0.0.0:14550", "1-250"),
        Computer::Simulation => ("PX4's ports", "1-6"),
    };
    let address = or_ask(
        &arguments.address,
        "Where are autopilots heard?",
        usual_address,
        &mut person,
    )?;
    let vehicles = or_ask(
        &arguments.vehicles,
        "System ids of the vehicles to be flown?",
        usual_vehicles,
        &mut person,
    )?;
    let model = or_ask(
        &arguments.model,
        "Which UAV model flies them: generic-uav, observation-uav, coordinator-uav or one of your own?",
        "generic-uav",
        &mut person,
    )?;
    let swarm = or_ask(
        &arguments.swarm,
        "Which swarm does this node join? Its name, or none:",
        "none",
        &mut person,
    )?;
    let addresses = if address == usual_address && computer == Computer::Simulation {
        let port = |place| format!("udp-listen://127.0.0.1:{}", FIRST_SIMULATED_PORT + place);
        (0..MOST_SIMULATED).map(port).collect()
    } else {
        vec![address]
    };
    Ok(Answers {
        computer,
        addresses,
        vehicles,
        model,
        swarm: (swarm != "none").then_some(swarm),
    })
}

/// Who answers, if anybody does.
struct Person {
    is_there: bool,
}

impl Person {
    /// Their answer; the usual one if they say nothing, or nobody is there.
    fn ask(&mut self, question: &str, usual: &str) -> io::Result<String> {
        if !self.is_there {
            return Ok(usual.to_owned());
        }
        print!("{question} [{usual}] ");
        io::stdout().flush()?;
        let mut line = String::new();
        self.is_there = io::stdin().lock().read_line(&mut line)? > 0;
        let said = line.trim();
        Ok(if said.is_empty() {
            usual.to_owned()
        } else {
            said.to_owned()
        })
    }
}

fn configuration(answers: &Answers) -> String {
    let mut text = String::from(match answers.computer {
        Computer::Vehicle => "# A companion computer on a vehicle, wired to its autopilot.\n",
        Computer::Ground => "# A ground station that hears its vehicles by radio or network.\n",
        Computer::Simulation => "# A computer with simulated vehicles, on the ports of PX4's software in the loop.\n",
    });
    text += "# Every key is documented in the configuration reference; what is left out has its default.\n";
    let first = first_number(&answers.vehicles).unwrap_or(1);
    let name = match answers.computer {
        Computer::Vehicle => format!("vehicle-{first}"),
        Computer::Ground => "ground".to_owned(),
        Computer::Simulation => "simulation".to_owned(),
    };
    let quoted = |text: &str| serde_json::Value::from(text).to_string();
    let mut add = |line: &str| {
        text.push_str(line);
        text.push('\n');
    };
    add(&format!("\n[node]\nname = {}", quoted(&name)));
    if let Some(swarm) = &answers.swarm {
        let (node, priority) = match answers.computer {
            Computer::Vehicle => (first, 50),
            Computer::Ground | Computer::Simulation => (GROUND_NODE, 200),
        };
        add("\n# Nodes of one swarm have the same id and secret, and each a number of its own.");
        add(&format!("[swarm]\nid = {}\nnode = {node}", quoted(swarm)));
        add("secret_file = \"swarm.key\"            # made once by `skein swarm new-secret swarm.key`");
        add(&format!(
            "coordinator_priority = {priority}           # greater is better"
        ));
        add("\n[swarm.zenoh]\nlisten = [\"udp/0.0.0.0:7447\"]");
        add(
            "multicast = true                      # over a network without multicast: connect = [\"udp/10.0.0.1:7447\"]",
        );
    }
    for (place, address) in answers.addresses.iter().enumerate() {
        add(&format!(
            "\n[[endpoints]]\nname = \"autopilot-{}\"\naddress = {}",
            place + 1,
            quoted(address)
        ));
    }
    add("\n# Only these are flown; whatever else is heard is shown. A vehicle's id is its system id.");
    add(&format!("[[adopt]]\nsystem_ids = {}", quoted(&answers.vehicles)));
    add(&format!(
        "name = \"uav-{{system_id}}\"\nmodel = {}",
        quoted(&answers.model)
    ));
    let plugins = plugins_beside_program();
    add(&format!(
        "\n[plugins]\ndirectories = [{}]",
        quoted(&plugins.to_string_lossy())
    ));
    add("\n[web]\n# Reach it from elsewhere by `ssh -L 8080:127.0.0.1:8080`: the API knows no users.");
    add("listen = \"127.0.0.1:8080\"");
    if answers.computer != Computer::Simulation {
        add("\n[safety]\nmax_speed_m_s = 5.0                   # a first flight is a slow one");
    }
    text
}

/// The first number in a text.
fn first_number(text: &str) -> Option<u16> {
    let digits: String = text
        .chars()
        .skip_while(|c| !c.is_ascii_digit())
        .take_while(char::is_ascii_digit)
        .collect();
    digits.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answers_of(computer: Computer, swarm: Option<&str>) -> Answers {
        let arguments = InitArguments {
            file: "unused".into(),
            computer: Some(computer),
            address: None,
            vehicles: None,
            model: None,
            swarm: swarm.map(str::to_owned),
        };
        // Nobody is asked in a test: what is not said is the usual.
        answers(&arguments).expect("are complete")
    }

    #[test]
    fn the_usual_answers_make_configurations_that_load() {
        for computer in [Computer::Vehicle, Computer::Ground, Computer::Simulation] {
            for swarm in [None, Some("field-7")] {
                let text = configuration(&answers_of(computer, swarm));
                let config = NodeConfig::parse(&text).unwrap_or_else(|error| panic!("{error}\n{text}"));
                assert_eq!(config.swarm.id.as_deref(), swarm);
                assert_eq!(config.adopt.len(), 1);
                let endpoints = if computer == Computer::Simulation { 10 } else { 1 };
                assert_eq!(config.endpoints.len(), endpoints);
            }
        }
    }

    #[test]
    fn an_answer_that_is_none_is_refused_and_nothing_is_written() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("node.toml");
        let arguments = |address: &str, vehicles: &str| InitArguments {
            file: file.clone(),
            computer: Some(Computer::Vehicle),
            address: Some(address.to_owned()),
            vehicles: Some(vehicles.to_owned()),
            model: Some("generic-uav".to_owned()),
            swarm: Some("none".to_owned()),
        };
        let serial = "serial:///dev/ttyAMA0?baud=921600";
        for (address, vehicles) in [
            ("carrier pigeon", "7"),
            (serial, "seven"),
            (serial, "9-7"),
            (serial, "7\"\nx = 1"),
        ] {
            assert!(init(&arguments(address, vehicles)).is_err(), "{address} {vehicles}");
            assert!(!file.exists());
        }
        init(&arguments(serial, "7")).expect("is written");
        let before = std::fs::read(&file).expect("is there");
        assert!(init(&arguments(serial, "8")).is_err(), "it is there already");
        assert_eq!(std::fs::read(&file).expect("is there"), before);
    }
}
