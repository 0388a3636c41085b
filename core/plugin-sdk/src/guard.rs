//! The guard around every entry: a panic ends in a message for the host, with its place, and never leaves the plugin.
//!
//! Must never do: drop the payload of a panic that could panic again.

use std::cell::{Cell, RefCell};
use std::panic::{AssertUnwindSafe, PanicHookInfo, catch_unwind};
use std::sync::Once;

thread_local! {
    /// How many guards this thread is inside of.
    static DEPTH: Cell<u32> = const { Cell::new(0) };
    /// What the hook saw of the last panic under a guard.
    static SEEN: RefCell<Option<String>> = const { RefCell::new(None) };
}

static HOOK: Once = Once::new();

/// Runs `work`; a panic in it comes back as its message and place.
pub(crate) fn guard<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    HOOK.call_once(install_hook);
    DEPTH.set(DEPTH.get().saturating_add(1));
    // What a panic may have left half done is never used again: the caller poisons the instance.
    let result = catch_unwind(AssertUnwindSafe(work));
    DEPTH.set(DEPTH.get().saturating_sub(1));
    result.map_err(|payload| {
        let seen = SEEN.with_borrow_mut(Option::take);
        let text = payload
            .downcast_ref::<&str>()
            .map(|s| (*s).to_owned())
            .or_else(|| payload.downcast_ref::<String>().cloned());
        // Dropping a value of an unknown type could panic, outside of any guard.
        std::mem::forget(payload);
        seen.or(text).unwrap_or_else(|| "a panic without a message".to_owned())
    })
}

/// Under a guard the message is kept for the host and not printed; elsewhere the former hook goes on as before. The plugin has its own
/// copy of the standard library, so that this is not the host's hook.
fn install_hook() {
    let former = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        if DEPTH.try_with(Cell::get).unwrap_or(0) == 0 {
            former(info);
        } else {
            let _ = SEEN.try_with(|seen| seen.try_borrow_mut().map(|mut seen| *seen = Some(describe(info))));
        }
    }));
}

fn describe(info: &PanicHookInfo<'_>) -> String {
    let message = info.payload_as_str().unwrap_or("a panic without a message");
    match info.location() {
        Some(place) => format!("{message} ({}:{})", place.file(), place.line()),
        None => message.to_owned(),
    }
}

#[cfg(test)]
mod tests;
