//! A format of one's own: clouds as `x y z` lines under a heading line `cloud NAME`.

use loftsman_kernel::Point;
use loftsman_kernel::mesh::Cloud;
use loftsman_kernel::plugin::{
    Fate, Format, FormatDeclaration, FormatError, Holds, InWorld, Outgoing, Place, ReadOptions, ReadReport,
    Sink, Source, WriteReport, Written, utf8,
};
use loftsman_kernel::scene::{Geometry, Object, Scene};

/// Named clouds as text.
#[derive(Debug, Clone, Copy, Default)]
pub struct Dots;

#[rustfmt::skip]
impl Format for Dots {
    fn declaration(&self) -> FormatDeclaration {
        let (name, help, extensions) = ("dots", "named clouds as text", &["dots"] as &[&str]);
        let holds = Holds { exact: &["cloud"], ..Holds::NOTHING };
        FormatDeclaration { name, help, extensions, reads: true, writes: true, plain: true, options: &[], holds }
    }

    fn decode(&self, source: &dyn Source, _: &ReadOptions<'_>) -> Result<(Scene, ReadReport), FormatError> {
        let wrong = |line: usize, what: &str| FormatError::new(Place::Line(line), what);
        let text = utf8(source.bytes(), 0)?;
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
            scene.add(Object::new(scene.unique_name(&name), Cloud { points }.into()))?;
        }
        if scene.objects().is_empty() { Err(wrong(1, "there is no line `cloud NAME`")) } else { Ok((scene, report)) }
    }

    fn encode(&self, outgoing: &Outgoing<'_>, sink: &mut dyn Sink) -> Result<WriteReport, FormatError> {
        let (scene, mut report, mut text) = (outgoing.converted()?, WriteReport::default(), String::new());
        for object in outgoing.in_world(&scene)? {
            let InWorld { object, geometry, .. } = object?;
            report.objects.push(if let Geometry::Cloud(cloud) = geometry.as_ref() {
                text += &format!("cloud {}\n", object.name().replace('\n', " "));
                text.extend(cloud.points.iter().map(|p| format!("{} {} {}\n", p.x, p.y, p.z)));
                Written::kept(object, "text")
            } else {
                Written::left_out(object, "not a cloud")
            });
        }
        sink.main().write_all(text.as_bytes())?;
        Ok(report)
    }
}
