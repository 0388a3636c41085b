//! A track that waits for its turn on the disk, a part at a time.
//!
//! Must never do: hold more than one part in memory.

use super::Point;
use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};

/// How points are written that follow on each other.
pub(super) type Part = fn(&mut BufWriter<File>, &[Point]) -> io::Result<()>;

pub(super) struct Spool {
    points: Vec<Point>,
    /// Of the points that wait so many were written before.
    written: usize,
    shape: Shape,
    file: BufWriter<File>,
}

/// How the parts of a track are.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shape {
    /// Points of a part.
    pub span: usize,
    /// A part begins with the point that the part before ended with: between two of them is no line by itself.
    pub joined: bool,
    pub part: Part,
}

impl Spool {
    /// An empty one.
    pub fn new(shape: Shape) -> io::Result<Self> {
        Ok(Self {
            points: Vec::new(),
            written: 0,
            shape,
            // Without a name: it is gone when the program ends, however it ends.
            file: BufWriter::new(tempfile::tempfile()?),
        })
    }

    pub fn add(&mut self, point: Point) -> io::Result<()> {
        self.points.push(point);
        if self.points.len() < self.shape.span {
            return Ok(());
        }
        (self.shape.part)(&mut self.file, &self.points)?;
        self.points.clear();
        if self.shape.joined {
            self.points.push(point);
        }
        self.written = self.points.len();
        Ok(())
    }

    /// Writes all of it.
    pub fn pour(mut self, into: &mut impl Write) -> io::Result<()> {
        if self.points.len() > self.written {
            (self.shape.part)(&mut self.file, &self.points)?;
        }
        let mut file = self.file.into_inner().map_err(io::IntoInnerError::into_error)?;
        file.seek(SeekFrom::Start(0))?;
        io::copy(&mut file, into).map(|_| ())
    }
}
