//! The handshake: what a host reads of a library before it calls anything in it.

use crate::{EntryPoints, PluginTable};

/// Version of the binary interface; see `ABI.md` for its history and when it changes. Apart from the crates' versions.
pub const ABI_VERSION: u32 = 2;

/// First bytes of every handshake, of every version.
pub const MAGIC: [u8; 8] = *b"SKEINPLG";

/// Name of the one symbol a plugin exports: a static [`Handshake`].
pub const ENTRY_SYMBOL: &str = "SKEIN_PLUGIN";

/// Bytes of [`Handshake::target`].
pub const TARGET_LEN: usize = 32;

/// [`Handshake::endianness`]: least significant byte first.
pub const ENDIAN_LITTLE: u8 = 1;
/// [`Handshake::endianness`]: most significant byte first.
pub const ENDIAN_BIG: u8 = 2;

/// [`Handshake::panic_strategy`]: a panic unwinds and can be caught.
pub const PANIC_UNWIND: u8 = 1;
/// [`Handshake::panic_strategy`]: a panic ends the process. No host takes such a plugin.
pub const PANIC_ABORT: u8 = 2;

/// What a plugin is for. A number, not an enum: a library may hold one that this host does not know.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(transparent)]
pub struct PluginKind(pub u32);

impl PluginKind {
    /// Flies one vehicle: its flight state machine.
    pub const UAV_MODEL: Self = Self(1);
    /// Points a payload.
    pub const GIMBAL: Self = Self(2);
    /// Takes pictures or video.
    pub const CAMERA: Self = Self(3);
    /// Carries data between vehicles or to the ground.
    pub const RADIO: Self = Self(4);
    /// Finds things in frames.
    pub const DETECTOR: Self = Self(5);

    /// Every kind this version has a word for, with the word.
    pub const ALL: &'static [(Self, &'static str)] = &[
        (Self::UAV_MODEL, "uav_model"),
        (Self::GIMBAL, "gimbal"),
        (Self::CAMERA, "camera"),
        (Self::RADIO, "radio"),
        (Self::DETECTOR, "detector"),
    ];

    /// The word for it, if this version has one.
    #[must_use]
    pub fn word(self) -> Option<&'static str> {
        Self::ALL.iter().find(|(kind, _)| *kind == self).map(|(_, word)| *word)
    }
}

impl std::fmt::Display for PluginKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.word() {
            Some(word) => f.write_str(word),
            None => write!(f, "kind {}", self.0),
        }
    }
}

/// What a library says of itself. The first three fields are the same in every version for ever.
#[derive(Debug)]
#[repr(C)]
pub struct Handshake {
    /// [`MAGIC`].
    pub magic: [u8; 8],
    /// [`ABI_VERSION`] the plugin was built with.
    pub abi_version: u32,
    /// Size of this struct in bytes, as the plugin has it.
    pub handshake_size: u32,
    /// Size of [`PluginTable`] in bytes, as the plugin has it.
    pub table_size: u32,
    /// What the plugin is for: a [`PluginKind`].
    pub kind: u32,
    /// Bits of a pointer.
    pub pointer_bits: u8,
    /// [`ENDIAN_LITTLE`] or [`ENDIAN_BIG`].
    pub endianness: u8,
    /// [`PANIC_UNWIND`] or [`PANIC_ABORT`].
    pub panic_strategy: u8,
    /// Zero.
    pub reserved: [u8; 5],
    /// Architecture and operating system in words, for people: `x86_64-linux`, filled up with zeros.
    pub target: [u8; TARGET_LEN],
    /// The entry points. Not to be followed before everything above was found right.
    pub table: *const PluginTable,
}

// SAFETY: a handshake is constant data; the table it points to is constant too.
unsafe impl Sync for Handshake {}
// SAFETY: as above.
unsafe impl Send for Handshake {}

/// Why a handshake does not fit this host.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum HandshakeMismatch {
    /// It does not begin with [`MAGIC`].
    Magic,
    /// Another version of the interface.
    AbiVersion {
        /// The host's.
        expected: u32,
        /// The plugin's.
        found: u32,
    },
    /// A struct has another size than its version says.
    StructSize {
        /// Which struct.
        name: &'static str,
        /// Size in the host.
        expected: u32,
        /// Size in the plugin.
        found: u32,
    },
    /// Built for another machine.
    Target {
        /// The plugin's target in words.
        found: String,
    },
    /// A panic in it would end the process.
    PanicAborts,
    /// The table of entry points, or one of them, is missing.
    NoTable,
}

impl std::fmt::Display for HandshakeMismatch {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Magic => write!(f, "its {ENTRY_SYMBOL} is not a handshake of this program"),
            Self::AbiVersion { expected, found } => write!(f, "it has ABI version {found}, this host has {expected}"),
            Self::StructSize { name, expected, found } => {
                write!(f, "its {name} has {found} bytes instead of {expected}")
            }
            Self::Target { found } => write!(f, "it is built for {found}"),
            Self::PanicAborts => write!(
                f,
                "it is built with panic = \"abort\", so that a panic would end the process"
            ),
            Self::NoTable => write!(f, "it lacks an entry point"),
        }
    }
}

impl std::error::Error for HandshakeMismatch {}

