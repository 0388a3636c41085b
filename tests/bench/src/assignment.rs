//! Assignments of vehicles to slots beside SciPy's `linear_sum_assignment`, in the same run on the same machine: the same places, the
//! same costs, and the same least total, or else the bench fails.

use crate::error::BenchError;
use serde::{Deserialize, Serialize};
use skein_domain::{FormationRequest, OffsetFrd, Shape};
use skein_flight::assignment::{Assignment, Costs, Total, least_longest, least_total};
use std::fmt;
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::Instant;

/// The other side, for a Python that has SciPy.
const SCIPY: &str = include_str!("assignment/scipy.py");
/// How many vehicles, and how often each is solved; the quickest time counts.
const SIZES: [(usize, u32); 4] = [(100, 50), (200, 20), (500, 5), (1000, 5)];
/// Totals may differ by this share.
const ROUNDING: f64 = 1e-6;

/// What to run.
#[derive(Debug, Clone)]
pub struct AssignmentBenchArgs {
    /// A Python with SciPy.
    pub python: PathBuf,
}

/// What one problem came to.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AssignmentFigures {
    /// What the problem is.
    pub problem: &'static str,
    /// How many vehicles and slots.
    pub vehicles: usize,
    /// Least sum of squares, in milliseconds.
    pub total_ms: f64,
    /// Least longest way and then least sum of squares, in milliseconds.
    pub longest_ms: f64,
    /// SciPy's least sum of squares, in milliseconds.
    pub scipy_ms: f64,
    /// How many times as long the least sum of squares takes as SciPy's.
    pub total_ratio: f64,
    /// The same for the shortest longest distance.
    pub longest_ratio: f64,
}

/// The whole bench.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AssignmentBenchReport {
    /// Version of SciPy.
    pub scipy: String,
    /// One entry per problem.
    pub figures: Vec<AssignmentFigures>,
}

impl fmt::Display for AssignmentBenchReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "Assignments, beside linear_sum_assignment of SciPy {}:", self.scipy)?;
        writeln!(
            f,
            "{:<24} {:>8} {:>10} {:>10} {:>10} {:>8} {:>8}",
            "", "vehicles", "total ms", "longest ms", "SciPy ms", "total", "longest"
        )?;
        for figures in &self.figures {
            writeln!(
                f,
                "{:<24} {:>8} {:>10.3} {:>10.3} {:>10.3} {:>7.2}x {:>7.2}x",
                figures.problem,
                figures.vehicles,
                figures.total_ms,
                figures.longest_ms,
                figures.scipy_ms,
                figures.total_ratio,
                figures.longest_ratio
            )?;
        }
        Ok(())
    }
}

/// A problem as SciPy's side is given it.
#[derive(Serialize)]
struct Problem {
    #[serde(skip)]
    name: &'static str,
    from: Vec<[f64; 3]>,
    slots: Vec<[f64; 3]>,
    rounds: u32,
}

#[derive(Deserialize)]
struct Answers {
    version: String,
    answers: Vec<Answer>,
}

#[derive(Deserialize)]
struct Answer {
    seconds: f64,
    total: f64,
}

/// Solves all problems on both sides.
///
/// # Errors
/// When Python cannot be started or lacks SciPy, or when the two sides' totals differ.
pub fn run_assignment_bench(args: &AssignmentBenchArgs) -> Result<AssignmentBenchReport, BenchError> {
    let problems = problems();
    let theirs = scipy(args, &problems)?;
    let mut figures = Vec::with_capacity(problems.len());
    for (problem, answer) in problems.iter().zip(&theirs.answers) {
        figures.push(measured(problem, answer)?);
    }
    Ok(AssignmentBenchReport {
        scipy: theirs.version,
        figures,
    })
}

