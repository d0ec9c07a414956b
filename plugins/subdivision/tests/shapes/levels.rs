//! Refinement by hand of the faces round a vertex, many levels deep.

use loftsman_subdivision::Cage;
use loftsman_subdivision::catmull_clark::refine;

/// The cage refined so often, and of it the vertex, which is number 0, with the faces round it and those round these: of the first
/// levels all, for these may hang together elsewhere.
pub(crate) fn explicit(cage: &Cage, vertex: usize, levels: usize) -> Cage {
    let mut cage = cage.clone();
    let mut vertex = vertex;
    for level in 0..levels {
        cage = refine(&cage).unwrap();
        if level > 0 {
            cage = cropped(&cage, vertex);
            vertex = 0;
        }
    }
    if levels < 2 {
        cage = cropped(&cage, vertex);
    }
    cage
}

/// Two rings of faces round a vertex, with what is said of them. The vertex keeps its place in the order of its edges.
pub(crate) fn cropped(cage: &Cage, vertex: usize) -> Cage {
    let topology = cage.topology();
    let own: Vec<usize> = topology.vertex_faces(vertex).map(|f| f as usize).collect();
    let mut faces = own.clone();
    for &f in &own {
        for &v in topology.face(f) {
            faces.extend(topology.vertex_faces(v as usize).map(|f| f as usize));
        }
    }
    faces[own.len()..].sort_unstable();
    let mut seen = std::collections::BTreeSet::new();
    faces.retain(|f| seen.insert(*f));
    let mut kept = vec![vertex];
    let mut place = std::collections::BTreeMap::from([(vertex, 0)]);
    let mut corners = Vec::new();
    for &f in &faces {
        let face: Vec<usize> = topology.face(f).iter().map(|&v| v as usize).collect();
        corners.push(
            face.iter()
                .map(|&v| {
                    *place.entry(v).or_insert_with(|| {
                        kept.push(v);
                        kept.len() - 1
                    })
                })
                .collect::<Vec<_>>(),
        );
    }
    let points = kept.iter().map(|&v| cage.points()[v]).collect();
    let mut crop = Cage::new(points, &corners).unwrap().with_boundary(cage.boundary());
    for (new, &v) in kept.iter().enumerate() {
        if cage.corner(v) > 0.0 {
            crop = crop.with_corner(new, cage.corner(v)).unwrap();
        }
    }
    for edge in 0..topology.edge_count() {
        let [a, b] = topology.edge(edge).unwrap();
        let (Some(&a), Some(&b)) = (place.get(&(a as usize)), place.get(&(b as usize))) else { continue };
        if crop.topology().edge_between(a, b).is_none() {
            continue;
        }
        if cage.crease(edge) > 0.0 {
            crop = crop.with_crease(a, b, cage.crease(edge)).unwrap();
        }
        if cage.has_intervals() {
            crop = crop.with_interval(a, b, cage.interval(edge)).unwrap();
        }
    }
    crop
}
