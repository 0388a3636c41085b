//! The velocity nearest to a wanted one under half-spaces and speed limits: a quadratic programme in three dimensions, solved
//! incrementally (Seidel 1991): rows are added one by one, and where one is violated the optimum lies on its plane. No loop
//! depends on convergence, nothing here can fail to end.

use nalgebra::{UnitVector3, Vector3};

/// Rows count as kept within this, in metres per second.
const TOLERANCE: f64 = 1e-9;
/// Planes are parallel if the sine of their angle is below this.
const PARALLEL: f64 = 1e-7;
/// Halvings when the least violation is looked for: 20 m/s become 5 mm/s.
const HALVINGS: u32 = 12;
/// Cuts that bring the horizontal speed within its circle.
const CUTS: u32 = 6;

/// One condition on a velocity: `normal · v <= bound`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Row {
    /// Unit vector.
    pub normal: Vector3<f64>,
    /// In metres per second.
    pub bound: f64,
    /// How readily it yields when not all can be kept; zero never does.
    pub yields: f64,
}

impl Row {
    /// By how much a velocity breaks it; negative is what is left.
    pub fn excess(&self, v: &Vector3<f64>) -> f64 {
        self.normal.dot(v) - self.bound
    }
}

/// Speeds that no answer exceeds.
#[derive(Debug, Clone, Copy)]
pub(super) struct SpeedLimits {
    pub horizontal_m_s: f64,
    pub up_m_s: f64,
    pub down_m_s: f64,
}

impl SpeedLimits {
    /// The velocity brought within the limits.
    pub fn clamp(&self, v: &Vector3<f64>) -> Vector3<f64> {
        let level = v.x.hypot(v.y);
        let scale = if level > self.horizontal_m_s {
            self.horizontal_m_s / level
        } else {
            1.0
        };
        Vector3::new(v.x * scale, v.y * scale, v.z.max(-self.up_m_s).min(self.down_m_s))
    }

    fn rows(&self) -> [Row; 2] {
        let row = |z: f64, bound: f64| Row {
            normal: Vector3::new(0.0, 0.0, z),
            bound,
            yields: 0.0,
        };
        [row(1.0, self.down_m_s), row(-1.0, self.up_m_s)]
    }
}

/// The nearest velocity, and whether it keeps every row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct NearestVelocity {
    pub velocity: Vector3<f64>,
    pub feasible: bool,
}

/// The velocity nearest to `wanted` that keeps all rows and limits, or the one that breaks the rows least.
pub(super) fn nearest(wanted: &Vector3<f64>, rows: &[Row], limits: &SpeedLimits) -> NearestVelocity {
    // Room for the limits and the cuts; one allocation per call.
    let mut all: Vec<Row> = Vec::with_capacity(rows.len() + 2 + CUTS as usize);
    if let Some(velocity) = relaxed(wanted, rows, limits, 0.0, &mut all) {
        return NearestVelocity {
            velocity,
            feasible: true,
        };
    }
    let start = limits.clamp(wanted);
    let mut most = rows
        .iter()
        .filter(|row| row.yields > 0.0)
        .map(|row| row.excess(&start) / row.yields)
        .fold(0.0, f64::max);
    let mut least = 0.0;
    let mut best = start;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (least + most);
        if let Some(velocity) = relaxed(wanted, rows, limits, middle, &mut all) {
            best = velocity;
            most = middle;
        } else {
            least = middle;
        }
    }
    NearestVelocity {
        velocity: best,
        feasible: false,
    }
}

/// The same with every row loosened by `slack` times its readiness.
fn relaxed(
    wanted: &Vector3<f64>,
    rows: &[Row],
    limits: &SpeedLimits,
    slack: f64,
    all: &mut Vec<Row>,
) -> Option<Vector3<f64>> {
    all.clear();
    all.extend(limits.rows());
    all.extend(rows.iter().map(|row| Row {
        bound: row.bound + slack * row.yields,
        ..*row
    }));
    let mut answer = project(wanted, all)?;
    for _ in 0..CUTS {
        let level = answer.x.hypot(answer.y);
        if level <= limits.horizontal_m_s {
            return Some(answer);
        }
        // The circle's tangent where the answer left it.
        all.push(Row {
            normal: Vector3::new(answer.x / level, answer.y / level, 0.0),
            bound: limits.horizontal_m_s,
            yields: 0.0,
        });
        answer = project(wanted, all)?;
    }
    Some(limits.clamp(&answer))
}

/// The point nearest to `wanted` in all half-spaces; none if they have no point in common.
fn project(wanted: &Vector3<f64>, rows: &[Row]) -> Option<Vector3<f64>> {
    let mut best = *wanted;
    for (k, row) in rows.iter().enumerate() {
        if row.excess(&best) > TOLERANCE {
            best = on_plane(wanted, row, rows.get(..k)?)?;
        }
    }
    Some(best)
}

/// The same on the plane of `plane`.
fn on_plane(wanted: &Vector3<f64>, plane: &Row, rows: &[Row]) -> Option<Vector3<f64>> {
    let foot = wanted - plane.normal * plane.excess(wanted);
    let mut best = foot;
    for (k, row) in rows.iter().enumerate() {
        if row.excess(&best) <= TOLERANCE {
            continue;
        }
        let along = UnitVector3::try_new(plane.normal.cross(&row.normal), PARALLEL)?;
        // Down the plane into the other half-space, along the plane's own direction of steepest descent of the row.
        let into = along.cross(&plane.normal);
        let rate = into.dot(&row.normal);
        let on_both = foot - into * (row.excess(&foot) / rate);
        best = on_line(&on_both, &along, rows.get(..k)?)?;
    }
    Some(best)
}

/// The same on a line, from its point nearest to what is wanted.
fn on_line(start: &Vector3<f64>, along: &Vector3<f64>, rows: &[Row]) -> Option<Vector3<f64>> {
    let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
    for row in rows {
        let (excess, rate) = (row.excess(start), row.normal.dot(along));
        if rate.abs() <= PARALLEL {
            if excess > 1e-6 {
                return None;
            }
        } else if rate > 0.0 {
            to = to.min(-excess / rate);
        } else {
            from = from.max(-excess / rate);
        }
    }
    if from > to + TOLERANCE || from.is_nan() || to.is_nan() {
        return None;
    }
    // Not `clamp`, which panics if rounding has put the ends the wrong way round.
    Some(start + along * 0.0_f64.max(from).min(to))
}

#[cfg(test)]
mod tests;