fn measured(problem: &Problem, answer: &Answer) -> Result<AssignmentFigures, BenchError> {
    let offsets =
        |places: &[[f64; 3]]| -> Vec<OffsetFrd> { places.iter().map(|[f, r, d]| OffsetFrd::new(*f, *r, *d)).collect() };
    let costs = Costs::between(&offsets(&problem.from), &offsets(&problem.slots));
    let (found, total_ms) = quickest(problem.rounds, || least_total(&costs, Total::Squares));
    let (_, longest_ms) = quickest(problem.rounds, || least_longest(&costs, Total::Squares));
    let taken = found.slots.iter().enumerate();
    let ways = taken.filter_map(|(vehicle, slot)| slot.map(|slot| costs.length(vehicle, slot)));
    let total: f64 = ways.map(|way| way * way).sum();
    if (total - answer.total).abs() > ROUNDING * answer.total {
        return Err(BenchError::Child {
            part: "assignment",
            detail: format!("a total of {total} m², where SciPy has {} m²", answer.total),
        });
    }
    let scipy_ms = answer.seconds * 1e3;
    Ok(AssignmentFigures {
        problem: problem.name,
        vehicles: problem.from.len(),
        total_ms,
        longest_ms,
        scipy_ms,
        total_ratio: total_ms / scipy_ms,
        longest_ratio: longest_ms / scipy_ms,
    })
}

/// The last answer and the least time of all rounds, in milliseconds.
fn quickest(rounds: u32, solve: impl Fn() -> Assignment) -> (Assignment, f64) {
    let mut least_ms = f64::INFINITY;
    let mut answer = solve();
    for _ in 0..rounds {
        let begun = Instant::now();
        answer = solve();
        least_ms = least_ms.min(begun.elapsed().as_secs_f64() * 1e3);
    }
    (answer, least_ms)
}

fn scipy(args: &AssignmentBenchArgs, problems: &[Problem]) -> Result<Answers, BenchError> {
    let mut child = Command::new(&args.python)
        .args(["-c", SCIPY])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .map_err(|source| BenchError::Start {
            program: args.python.clone(),
            source,
        })?;
    let text = serde_json::to_vec(problems).map_err(BenchError::Settings)?;
    let system = |what| move |source| BenchError::System { what, source };
    if let Some(mut stdin) = child.stdin.take() {
        stdin
            .write_all(&text)
            .map_err(system("giving the problems to Python"))?;
    }
    let output = child.wait_with_output().map_err(system("waiting for Python"))?;
    if !output.status.success() {
        return Err(BenchError::Child {
            part: "Python",
            detail: format!(
                "{}; it needs SciPy: python3 -m venv DIR && DIR/bin/pip install scipy, then --python DIR/bin/python",
                output.status
            ),
        });
    }
    serde_json::from_slice(&output.stdout).map_err(BenchError::Settings)
}

/// From loose to very regular: random places, and formations into others. In the last ones very many ways are equally long.
fn problems() -> Vec<Problem> {
    let mut problems = Vec::new();
    for (vehicles, rounds) in SIZES {
        let shape = |shape, spacing_m| {
            let slots = skein_flight::formation::slots(&FormationRequest::new(shape, spacing_m), vehicles);
            plain(&slots.unwrap_or_default())
        };
        let mut random = Random(vehicles as u64);
        let size_m = 10.0 * (vehicles as f64).sqrt();
        let mut places = || -> Vec<[f64; 3]> {
            (0..vehicles)
                .map(|_| [random.next() * size_m, random.next() * size_m, 0.0])
                .collect()
        };
        let grid = shape(Shape::Grid, 5.0);
        for (name, from, slots) in [
            ("random", places(), places()),
            ("random to grid", places(), grid.clone()),
            ("grid to circle", grid.clone(), shape(Shape::Circle, 5.0)),
            ("circle to line", shape(Shape::Circle, 5.0), shape(Shape::Line, 5.0)),
            ("wedge to column", shape(Shape::Wedge, 5.0), shape(Shape::Column, 5.0)),
            ("grid to wider grid", grid.clone(), shape(Shape::Grid, 6.0)),
            (
                "grid turned by 90 deg",
                grid.clone(),
                grid.iter().map(|[f, r, d]| [-r, *f, *d]).collect(),
            ),
        ] {
            problems.push(Problem {
                name,
                from,
                slots,
                rounds,
            });
        }
    }
    problems
}

fn plain(offsets: &[OffsetFrd]) -> Vec<[f64; 3]> {
    offsets.iter().map(|o| [o.forward_m, o.right_m, o.down_m]).collect()
}

/// Knuth's linear congruence: the same places in every run.
struct Random(u64);

impl Random {
    /// Within 0..1.
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as f64 / f64::from(1_u32 << 31)
    }
}
