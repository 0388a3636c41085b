//! One vehicle as it is found and read: its readers, the check, and its link once it is admitted.
//!
//! Must never do: give the link a sample of a vehicle that is not admitted, or of another one that speaks in its place.

use super::{DdsLinkTable, participant};
use crate::admission::{Admission, Mismatch, Verdict};
use crate::definitions::{self, Command, Release, Topic};
use crate::event::{DdsEvent, EventSink};
use crate::link::DdsLink;
use crate::naming::{Namespace, TopicName};
use crate::raw::{Dds, Raw, Reader};
use crate::sources::{Participant, Sources, Speaker};
use skein_domain::{NodeTime, Refusal, VehicleId};
use skein_px4::LinkSettings;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Wake, Waker};
use std::thread::Thread;

/// Samples of one topic that are read in one pass, at most: a flood on one topic must not hold up the others.
const AT_ONCE: usize = 64;
/// How long topics may be missing before that is told, in seconds.
const INCOMPLETE_S: f64 = 5.0;
/// A reader is looked at so often though nothing was announced, in seconds: under load RustDDS may drop a notice.
const LOOKS_S: f64 = 0.1;
/// `MAV_SEVERITY_ERROR`.
const ERROR: u8 = 3;
/// Programs beside us that are remembered, so that each is told once.
const RIVALS_MAX: usize = 64;
/// One that speaks in the vehicle's place without being an autopilot is told after so long, in seconds: of an autopilot that has just come up
/// discovery may not have shown everything yet.
const STRANGE_AFTER_S: f64 = 2.0;

/// What a vehicle needs around it.
pub struct Around<'a> {
    pub now: NodeTime,
    pub dds: &'a Dds,
    pub settings: &'a LinkSettings,
    pub links: &'a Arc<DdsLinkTable>,
    pub events: &'a EventSink,
}

/// What came of reading.
#[derive(Default)]
pub struct Read {
    /// There was something.
    pub any: bool,
    /// Another one speaks as the vehicle: what it has must be looked at anew.
    pub anew: bool,
}

/// Something has arrived on a topic.
struct Notice {
    arrived: AtomicBool,
    thread: Thread,
}

impl Wake for Notice {
    fn wake(self: Arc<Self>) {
        self.arrived.store(true, Ordering::Release);
        self.thread.unpark();
    }
}

struct Listening {
    name: TopicName,
    reader: Reader,
    notice: Arc<Notice>,
    looked: NodeTime,
}

pub struct DdsVehicle {
    namespace: Namespace,
    since: NodeTime,
    admission: Admission,
    sources: Sources,
    readers: Vec<Listening>,
    /// Once it is admitted.
    link: Option<Arc<DdsLink>>,
    refused: Option<Mismatch>,
    ignored: Vec<Mismatch>,
    missing: Vec<&'static str>,
    rivals: BTreeSet<[u8; 16]>,
    /// Who reads commands in this namespace, which is what tells an autopilot from a recording or a converter.
    obeying: BTreeSet<Participant>,
    /// Who speaks in the vehicle's place without being one, and since when.
    strangers: BTreeMap<Participant, NodeTime>,
}

impl DdsVehicle {
    pub fn new(namespace: Namespace, now: NodeTime) -> Self {
        Self {
            namespace,
            since: now,
            admission: Admission::default(),
            sources: Sources::default(),
            readers: Vec::new(),
            link: None,
            refused: None,
            ignored: Vec::new(),
            missing: Vec::new(),
            rivals: BTreeSet::new(),
            obeying: BTreeSet::new(),
            strangers: BTreeMap::new(),
        }
    }

    /// Discovery is about to be looked at. What it shows of readers comes before what it shows of writers.
    pub fn begin_look(&mut self) {
        self.obeying.clear();
    }

    /// Discovery shows one of its topics.
    pub fn found_writer(
        &mut self,
        around: &mut Around<'_>,
        name: &TopicName,
        who: Participant,
        kind: &str,
        user: &[u8],
    ) {
        if self.sources.known().is_some_and(|known| known != who) {
            // What another one has says nothing about the one that speaks.
            return;
        }
        match self.admission.on_endpoint(name, kind, user) {
            Ok(true) => self.listen(around, name),
            Ok(false) => {}
            Err(mismatch) => self.ignore(around, mismatch),
        }
    }

    /// Discovery shows that somebody reads what it is to be sent. Recorders do, too: only the one that speaks has to read it as we write it.
    pub fn found_reader(&mut self, around: &Around<'_>, name: &TopicName, who: Participant, kind: &str, user: &[u8]) {
        if Command::of(&name.base) == Some(Command::VehicleCommand) && self.obeying.len() < RIVALS_MAX {
            self.obeying.insert(who);
        }
        if self.sources.known() != Some(who) {
            return;
        }
        if let Err(mismatch) = self.admission.on_endpoint(name, kind, user) {
            self.ignore(around, mismatch);
        }
    }

