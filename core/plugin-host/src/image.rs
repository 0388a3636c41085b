//! A library judged from its file, before any code of it runs: whether it is whole, whether it is a plugin, whether its handshake fits.
//! The system's loader would run a library's constructors first, and dies of one that is cut off.
//!
//! Must never do: load or run anything.

use crate::LoadError;
use object::read::elf::ElfFile64;
use object::{Endianness, Object, ObjectKind, ObjectSegment, ObjectSymbol};
use skein_plugin_abi::{ENTRY_SYMBOL, Handshake, PluginKind};

/// Judges the file's bytes; gives the kind of plugin it says it is.
pub(crate) fn judge(file: &[u8]) -> Result<PluginKind, LoadError> {
    let image: ElfFile64<'_, Endianness> = ElfFile64::parse(file).map_err(not_loadable)?;
    if image.kind() != ObjectKind::Dynamic {
        return Err(not_loadable("not a shared library"));
    }
    for segment in image.segments() {
        let (offset, size) = segment.file_range();
        if offset.checked_add(size).is_none_or(|end| end > file.len() as u64) {
            return Err(not_loadable("the file is cut off"));
        }
    }
    let symbol = image
        .dynamic_symbols()
        .find(|symbol| symbol.name() == Ok(ENTRY_SYMBOL) && symbol.is_definition())
        .ok_or(LoadError::MissingSymbol)?;
    let (address, size) = (symbol.address(), symbol.size());
    let bytes = image
        .segments()
        .find_map(|segment| segment.data_range(address, size).ok().flatten());
    let handshake = Handshake::from_file(bytes.unwrap_or_default())?;
    handshake.check()?;
    let kind = PluginKind(handshake.kind);
    if kind.word().is_none() {
        return Err(LoadError::UnknownKind { kind: handshake.kind });
    }
    Ok(kind)
}

fn not_loadable(why: impl std::fmt::Display) -> LoadError {
    LoadError::NotLoadable {
        detail: why.to_string(),
    }
}

#[cfg(test)]
mod tests;
