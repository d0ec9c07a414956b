//! Small files, made of their entities.

use loftsman_iges::Iges;
use loftsman_kernel::plugin::{Format, FormatError, Memory, ReadOptions, ReadReport};
use loftsman_kernel::scene::Scene;

/// An entity: its form, its parameters (the type first), and what the directory says beside that.
pub(crate) struct Entity<'a> {
    pub(crate) form: i32,
    pub(crate) parameters: &'a str,
    pub(crate) matrix: i32,
    pub(crate) color: i32,
    pub(crate) level: i32,
    pub(crate) status: &'a str,
    pub(crate) label: &'a str,
}

/// An entity with nothing beside its parameters.
pub(crate) fn entity(form: i32, parameters: &str) -> Entity<'_> {
    Entity { form, parameters, matrix: 0, color: 0, level: 0, status: "00000000", label: "" }
}

/// A file in millimetres; the entities have the numbers 1, 3, 5, …
pub(crate) fn file(entities: &[Entity<'_>]) -> String {
    let mut directory = String::new();
    let mut parameters = String::new();
    let (mut line, mut entry) = (0, 0);
    for Entity { form, parameters: text, matrix, color, level, status, label } in entities {
        let kind: String = text.chars().take_while(char::is_ascii_digit).collect();
        let first = line + 1;
        for part in text.as_bytes().chunks(64) {
            line += 1;
            let part = String::from_utf8_lossy(part);
            parameters += &format!("{part:<64}{:8}P{line:7}\n", entry + 1);
        }
        let count = line + 1 - first;
        directory += &format!(
            "{kind:>8}{first:8}       0       0{level:8}       0{matrix:8}       0{status}D{:7}\n",
            entry + 1
        );
        directory += &format!(
            "{kind:>8}       0{color:8}{count:8}{form:8}                {label:>8}       0D{:7}\n",
            entry + 2
        );
        entry += 2;
    }
    let global = "1H,,1H;,4Hpart,4Hfile,4Htest,4Htest,32,38,6,308,15,4Hpart,1.,2,2HMM,1,0.01,;";
    let mut text = format!("{:72}S      1\n", "");
    for (k, part) in global.as_bytes().chunks(72).enumerate() {
        text += &format!("{:<72}G{:7}\n", String::from_utf8_lossy(part), k + 1);
    }
    text + &directory + &parameters + &format!("S      1G      2D{entry:7}P{line:7}{:40}T      1\n", "")
}

/// What is read of a text.
pub(crate) fn read(text: &str) -> Result<(Scene, ReadReport), FormatError> {
    Iges.read(&Memory::new("t.igs", text), &ReadOptions::default())
}
