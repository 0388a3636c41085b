//! The device's language. CHANGE: yours.
//!
//! This light speaks in lines: `SET 0.50` and `ASK` to it, `AT 0.50 31.5` (brightness, temperature) from it.
//!
//! Must never do: trust what comes in. A line may be cut, garbage, or endless.

/// A longer line is none.
const LONGEST_LINE: usize = 64;

/// Asks it to be so bright.
pub(crate) fn set(brightness: f64) -> Vec<u8> {
    format!("SET {brightness:.2}\n").into_bytes()
}

/// Asks how it is.
pub(crate) fn ask() -> Vec<u8> {
    b"ASK\n".to_vec()
}

/// How it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Answer {
    pub brightness: f64,
    pub temperature_c: f64,
}

impl Answer {
    fn parse(line: &[u8]) -> Option<Self> {
        let mut words = std::str::from_utf8(line).ok()?.split_whitespace();
        let at = words.next()?;
        let mut number = || words.next()?.parse::<f64>().ok().filter(|value| value.is_finite());
        let answer = Self {
            brightness: number()?,
            temperature_c: number()?,
        };
        (at == "AT").then_some(answer)
    }
}

/// Puts lines together: a serial line gives bytes as they come.
#[derive(Debug, Default)]
pub(crate) struct Lines(Vec<u8>);

impl Lines {
    /// The answers that are complete with these bytes.
    pub(crate) fn take(&mut self, bytes: &[u8]) -> Vec<Answer> {
        let mut answers = Vec::new();
        for byte in bytes {
            if *byte == b'\n' {
                answers.extend(Answer::parse(&self.0));
                self.0.clear();
            } else if self.0.len() < LONGEST_LINE {
                self.0.push(*byte);
            }
        }
        answers
    }
}
