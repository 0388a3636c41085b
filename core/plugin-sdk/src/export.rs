//! The exported side: what the host's calls arrive at. Used through [`export_uav_model!`](crate::export_uav_model).
//!
//! Must never do: run any code of the plugin outside of a guard.

mod behaviour;

use crate::guard::guard;
use crate::host::Host;
use crate::{Effects, Payload, UavModel, decode, log};
use behaviour::{Behaviour, Carried, Flying};
use skein_domain::exchange::{CREATE_SCHEMA, Create, EFFECT_BATCH_SCHEMA, EVENT_BATCH_SCHEMA, Event, FaultDrill};
use skein_plugin_abi::{
    Buffer, CreateOutcome, Handshake, HostServices, Outcome, PluginHandle, PluginTable, Slice, Status, method,
};
use std::marker::PhantomData;

/// Exports a [`UavModel`] as this library's plugin. The one line of a shim crate.
#[macro_export]
macro_rules! export_uav_model {
    ($model:ty) => {
        /// What the host looks for.
        #[unsafe(no_mangle)]
        pub static SKEIN_PLUGIN: $crate::abi::Handshake = $crate::export::uav_model::<$model>();
    };
}

/// Exports a [`Payload`] as this library's plugin. The one line of a shim crate.
#[macro_export]
macro_rules! export_payload {
    ($payload:ty) => {
        /// What the host looks for.
        #[unsafe(no_mangle)]
        pub static SKEIN_PLUGIN: $crate::abi::Handshake = $crate::export::payload::<$payload>();
    };
}

/// The handshake of a UAV model.
#[must_use]
pub const fn uav_model<M: UavModel>() -> Handshake {
    Handshake::new(Flying::<M>::KIND, Exported::<Flying<M>>::TABLE)
}

/// The handshake of a payload.
#[must_use]
pub const fn payload<P: Payload>() -> Handshake {
    Handshake::new(Carried::<P>::KIND, Exported::<Carried<P>>::TABLE)
}

struct Exported<B>(PhantomData<B>);

impl<B: Behaviour> Exported<B> {
    const TABLE: &'static PluginTable = &PluginTable {
        manifest: Some(manifest_entry::<B>),
        create: Some(create_entry::<B>),
        invoke: Some(invoke_entry::<B>),
        destroy: Some(destroy_entry::<B>),
        free: Some(free_entry),
    };
}

/// What a handle points to.
struct Living<B> {
    behaviour: B,
    host: Option<Host>,
    /// It panicked: only `destroy` may follow.
    poisoned: bool,
}

/// Most answers are shorter, in bytes.
const USUAL_ANSWER_BYTES: usize = 256;

/// A failure on the way through an entry.
type Failure = (Status, String);

unsafe extern "C" fn manifest_entry<B: Behaviour>() -> Outcome {
    let bytes = guard(|| minicbor::to_vec(B::manifest()));
    match bytes {
        Ok(Ok(bytes)) => Outcome::ok(0, bytes),
        Ok(Err(error)) => Outcome::failed(Status::REFUSED, error.to_string()),
        Err(message) => Outcome::failed(Status::PANICKED, message),
    }
}

unsafe extern "C" fn create_entry<B: Behaviour>(
    services: *const HostServices,
    schema: u32,
    bytes: Slice,
) -> CreateOutcome {
    // SAFETY: the host keeps its services valid until `destroy`, or until this call has failed; both close them here.
    let host = unsafe { Host::new(services) };
    let entered = Host::enter(host.clone());
    // SAFETY: the host lends the bytes for the call.
    let result = guard(|| create::<B>(schema, unsafe { bytes.as_bytes() }));
    drop(entered);
    let (status, reason) = match result {
        Ok(Ok(behaviour)) => {
            let living = Box::new(Living {
                behaviour,
                host,
                poisoned: false,
            });
            let handle = Box::into_raw(living).cast();
            return CreateOutcome {
                status: Status::OK.0,
                reserved: 0,
                handle,
                buffer: Buffer::EMPTY,
            };
        }
        Ok(Err(failure)) => failure,
        Err(message) => (Status::PANICKED, message),
    };
    if let Some(host) = host {
        host.close();
    }
    let buffer = Buffer::from_vec(reason.into_bytes());
    CreateOutcome {
        status: status.0,
        reserved: 0,
        handle: std::ptr::null_mut(),
        buffer,
    }
}

