//! Curves with planes: the distance is a spline of one variable, known by its coefficients.

use loftsman_kernel::Point;
use loftsman_kernel::spline::Curve;

use crate::bernstein::{Polynomial, root};
use crate::contact::Judge;
use crate::error::Result;
use crate::intersections::{Contact, Intersections, Meeting, Options, Overlap, Plane};
use crate::pair::setting;

/// Where a curve meets a plane, and which spans lie in it.
///
/// The signed distance times the weight is a polynomial on each span, whose Bernstein coefficients are the distances of the
/// control vertices: a part whose coefficients are all beyond the tolerance does not meet, one whose coefficients run one
/// way meets once at most. Everything else is halved. `O(n p²)`.
///
/// # Errors
/// As for [`curves`](crate::curves).
pub fn curve_plane(curve: &Curve, plane: &Plane, options: &Options) -> Result<Intersections> {
    let (frame, tolerance) = setting(&[curve.hull_bounds()], options)?;
    let mut answer = Intersections { tolerance, ..Intersections::default() };
    let smallest = 1e-5;
    for segment in curve.bezier_segments()? {
        let (a, b) = segment.domain();
        let weight = |i: usize| segment.weights().map_or(1.0, |w| w[i]);
        let distances: Vec<f64> = segment.points().iter().map(|p| plane.distance(p) / frame.size).collect();
        let inner = tolerance / frame.size;
        if distances.iter().all(|d| d.abs() <= inner) {
            let points = [curve.point(a)?, segment.point(b)?];
            let distance = distances.iter().fold(0.0_f64, |m, d| m.max(d.abs())) * frame.size;
            match answer.overlaps.last_mut() {
                Some(last) if last.range.1 == a => {
                    (last.range.1, last.points[1]) = (b, points[1]);
                    last.distance = last.distance.max(distance);
                }
                _ => answer.overlaps.push(Overlap { range: (a, b), with: None, points, distance }),
            }
            continue;
        }
        let value = Polynomial::new(distances.iter().enumerate().map(|(i, d)| d * weight(i)).collect());
        let weights = Polynomial::new((0..distances.len()).map(weight).collect());
        let mut open = vec![(value, weights, 0.0, 1.0)];
        while let Some((f, w, low, high)) = open.pop() {
            let ratio = || f.coefficients().iter().zip(w.coefficients()).map(|(f, w)| f / w);
            if ratio().all(|d| d > inner) || ratio().all(|d| d < -inner) {
                continue;
            }
            let place = |x: f64| low + (high - low) * x;
            let ends = (f.first(), f.last());
            let found = if f.is_monotone() {
                if ends.0 * ends.1 <= 0.0 {
                    Some((place(root(&f)), Contact::Crossing))
                } else {
                    // The nearer end, if it is near enough: a touching there, or what the neighbour finds.
                    let x = if ends.0.abs() < ends.1.abs() { 0.0 } else { 1.0 };
                    (f.value(x).abs() <= inner * w.value(x)).then_some((place(x), Contact::Touching))
                }
            } else if high - low <= smallest {
                let nearest = [0.0, 0.25, 0.5, 0.75, 1.0].into_iter().min_by(|&x, &y| {
                    (f.value(x) / w.value(x)).abs().total_cmp(&(f.value(y) / w.value(y)).abs())
                });
                nearest
                    .filter(|&x| f.value(x).abs() <= inner * w.value(x))
                    .map(|x| (place(x), Contact::Touching))
            } else {
                let ([f1, f2], [w1, w2]) = (f.halves(), w.halves());
                let middle = place(0.5);
                // The first half is taken first.
                open.push((f2, w2, middle, high));
                open.push((f1, w1, low, middle));
                None
            };
            let Some((x, contact)) = found else { continue };
            let at = if x >= 1.0 { b } else { (a + (b - a) * x).clamp(a, b) };
            let point = segment.point(at)?;
            let distance = plane.distance(&point).abs();
            answer.meetings.push(Meeting { at, with: None, point, distance, contact });
        }
    }
    merge(curve, plane, &mut answer)?;
    for meeting in &mut answer.meetings {
        let judge = Judge::new(tolerance, meeting.contact == Contact::Crossing);
        meeting.contact = judge.plane(curve, meeting.at, plane)?;
    }
    Ok(answer)
}

/// One of meetings between which nothing leaves the plane by more than the tolerance; none at the ends of overlaps.
fn merge(curve: &Curve, plane: &Plane, answer: &mut Intersections) -> Result<()> {
    let length = curve.space().length();
    let near = |a: f64, b: f64| -> Result<bool> {
        if (a - b).abs() > 0.05 * length {
            return Ok(false);
        }
        for step in [0.0, 0.25, 0.5, 0.75, 1.0] {
            let point: Point = curve.point(a + (b - a) * step)?;
            if plane.distance(&point).abs() > 2.0 * answer.tolerance {
                return Ok(false);
            }
        }
        Ok(true)
    };
    let mut kept: Vec<Meeting> = Vec::new();
    'next: for meeting in &answer.meetings {
        for overlap in &answer.overlaps {
            if near(overlap.range.0, meeting.at)? || near(overlap.range.1, meeting.at)? {
                continue 'next;
            }
        }
        // The seam of a closed curve is one place.
        let (start, end) = curve.domain();
        let seam = (curve.point(start)? - curve.point(end)?).norm() <= answer.tolerance;
        if let (true, Some(first)) = (seam, kept.first())
            && (first.at - start) + (end - meeting.at) < 0.05 * length
            && near(start, first.at)?
            && near(meeting.at, end)?
        {
            continue;
        }
        if let Some(last) = kept.last_mut() {
            let both = last.contact == Contact::Crossing && meeting.contact == Contact::Crossing;
            if (meeting.at - last.at).abs() <= 1e-12 * length || !both && near(last.at, meeting.at)? {
                if !both && (meeting.contact == Contact::Crossing || meeting.distance < last.distance) {
                    let contact =
                        if last.contact == Contact::Crossing { Contact::Crossing } else { meeting.contact };
                    *last = Meeting { contact, ..*meeting };
                }
                continue;
            }
        }
        kept.push(*meeting);
    }
    answer.meetings = kept;
    Ok(())
}
