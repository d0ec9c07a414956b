//! A format of one's own: clouds as `x y z` lines under a heading line `cloud NAME`.

use loftsman_kernel::Point;
use loftsman_kernel::mesh::Cloud;
use loftsman_kernel::plugin::{
    Fate, Format, FormatDeclaration, FormatError, Place, ReadOptions, ReadReport, Sink, Source, WriteOptions,
    WriteReport, Written,
};
use loftsman_kernel::scene::{Geometry, MOST_PLACED, Object, Scene};

/// Named clouds as text.
#[derive(Debug, Clone, Copy, Default)]
pub struct Dots;

#[rustfmt::skip]
impl Format for Dots {
    fn declaration(&self) -> FormatDeclaration {
        let (name, help, extensions) = ("dots", "named clouds as text", &["dots"] as &[&str]);
        FormatDeclaration { name, help, extensions, reads: true, writes: true, plain: true, options: &[] }
    }

    fn read(&self, source: &dyn Source, _: &ReadOptions<'_>) -> Result<(Scene, ReadReport), FormatError> {
        let wrong = |line: usize, what: &str| FormatError::new(source.name(), Place::Line(line), what);
        let text = std::str::from_utf8(source.bytes()).map_err(|_| wrong(1, "not UTF-8 text"))?;
        let (mut scene, mut report, mut clouds) = (Scene::new(), ReadReport::default(), Vec::<(String, Vec<Point>)>::new());
        for (i, line) in text.lines().enumerate() {
            if let Some(name) = line.strip_prefix("cloud ") {
                clouds.push((name.to_owned(), Vec::new()));
                continue;
            }
            let numbers: Vec<f64> = line.split(' ').filter_map(|w| w.parse().ok()).filter(|n: &f64| n.is_finite()).collect();
            match (&numbers[..], clouds.last_mut()) {
                (&[x, y, z], Some((_, points))) if line.split(' ').count() == 3 => points.push(Point::new(x, y, z)),
                _ => return Err(wrong(i + 1, "three numbers are needed here, under a line `cloud NAME`")),
            }
            report.count(Fate::Kept, "");
        }
        for (name, points) in clouds {
            scene.add(Object::new(scene.unique_name(&name), Cloud { points }.into())).map_err(|e| wrong(1, &e.to_string()))?;
        }
        if scene.objects().is_empty() { Err(wrong(1, "there is no line `cloud NAME`")) } else { Ok((scene, report)) }
    }

    fn write(&self, scene: &Scene, sink: &mut dyn Sink, _: &WriteOptions<'_>) -> Result<WriteReport, FormatError> {
        let (mut report, mut text) = (WriteReport::default(), String::new());
        // What instances show is written one by one.
        let flat = scene.flattened(MOST_PLACED).map_err(|e| FormatError::new(sink.name(), Place::File, e.to_string()))?;
        for object in flat.objects() {
            let cloud = if let Geometry::Cloud(cloud) = object.geometry() { Some(cloud) } else { None };
            let points = cloud.map_or(&[] as &[Point], |c| &c.points);
            if cloud.is_some() { text += &format!("cloud {}\n", object.name().replace('\n', " ")); }
            text.extend(points.iter().map(|p| format!("{} {} {}\n", p.x, p.y, p.z)));
            let (fate, reason) = if cloud.is_some() { (Fate::Kept, None) } else { (Fate::LeftOut, Some("not a cloud".into())) };
            report.objects.push(Written { object: object.name().into(), form: "text".into(), fate, tolerance: None, error: None, reason });
        }
        let name = sink.name().to_owned();
        sink.main().write_all(text.as_bytes()).map_err(|e| FormatError::new(name, Place::File, e.to_string()))?;
        Ok(report)
    }
}
