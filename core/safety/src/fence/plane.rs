//! Plane geometry of points, edges and polygons.

/// A place in the plane.
pub(super) type Point = [f64; 2];
/// An edge from its first place to its second.
pub(super) type Edge = [Point; 2];

/// The edges of a polygon, the closing one last.
pub(super) fn edges(vertices: &[Point]) -> impl Iterator<Item = Edge> + '_ {
    vertices
        .iter()
        .zip(vertices.iter().cycle().skip(1))
        .map(|(a, b)| [*a, *b])
}

fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// Which side of the edge a place is on: above zero to one side, below to the other, zero on its line.
fn side(edge: Edge, p: Point) -> f64 {
    cross(minus(edge[1], edge[0]), minus(p, edge[0]))
}

/// Twice the area would do as well: only its sign and whether it is zero count.
pub(super) fn signed_area(vertices: &[Point]) -> f64 {
    // About the first corner, so that places far from the origin lose no digits.
    let Some(first) = vertices.first() else { return 0.0 };
    0.5 * edges(vertices)
        .map(|[a, b]| cross(minus(a, *first), minus(b, *first)))
        .sum::<f64>()
}

/// Whether all corners of a simple polygon turn to the same side.
pub(super) fn is_convex(vertices: &[Point]) -> bool {
    let turns = || {
        edges(vertices)
            .zip(vertices.iter().cycle().skip(2))
            .map(|(e, p)| side(e, *p))
    };
    turns().all(|turn| turn >= 0.0) || turns().all(|turn| turn <= 0.0)
}

/// The even-odd rule: whether a ray to the east crosses the polygon an odd number of times. Each edge owns its lower end only.
pub(super) fn even_odd(vertices: &[Point], p: Point) -> bool {
    let crosses =
        |[a, b]: &Edge| (a[0] > p[0]) != (b[0] > p[0]) && p[1] < a[1] + (p[0] - a[0]) / (b[0] - a[0]) * (b[1] - a[1]);
    edges(vertices).filter(crosses).count() % 2 == 1
}

/// The place on an edge that is nearest to another.
pub(super) fn nearest_on_edge(edge: Edge, p: Point) -> Point {
    let (along, to) = (minus(edge[1], edge[0]), minus(p, edge[0]));
    let length2 = dot(along, along);
    let share = if length2 > 0.0 {
        (dot(to, along) / length2).clamp(0.0, 1.0)
    } else {
        0.0
    };
    [edge[0][0] + along[0] * share, edge[0][1] + along[1] * share]
}

/// Distance from a place to an edge in metres.
pub(super) fn distance_to_edge_m(edge: Edge, p: Point) -> f64 {
    let off = minus(p, nearest_on_edge(edge, p));
    off[0].hypot(off[1])
}

/// Distance between two edges in metres; zero if they touch or cross.
pub(super) fn edges_distance_m(e: Edge, f: Edge) -> f64 {
    if touch(e, f) {
        return 0.0;
    }
    let of = |edge: Edge, ends: Edge| {
        ends.map(|p| distance_to_edge_m(edge, p))
            .into_iter()
            .fold(f64::INFINITY, f64::min)
    };
    of(e, f).min(of(f, e))
}

/// Whether a place is within `near_m` of an edge.
pub(super) fn on_edge(edge: Edge, p: Point, near_m: f64) -> bool {
    distance_to_edge_m(edge, p) <= near_m
}

/// Whether two edges have a place in common.
pub(super) fn touch(e: Edge, f: Edge) -> bool {
    let (s1, s2) = (side(e, f[0]), side(e, f[1]));
    let (s3, s4) = (side(f, e[0]), side(f, e[1]));
    if s1 * s2 < 0.0 && s3 * s4 < 0.0 {
        return true;
    }
    let within = |edge: Edge, p: Point| distance_to_edge_m(edge, p) == 0.0;
    (s1 == 0.0 && within(e, f[0]))
        || (s2 == 0.0 && within(e, f[1]))
        || (s3 == 0.0 && within(f, e[0]))
        || (s4 == 0.0 && within(f, e[1]))
}

/// Whether `next`, which begins where `edge` ends, goes back along it.
pub(super) fn folds_back(edge: Edge, next: Edge) -> bool {
    side(edge, next[1]) == 0.0 && dot(minus(edge[1], edge[0]), minus(next[1], next[0])) < 0.0
}

/// At which shares (0..=1) of the way from `a` to `b` it touches an edge: none, one, or the two ends of what lies on it.
pub(super) fn touches_at(a: Point, b: Point, edge: Edge) -> Vec<f64> {
    let (way, along) = (minus(b, a), minus(edge[1], edge[0]));
    let (length2, denominator) = (dot(way, way), cross(way, along));
    if length2 == 0.0 {
        return Vec::new();
    }
    let candidates = if denominator == 0.0 {
        // Parallel: the ends of the edge matter if they lie on the way; if not, the test of the middle takes no harm.
        edge.iter().map(|p| dot(minus(*p, a), way) / length2).collect()
    } else {
        vec![cross(minus(edge[0], a), along) / denominator]
    };
    candidates
        .into_iter()
        .filter(|share| (0.0..=1.0).contains(share))
        .collect()
}
