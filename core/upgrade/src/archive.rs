//! Archives: a gzipped tar of a manifest, then exactly the files that it names. Made, checked, unpacked.
//!
//! Must never do: take a path, a kind of entry or a size from the archive's own headers; leave a part of an archive where a version is looked for.

use crate::manifest::{FILE_NAME, MOST_BYTES, Manifest, ManifestError, PLUGINS, PROGRAM, PackedFile};
use flate2::Compression;
use flate2::read::GzDecoder;
use flate2::write::GzEncoder;
use sha2::{Digest, Sha256};
use skein_view::ArchiveInfo;
use std::fs::{File, OpenOptions};
use std::io::{self, BufReader, Read, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use tar::{Archive, Builder, Entry, EntryType, Header};
use thiserror::Error;

/// Read at once, in bytes.
const BLOCK: usize = 64 << 10;
/// Where a package has the same.
const INSTALLED: [&str; 2] = ["usr/bin/skein", "usr/lib/skein/plugins"];

/// Why an archive is not made or not taken.
#[derive(Debug, Error)]
pub enum ArchiveError {
    /// A file on this computer cannot be read or written.
    #[error("{path}: {source}", path = path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// It cannot be read to its end.
    #[error("it cannot be read: {0}")]
    Unreadable(io::Error),
    /// Its manifest is wrong.
    #[error(transparent)]
    Manifest(#[from] ManifestError),
    /// Something else comes where a file of the manifest should.
    #[error("{found} comes where {expected} should")]
    Unexpected {
        /// What comes.
        found: String,
        /// What should.
        expected: String,
    },
    /// A file is not what the manifest says.
    #[error("{path} is not the file of the manifest")]
    Changed {
        /// Which.
        path: String,
    },
    /// The program is for no processor that is known here, or for another one than the manifest says.
    #[error("its program is for {0}")]
    Program(String),
}

/// Makes an archive of `skein` and `plugins/*.so` in a folder, or of an unpacked package.
///
/// # Errors
/// When there is no program, or a file cannot be read or written.
pub fn pack(folder: &Path, version: &str, into: &Path) -> Result<ArchiveInfo, ArchiveError> {
    let files = found(folder)?;
    let mut packed = Vec::new();
    for (name, path) in &files {
        let (bytes, sha256) = digest_of(path)?;
        packed.push(PackedFile {
            path: name.clone(),
            bytes,
            sha256,
        });
    }
    let program = files.first().map(|(_, path)| path.clone()).unwrap_or_default();
    let head = read_head(&program)?;
    let architecture = processor(&head).map_err(ArchiveError::Program)?;
    let manifest = Manifest::new(version.to_owned(), architecture.to_owned(), packed)?;
    let failed = |source| ArchiveError::File {
        path: into.to_owned(),
        source,
    };
    write(&manifest, &files, into).map_err(failed)?;
    // What was written is what is read: so that nobody carries a bad one to the field.
    check(into).map(|(_, info)| info)
}

fn found(folder: &Path) -> Result<Vec<(String, PathBuf)>, ArchiveError> {
    let [program, plugins] = INSTALLED.map(|path| folder.join(path));
    let (program, plugins) = if program.is_file() {
        (program, plugins)
    } else {
        (folder.join(PROGRAM), folder.join(PLUGINS))
    };
    if !program.is_file() {
        let source = io::Error::new(io::ErrorKind::NotFound, "there is no program");
        return Err(ArchiveError::File { path: program, source });
    }
    let mut files = vec![(PROGRAM.to_owned(), program)];
    let entries = std::fs::read_dir(&plugins).map_err(|source| ArchiveError::File {
        path: plugins.clone(),
        source,
    })?;
    let mut libraries: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    libraries.retain(|path| path.extension().is_some_and(|end| end == "so") && path.is_file());
    libraries.sort();
    for path in libraries {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        files.push((format!("{PLUGINS}/{name}"), path));
    }
    Ok(files)
}

fn write(manifest: &Manifest, files: &[(String, PathBuf)], into: &Path) -> io::Result<()> {
    let text = serde_json::to_vec_pretty(manifest)?;
    let file = File::create(into)?;
    let mut archive = Builder::new(GzEncoder::new(io::BufWriter::new(file), Compression::default()));
    archive.append_data(&mut header(text.len() as u64, 0o644), FILE_NAME, text.as_slice())?;
    for (name, path) in files {
        let file = File::open(path)?;
        let mode = if name == PROGRAM { 0o755 } else { 0o644 };
        archive.append_data(&mut header(file.metadata()?.len(), mode), name, file)?;
    }
    let written = archive.into_inner()?.finish()?;
    written.into_inner().map_err(io::IntoInnerError::into_error)?.sync_all()
}

/// Without names and times: the same files make the same archive.
fn header(bytes: u64, mode: u32) -> Header {
    let mut header = Header::new_gnu();
    header.set_entry_type(EntryType::Regular);
    header.set_size(bytes);
    header.set_mode(mode);
    header.set_mtime(0);
    header
}

/// Reads an archive to its end and checks everything in it.
///
/// # Errors
/// When anything is not as its manifest says.
pub fn check(path: &Path) -> Result<(Manifest, ArchiveInfo), ArchiveError> {
    let (bytes, digest) = digest_of(path)?;
    let manifest = read_through(path, |_| Ok(Box::new(io::sink())))?;
    let info = ArchiveInfo {
        digest,
        version: manifest.version.clone(),
        architecture: manifest.architecture.clone(),
        bytes,
        unpacked_bytes: manifest.unpacked_bytes(),
    };
    Ok((manifest, info))
}

/// Unpacks an archive into a folder that is empty, and returns when the disk has it.
///
/// # Errors
/// When anything is not as its manifest says; what is in the folder then is of no use.
pub fn unpack(path: &Path, folder: &Path) -> Result<Manifest, ArchiveError> {
    let failed = |path: PathBuf| {
        move |source| ArchiveError::File {
            path: path.clone(),
            source,
        }
    };
    let plugins = folder.join(PLUGINS);
    std::fs::create_dir(&plugins).map_err(failed(plugins.clone()))?;
    let manifest = read_through(path, |name| {
        // The name is of the manifest, where it was checked. Nothing that is there already is opened.
        let to = folder.join(name);
        let mode = if name == PROGRAM { 0o755 } else { 0o644 };
        let made = OpenOptions::new().write(true).create_new(true).mode(mode).open(&to);
        let file = made.map_err(failed(to))?;
        Ok(Box::new(Synced(file)))
    })?;
    let text = serde_json::to_vec_pretty(&manifest).map_err(|e| ArchiveError::Unreadable(e.into()))?;
    let to = folder.join(FILE_NAME);
    let stored = File::create_new(&to).and_then(|mut file| file.write_all(&text).and_then(|()| file.sync_all()));
    stored.map_err(failed(to))?;
    for folder in [plugins, folder.to_owned()] {
        let synced = File::open(&folder).and_then(|folder| folder.sync_all());
        synced.map_err(failed(folder))?;
    }
    Ok(manifest)
}

/// A file that is on the disk when it is flushed.
struct Synced(File);

impl Write for Synced {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.sync_all()
    }
}

/// Goes through an archive; each file of its manifest is written to what `to` makes for it, and compared with the manifest.
fn read_through(
    path: &Path,
    mut to: impl FnMut(&str) -> Result<Box<dyn Write>, ArchiveError>,
) -> Result<Manifest, ArchiveError> {
    let file = File::open(path).map_err(|source| ArchiveError::File {
        path: path.to_owned(),
        source,
    })?;
    let mut archive = Archive::new(GzDecoder::new(BufReader::new(file)));
    // Raw: an entry that gives the next one a longer name is none of ours, and would be read into memory.
    let mut entries = archive.entries().map_err(ArchiveError::Unreadable)?.raw(true);
    let mut next = |expected: &str| -> Result<Entry<'_, _>, ArchiveError> {
        let unexpected = |found: String| ArchiveError::Unexpected {
            found,
            expected: expected.to_owned(),
        };
        let entry = entries.next().ok_or_else(|| unexpected("the end".into()))?;
        let entry = entry.map_err(ArchiveError::Unreadable)?;
        let is_file = entry.header().entry_type() == EntryType::Regular;
        let name = String::from_utf8_lossy(&entry.path_bytes()).into_owned();
        match is_file && name == expected {
            true => Ok(entry),
            false => Err(unexpected(format!("{name:?} ({:?})", entry.header().entry_type()))),
        }
    };
    let mut text = Vec::new();
    let read = next(FILE_NAME)?.take(MOST_BYTES + 1).read_to_end(&mut text);
    read.map_err(ArchiveError::Unreadable)?;
    if text.len() as u64 > MOST_BYTES {
        return Err(ManifestError::TooLarge(MOST_BYTES).into());
    }
    let manifest = Manifest::read(&text)?;
    for file in &manifest.files {
        let mut entry = next(&file.path)?;
        let mut into = to(&file.path)?;
        let head = copy(&mut entry, file, into.as_mut())?;
        if file.path == PROGRAM {
            let is = processor(&head).map_err(ArchiveError::Program)?;
            if is != manifest.architecture {
                return Err(ArchiveError::Program(format!("{is}, not {}", manifest.architecture)));
            }
        }
    }
    match entries.next() {
        None => Ok(manifest),
        Some(_) => Err(ArchiveError::Unexpected {
            found: "something more".into(),
            expected: "the end".into(),
        }),
    }
}