impl Handshake {
    /// The handshake of a plugin of `kind`, built here and now, with these entry points.
    #[must_use]
    pub const fn new(kind: PluginKind, table: &'static PluginTable) -> Self {
        Self {
            magic: MAGIC,
            abi_version: ABI_VERSION,
            handshake_size: size_of::<Self>() as u32,
            table_size: size_of::<PluginTable>() as u32,
            kind: kind.0,
            pointer_bits: usize::BITS as u8,
            endianness: if cfg!(target_endian = "little") {
                ENDIAN_LITTLE
            } else {
                ENDIAN_BIG
            },
            panic_strategy: if cfg!(panic = "unwind") {
                PANIC_UNWIND
            } else {
                PANIC_ABORT
            },
            reserved: [0; 5],
            target: target(),
            table,
        }
    }

    /// The handshake in these bytes of a library's file, if it has this version's magic, number and size: only then is the rest of it
    /// looked at. Its table is of no use: a library's pointers are made when it is loaded.
    pub fn from_file(bytes: &[u8]) -> Result<Self, HandshakeMismatch> {
        let Some(prefix) = bytes.get(..size_of::<Prefix>()) else {
            return Err(HandshakeMismatch::Magic);
        };
        // SAFETY: as long as a prefix; any bytes make one.
        unsafe { prefix.as_ptr().cast::<Prefix>().read_unaligned() }.check()?;
        let Some(whole) = bytes.get(..size_of::<Self>()) else {
            return Err(HandshakeMismatch::Magic);
        };
        // SAFETY: as long as a handshake; any bytes make one, the pointer in it is not followed.
        let handshake = unsafe { whole.as_ptr().cast::<Self>().read_unaligned() };
        Ok(Self {
            table: std::ptr::null(),
            ..handshake
        })
    }

    /// The handshake of a loaded library.
    ///
    /// # Safety
    /// `symbol` must be the address of a data symbol of a library that stays loaded for ever.
    pub unsafe fn of_loaded(symbol: *const Self) -> Result<&'static Self, HandshakeMismatch> {
        if symbol.is_null() || !symbol.is_aligned() {
            return Err(HandshakeMismatch::Magic);
        }
        // SAFETY: aligned and not null; every data symbol of a library is followed by at least the rest of its page, and a
        // handshake of any version begins with this prefix.
        unsafe { symbol.cast::<Prefix>().read() }.check()?;
        // SAFETY: a handshake of this version and size, constant, in a library that stays.
        Ok(unsafe { &*symbol })
    }

    /// Whether a plugin with this handshake may be loaded into a host built with this crate.
    pub fn check(&self) -> Result<(), HandshakeMismatch> {
        let Self {
            magic,
            abi_version,
            handshake_size,
            ..
        } = *self;
        Prefix {
            magic,
            abi_version,
            handshake_size,
        }
        .check()?;
        struct_size("table", size_of::<PluginTable>(), self.table_size)?;
        let endianness = if cfg!(target_endian = "little") {
            ENDIAN_LITTLE
        } else {
            ENDIAN_BIG
        };
        if u32::from(self.pointer_bits) != usize::BITS || self.endianness != endianness || self.target != target() {
            return Err(HandshakeMismatch::Target {
                found: self.target_text(),
            });
        }
        if self.panic_strategy != PANIC_UNWIND {
            return Err(HandshakeMismatch::PanicAborts);
        }
        Ok(())
    }

    /// The entry points, if [`Self::check`] finds nothing and none is missing.
    pub fn entry_points(&'static self) -> Result<EntryPoints, HandshakeMismatch> {
        self.check()?;
        if self.table.is_null() || !self.table.is_aligned() {
            return Err(HandshakeMismatch::NoTable);
        }
        // SAFETY: not null, aligned, and of the size this version gives it; constant data of the library, which stays loaded.
        unsafe { &*self.table }.complete().ok_or(HandshakeMismatch::NoTable)
    }

    /// The target in words.
    #[must_use]
    pub fn target_text(&self) -> String {
        let text = self.target.split(|b| *b == 0).next().unwrap_or_default();
        String::from_utf8_lossy(text).into_owned()
    }
}

/// What is the same in every version.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
struct Prefix {
    magic: [u8; 8],
    abi_version: u32,
    handshake_size: u32,
}

impl Prefix {
    fn check(&self) -> Result<(), HandshakeMismatch> {
        if self.magic != MAGIC {
            return Err(HandshakeMismatch::Magic);
        }
        if self.abi_version != ABI_VERSION {
            return Err(HandshakeMismatch::AbiVersion {
                expected: ABI_VERSION,
                found: self.abi_version,
            });
        }
        struct_size("handshake", size_of::<Handshake>(), self.handshake_size)
    }
}

fn struct_size(name: &'static str, expected: usize, found: u32) -> Result<(), HandshakeMismatch> {
    let expected = expected as u32;
    if expected == found {
        Ok(())
    } else {
        Err(HandshakeMismatch::StructSize { name, expected, found })
    }
}

/// Architecture and operating system of this build, filled up with zeros.
#[must_use]
pub const fn target() -> [u8; TARGET_LEN] {
    let (arch, os) = (std::env::consts::ARCH.as_bytes(), std::env::consts::OS.as_bytes());
    let mut text = [0; TARGET_LEN];
    let mut at = 0;
    let mut i = 0;
    while i < arch.len() && at < TARGET_LEN {
        text[at] = arch[i];
        at += 1;
        i += 1;
    }
    if at < TARGET_LEN {
        text[at] = b'-';
        at += 1;
    }
    i = 0;
    while i < os.len() && at < TARGET_LEN {
        text[at] = os[i];
        at += 1;
        i += 1;
    }
    text
}