    /// Discovery shows that another program writes to it. Noticed and told, no more: PX4 obeys whoever writes.
    pub fn found_rival(&mut self, around: &Around<'_>, name: &TopicName, guid: [u8; 16]) {
        if Command::of(&name.base).is_some() {
            self.tell_rival(around, name, guid);
        }
    }

    fn tell_rival(&mut self, around: &Around<'_>, name: &TopicName, guid: [u8; 16]) {
        if self.rivals.len() >= RIVALS_MAX || !self.rivals.insert(guid) {
            return;
        }
        if let Some(link) = &self.link {
            link.notice(ERROR, format!("another program writes to {name}"));
        }
        (around.events)(DdsEvent::ForeignPublisher { topic: name.clone() });
    }

    /// A message of one that flies does not fit: told once. Before that it is the check's verdict.
    fn ignore(&mut self, around: &Around<'_>, mismatch: Mismatch) {
        if self.link.is_some() && !self.ignored.contains(&mismatch) && self.ignored.len() < Topic::ALL.len() {
            self.ignored.push(mismatch.clone());
            let namespace = self.namespace.clone();
            (around.events)(DdsEvent::Ignored { namespace, mismatch });
        }
    }

    fn listen(&mut self, around: &mut Around<'_>, name: &TopicName) {
        let known = self.readers.iter().any(|listening| listening.name == *name);
        let Some(topic) = Topic::of(&name.base).filter(|_| !known) else {
            return;
        };
        match around.dds.reader(name, topic.message()) {
            Ok(reader) => self.readers.push(Listening {
                name: name.clone(),
                reader,
                notice: Arc::new(Notice {
                    arrived: AtomicBool::new(true),
                    thread: std::thread::current(),
                }),
                looked: NodeTime::default(),
            }),
            // Tried again with the next look at discovery.
            Err(error) => tracing::warn!(%name, %error, "a topic cannot be read"),
        }
    }

    /// Reads what has arrived.
    pub fn read(&mut self, around: &mut Around<'_>) -> Read {
        let mut read = Read::default();
        let mut readers = std::mem::take(&mut self.readers);
        for listening in &mut readers {
            let arrived = listening.notice.arrived.swap(false, Ordering::AcqRel);
            if !arrived && around.now.seconds_since(listening.looked) < LOOKS_S {
                continue;
            }
            listening.looked = around.now;
            // In this order nothing that comes meanwhile is missed: the waker is there before it is looked.
            listening
                .reader
                .set_waker(Some(Waker::from(Arc::clone(&listening.notice))));
            listening.reader.drain_read_notifications();
            self.take(around, listening, &mut read);
        }
        self.readers = readers;
        if let Some(link) = self.link.clone()
            && self.sources.is_one_again(around.now, around.settings.duplicate_clear_s)
        {
            self.one_again(around, &link);
        }
        read
    }

    fn one_again(&self, around: &Around<'_>, link: &DdsLink) {
        link.set_duplicate(around.now, false);
        let (namespace, system_id) = (self.namespace.clone(), link.system_id_number());
        (around.events)(DdsEvent::DuplicateCleared { namespace, system_id });
    }

    fn take(&mut self, around: &mut Around<'_>, listening: &Listening, read: &mut Read) {
        for _ in 0..AT_ONCE {
            let sample = match listening.reader.try_take_one() {
                Ok(Some(sample)) => sample,
                Ok(None) => return,
                // What RustDDS itself can make nothing of.
                Err(_) => continue,
            };
            read.any = true;
            let (guid, who) = (sample.writer_guid(), participant(&sample.writer_guid()));
            let raw = sample.into_value();
            match self.whose(around.now, who, &listening.name, &raw) {
                Speaker::Known => {}
                Speaker::New => {
                    self.begin_anew(around.now);
                    read.anew = true;
                    return;
                }
                Speaker::Second => {
                    self.two(around);
                    continue;
                }
                Speaker::Other => {
                    self.stranger(around, &listening.name, who, guid.to_bytes());
                    continue;
                }
            }
            let sample = self.admission.on_sample(&listening.name, raw.encoding, &raw.bytes);
            if let (Some(link), Some(sample)) = (&self.link, sample) {
                link.receive(around.now, &sample);
            }
        }
        // There may be more.
        listening.notice.arrived.store(true, Ordering::Release);
    }