/// Copies one file, no more of it than the manifest says, and compares it. Gives how it begins.
fn copy(from: &mut impl Read, file: &PackedFile, into: &mut dyn Write) -> Result<Vec<u8>, ArchiveError> {
    let changed = || ArchiveError::Changed {
        path: file.path.clone(),
    };
    let (mut digest, mut left, mut head) = (Sha256::new(), file.bytes, Vec::new());
    let mut block = vec![0; BLOCK];
    loop {
        let count = from.read(&mut block).map_err(ArchiveError::Unreadable)?;
        let Some(read) = block.get(..count).filter(|read| !read.is_empty()) else {
            break;
        };
        left = left.checked_sub(count as u64).ok_or_else(changed)?;
        digest.update(read);
        if head.len() < HEAD {
            head.extend_from_slice(read);
        }
        let failed = |source| ArchiveError::File {
            path: file.path.clone().into(),
            source,
        };
        into.write_all(read).map_err(failed)?;
    }
    into.flush().map_err(|source| ArchiveError::File {
        path: file.path.clone().into(),
        source,
    })?;
    match left == 0 && hexadecimal(&digest.finalize()).eq_ignore_ascii_case(&file.sha256) {
        true => Ok(head),
        false => Err(changed()),
    }
}

/// Size and SHA-256 of a file.
pub(crate) fn digest_of(path: &Path) -> Result<(u64, String), ArchiveError> {
    let failed = |source| ArchiveError::File {
        path: path.to_owned(),
        source,
    };
    let mut file = File::open(path).map_err(failed)?;
    let (mut digest, mut bytes, mut block) = (Sha256::new(), 0_u64, vec![0; BLOCK]);
    loop {
        let count = file.read(&mut block).map_err(failed)?;
        let Some(read) = block.get(..count).filter(|read| !read.is_empty()) else {
            return Ok((bytes, hexadecimal(&digest.finalize())));
        };
        digest.update(read);
        bytes += count as u64;
    }
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// What is looked at of a program, in bytes.
const HEAD: usize = 20;

fn read_head(path: &Path) -> Result<Vec<u8>, ArchiveError> {
    let mut head = Vec::new();
    let read = File::open(path).and_then(|file| file.take(HEAD as u64).read_to_end(&mut head));
    read.map(|_| head).map_err(|source| ArchiveError::File {
        path: path.to_owned(),
        source,
    })
}

/// The processor that a program is for, by its ELF header, as Rust calls it.
fn processor(head: &[u8]) -> Result<&'static str, String> {
    let is_elf = head.starts_with(b"\x7fELF\x02\x01");
    let machine = head.get(18..HEAD).filter(|_| is_elf);
    match machine {
        Some([0x3e, 0]) => Ok("x86_64"),
        Some([0xb7, 0]) => Ok("aarch64"),
        Some(other) => Err(format!("a processor that is not known here ({other:02x?})")),
        None => Err("no 64-bit processor of Linux: it is no ELF file".into()),
    }
}

#[cfg(test)]
pub(crate) mod tests;