fn create<B: Behaviour>(schema: u32, bytes: &[u8]) -> Result<B, Failure> {
    if schema != CREATE_SCHEMA {
        return Err((Status::UNKNOWN_SCHEMA, format!("{schema}, not {CREATE_SCHEMA}")));
    }
    let create: Create = minicbor::decode(bytes).map_err(|e| (Status::UNDECODABLE, e.to_string()))?;
    B::create(create)
}

unsafe extern "C" fn invoke_entry<B: Behaviour>(
    handle: PluginHandle,
    method: u32,
    schema: u32,
    bytes: Slice,
) -> Outcome {
    // SAFETY: the host gives back a handle of `create_entry::<B>`, not destroyed, used by this thread alone.
    let Some(living) = (unsafe { handle.cast::<Living<B>>().as_mut() }) else {
        return Outcome::failed(Status::UNDECODABLE, "the handle is null".to_owned());
    };
    if living.poisoned {
        return Outcome::failed(Status::POISONED, String::new());
    }
    let _entered = Host::enter(living.host.clone());
    // SAFETY: the host lends the bytes for the call.
    let result = guard(|| invoke(&mut living.behaviour, method, schema, unsafe { bytes.as_bytes() }));
    match result {
        Ok(Ok((schema, bytes))) => Outcome::ok(schema, bytes),
        Ok(Err((status, reason))) => Outcome::failed(status, reason),
        Err(message) => {
            living.poisoned = true;
            Outcome::failed(Status::PANICKED, message)
        }
    }
}

fn invoke<B: Behaviour>(behaviour: &mut B, method: u32, schema: u32, bytes: &[u8]) -> Result<(u32, Vec<u8>), Failure> {
    match method {
        method::HANDLE_EVENTS if schema == EVENT_BATCH_SCHEMA => {
            let batch = decode::event_batch(bytes).map_err(|e| (Status::UNDECODABLE, e.to_string()))?;
            for event in &batch.events {
                if let Event::FaultDrill(drill) = event {
                    fail_on_purpose(*drill);
                }
            }
            let mut effects = Effects::with_room();
            behaviour.handle(batch.now, &batch.events, &mut effects);
            // Growing step by step costs more than the encoding.
            let mut bytes = Vec::with_capacity(USUAL_ANSWER_BYTES);
            minicbor::encode(effects.into_batch(), &mut bytes).map_err(|e| (Status::REFUSED, e.to_string()))?;
            Ok((EFFECT_BATCH_SCHEMA, bytes))
        }
        method::HANDLE_EVENTS => Err((Status::UNKNOWN_SCHEMA, format!("{schema}, not {EVENT_BATCH_SCHEMA}"))),
        method::SNAPSHOT => Ok((0, behaviour.snapshot())),
        other => Err((Status::UNKNOWN_METHOD, other.to_string())),
    }
}

/// A drill takes the very ways that a fault would take.
fn fail_on_purpose(drill: FaultDrill) {
    log::warn!("fault drill: {drill:?}");
    match drill {
        FaultDrill::Panic => panic!("fault drill"),
        FaultDrill::Hang => loop {
            std::thread::park();
        },
        FaultDrill::Abort => std::process::abort(),
    }
}

unsafe extern "C" fn destroy_entry<B: Behaviour>(handle: PluginHandle) -> Outcome {
    if handle.is_null() {
        return Outcome::ok(0, Vec::new());
    }
    // SAFETY: the host gives back a handle of `create_entry::<B>` for the last time.
    let living = unsafe { Box::from_raw(handle.cast::<Living<B>>()) };
    let Living { behaviour, host, .. } = *living;
    let entered = Host::enter(host.clone());
    let result = guard(|| drop(behaviour));
    drop(entered);
    if let Some(host) = host {
        host.close();
    }
    match result {
        Ok(()) => Outcome::ok(0, Vec::new()),
        Err(message) => Outcome::failed(Status::PANICKED, message),
    }
}

unsafe extern "C" fn free_entry(buffer: Buffer) {
    // SAFETY: the host gives back a buffer that an entry of this library made with `Buffer::from_vec`, once.
    drop(unsafe { buffer.into_vec() });
}

#[cfg(test)]
mod tests;