    /// Who has spoken. Only an autopilot can be the vehicle in place of another, or a second one: nobody who plays back a recording, translates
    /// messages or writes nonsense takes a vehicle out of the air.
    fn whose(&mut self, now: NodeTime, who: Participant, name: &TopicName, raw: &Raw) -> Speaker {
        match self.sources.known() {
            Some(known) if known != who => {
                if !self.is_autopilot(who, name, raw) {
                    Speaker::Other
                } else if self.obeying.contains(&known) {
                    self.sources.on_sample(now, who)
                } else {
                    self.sources.replace(now, who)
                }
            }
            _ => self.sources.on_sample(now, who),
        }
    }

    /// It reads commands, and says what can be true.
    fn is_autopilot(&self, who: Participant, name: &TopicName, raw: &Raw) -> bool {
        let topic = Topic::of(&name.base).filter(|_| self.obeying.contains(&who));
        let definition = topic.and_then(|topic| definitions::by_size(topic, name.version, raw.bytes.len()));
        definition.is_some_and(|definition| definition.read(raw.encoding, &raw.bytes).is_ok())
    }

    fn stranger(&mut self, around: &Around<'_>, name: &TopicName, who: Participant, guid: [u8; 16]) {
        if self.obeying.contains(&who) || !self.admission.uses(name) {
            return;
        }
        if self.strangers.len() >= RIVALS_MAX && !self.strangers.contains_key(&who) {
            return;
        }
        let since = *self.strangers.entry(who).or_insert(around.now);
        if around.now.seconds_since(since) > STRANGE_AFTER_S {
            self.tell_rival(around, name, guid);
        }
    }

    /// Another one speaks: the first, one that was started anew, or another vehicle. It is looked at like any other.
    fn begin_anew(&mut self, now: NodeTime) {
        self.admission = Admission::default();
        self.since = now;
        if let Some(link) = self.link.take() {
            link.doubt_clock();
        }
        self.refused = None;
        self.ignored.clear();
        self.missing.clear();
        self.strangers.clear();
    }

    /// Of one that is not admitted yet this is told when it is.
    fn two(&mut self, around: &Around<'_>) {
        let Some(link) = &self.link else { return };
        let system_id = link.system_id_number();
        link.set_duplicate(around.now, true);
        let namespace = self.namespace.clone();
        (around.events)(DdsEvent::Duplicate { namespace, system_id });
    }

    /// Looks where the check stands.
    pub fn judge(&mut self, around: &mut Around<'_>) {
        if self.link.is_some() {
            return;
        }
        match self.admission.verdict() {
            Verdict::Open => {
                self.refused = None;
                self.tell_missing(around);
            }
            Verdict::Refused(mismatch) => {
                if self.refused.as_ref() != Some(&mismatch) {
                    self.refused = Some(mismatch.clone());
                    let namespace = self.namespace.clone();
                    (around.events)(DdsEvent::Refused { namespace, mismatch });
                }
            }
            Verdict::Admitted { system_id, releases } => self.admit(around, system_id, releases),
        }
    }

    fn tell_missing(&mut self, around: &Around<'_>) {
        if around.now.seconds_since(self.since) < INCOMPLETE_S {
            return;
        }
        let missing = self.admission.waits_for();
        if missing != self.missing {
            self.missing.clone_from(&missing);
            let namespace = self.namespace.clone();
            (around.events)(DdsEvent::Incomplete { namespace, missing });
        }
    }

    fn admit(&mut self, around: &mut Around<'_>, system_id: u8, releases: Vec<Release>) {
        let known = around.links.get(&self.namespace);
        if let Some(link) = known.clone().filter(|link| link.system_id_number() == system_id) {
            self.link = Some(Arc::clone(&link));
            if self.sources.are_two() {
                self.two(around);
            } else if link.is_duplicate() {
                // Of the two that there were this one is left.
                self.one_again(around, &link);
            }
            return;
        }
        let writers = match around.dds.writers(&self.namespace) {
            Ok(writers) => writers,
            // Tried again with the next look at discovery.
            Err(error) => return tracing::warn!(namespace = %self.namespace, %error, "a vehicle cannot be written to"),
        };
        if let Some(old) = known {
            // Its topics are another vehicle's now, which must not get what is meant for this one.
            let vehicle = VehicleId(u16::from(old.system_id_number()));
            old.refuse_all(around.now, Refusal::LinkLost { vehicle });
        }
        let namespace = self.namespace.clone();
        let link = Arc::new(DdsLink::new(
            around.settings,
            system_id,
            namespace.clone(),
            writers,
            around.now,
        ));
        around.links.put(namespace, Arc::clone(&link));
        self.link = Some(Arc::clone(&link));
        if !self.rivals.is_empty() {
            link.notice(
                ERROR,
                format!("{} other programs write to {}/in", self.rivals.len(), self.namespace),
            );
        }
        (around.events)(DdsEvent::Discovered {
            link,
            system_id,
            releases,
        });
        if self.sources.are_two() {
            self.two(around);
        }
    }
}
