//! The exported side: what the host's calls arrive at. Used through [`export_uav_model!`](crate::export_uav_model).
//!
//! Must never do: run any code of the plugin outside of a guard.

use crate::guard::guard;
use crate::log::Logger;
use crate::uav_model::manifest;
use crate::{Effects, UavModel, decode, log};
use skein_domain::exchange::{
    CREATE_UAV_SCHEMA, CreateUav, EFFECT_BATCH_SCHEMA, EVENT_BATCH_SCHEMA, Event, FaultDrill,
};
use skein_plugin_abi::{
    Buffer, CreateOutcome, Handshake, HostSink, Outcome, PluginHandle, PluginKind, PluginTable, Slice, Status, method,
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

/// The handshake of a UAV model.
#[must_use]
pub const fn uav_model<M: UavModel>() -> Handshake {
    Handshake::new(PluginKind::UAV_MODEL, Exported::<M>::TABLE)
}

struct Exported<M>(PhantomData<M>);

impl<M: UavModel> Exported<M> {
    const TABLE: &'static PluginTable = &PluginTable {
        manifest: Some(manifest_entry::<M>),
        create: Some(create_entry::<M>),
        invoke: Some(invoke_entry::<M>),
        destroy: Some(destroy_entry::<M>),
        free: Some(free_entry),
    };
}

/// What a handle points to.
struct Living<M> {
    model: M,
    logger: Option<Logger>,
    /// It panicked: only `destroy` may follow.
    poisoned: bool,
}

/// A failure on the way through an entry.
type Failure = (Status, String);

unsafe extern "C" fn manifest_entry<M: UavModel>() -> Outcome {
    let bytes = guard(|| minicbor::to_vec(manifest::<M>()));
    match bytes {
        Ok(Ok(bytes)) => Outcome::ok(0, bytes),
        Ok(Err(error)) => Outcome::failed(Status::REFUSED, error.to_string()),
        Err(message) => Outcome::failed(Status::PANICKED, message),
    }
}

unsafe extern "C" fn create_entry<M: UavModel>(sink: *const HostSink, schema: u32, bytes: Slice) -> CreateOutcome {
    // SAFETY: the host keeps the sink valid until `destroy`, or until this call has failed; both close the logger.
    let logger = unsafe { Logger::new(sink) };
    let entered = Logger::enter(logger.clone());
    // SAFETY: the host lends the bytes for the call.
    let result = guard(|| create::<M>(schema, unsafe { bytes.as_bytes() }));
    drop(entered);
    let (status, reason) = match result {
        Ok(Ok(model)) => {
            let living = Box::new(Living {
                model,
                logger,
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
    if let Some(logger) = logger {
        logger.close();
    }
    let buffer = Buffer::from_vec(reason.into_bytes());
    CreateOutcome {
        status: status.0,
        reserved: 0,
        handle: std::ptr::null_mut(),
        buffer,
    }
}

fn create<M: UavModel>(schema: u32, bytes: &[u8]) -> Result<M, Failure> {
    if schema != CREATE_UAV_SCHEMA {
        return Err((Status::UNKNOWN_SCHEMA, format!("{schema}, not {CREATE_UAV_SCHEMA}")));
    }
    let create: CreateUav = minicbor::decode(bytes).map_err(|e| (Status::UNDECODABLE, e.to_string()))?;
    let config =
        serde_json::from_str(&create.config_json).map_err(|e| (Status::REFUSED, format!("configuration: {e}")))?;
    M::create(create, config).map_err(|e| (Status::REFUSED, e.to_string()))
}

unsafe extern "C" fn invoke_entry<M: UavModel>(
    handle: PluginHandle,
    method: u32,
    schema: u32,
    bytes: Slice,
) -> Outcome {
    // SAFETY: the host gives back a handle of `create_entry::<M>`, not destroyed, used by this thread alone.
    let Some(living) = (unsafe { handle.cast::<Living<M>>().as_mut() }) else {
        return Outcome::failed(Status::UNDECODABLE, "the handle is null".to_owned());
    };
    if living.poisoned {
        return Outcome::failed(Status::POISONED, String::new());
    }
    let _entered = Logger::enter(living.logger.clone());
    // SAFETY: the host lends the bytes for the call.
    let result = guard(|| invoke(&mut living.model, method, schema, unsafe { bytes.as_bytes() }));
    match result {
        Ok(Ok((schema, bytes))) => Outcome::ok(schema, bytes),
        Ok(Err((status, reason))) => Outcome::failed(status, reason),
        Err(message) => {
            living.poisoned = true;
            Outcome::failed(Status::PANICKED, message)
        }
    }
}

fn invoke<M: UavModel>(model: &mut M, method: u32, schema: u32, bytes: &[u8]) -> Result<(u32, Vec<u8>), Failure> {
    match method {
        method::HANDLE_EVENTS if schema == EVENT_BATCH_SCHEMA => {
            let batch = decode::event_batch(bytes).map_err(|e| (Status::UNDECODABLE, e.to_string()))?;
            for event in &batch.events {
                if let Event::FaultDrill(drill) = event {
                    fail_on_purpose(*drill);
                }
            }
            let mut effects = Effects::default();
            model.handle(batch.now, &batch.events, &mut effects);
            let bytes = minicbor::to_vec(effects.into_batch()).map_err(|e| (Status::REFUSED, e.to_string()))?;
            Ok((EFFECT_BATCH_SCHEMA, bytes))
        }
        method::HANDLE_EVENTS => Err((Status::UNKNOWN_SCHEMA, format!("{schema}, not {EVENT_BATCH_SCHEMA}"))),
        method::SNAPSHOT => Ok((0, model.snapshot())),
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
    }
}

unsafe extern "C" fn destroy_entry<M: UavModel>(handle: PluginHandle) -> Outcome {
    if handle.is_null() {
        return Outcome::ok(0, Vec::new());
    }
    // SAFETY: the host gives back a handle of `create_entry::<M>` for the last time.
    let living = unsafe { Box::from_raw(handle.cast::<Living<M>>()) };
    let Living { model, logger, .. } = *living;
    let entered = Logger::enter(logger.clone());
    let result = guard(|| drop(model));
    drop(entered);
    if let Some(logger) = logger {
        logger.close();
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
