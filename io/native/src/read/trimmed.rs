//! Trimmed surfaces, and where surfaces meet.

use loftsman_kernel::connection::{Connection, Side};
use loftsman_kernel::spline::trimmed::{ParameterCurve, Region};
use loftsman_kernel::spline::{Curve, Surface, Trimmed};
use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess};

use super::geometry::{CurveTable, SurfaceTable};
use super::lists::{Fixed, List, Number};
use super::table::{Table, TableSeed, need};
use super::trail::Trail;

/// Makes a table the item of a list.
macro_rules! item {
    ($seed:ident, $table:ty) => {
        #[derive(Clone, Copy)]
        pub(super) struct $seed<'t>(pub(super) &'t Trail);

        impl<'de> DeserializeSeed<'de> for $seed<'_> {
            type Value = <$table as Table<'de>>::Out;

            fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
                TableSeed { trail: self.0, table: <$table>::default() }.deserialize(deserializer)
            }
        }
    };
}
pub(super) use item;

item!(PieceSeed, PieceTable);
item!(RegionSeed, RegionTable);
item!(ConnectionSeed, ConnectionTable);

fn chain(trail: &Trail) -> List<'_, PieceSeed<'_>> {
    List { trail, what: "curves { curve, from, to }", item: PieceSeed(trail) }
}

/// A curve in the parameter plane.
#[derive(Default)]
pub(super) struct PieceTable {
    curve: Option<Curve>,
    from: Option<f64>,
    to: Option<f64>,
}

impl<'de> Table<'de> for PieceTable {
    type Out = ParameterCurve;
    const WHAT: &'static str = "a curve in the parameter plane";
    const FIELDS: &'static [&'static str] = &["curve", "from", "to"];

    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error> {
        match name {
            "curve" => {
                self.curve = Some(map.next_value_seed(TableSeed { trail, table: CurveTable::default() })?);
            }
            "from" => self.from = Some(map.next_value_seed(Number)?),
            _ => self.to = Some(map.next_value_seed(Number)?),
        }
        Ok(())
    }

    fn finish<E: Error>(self, trail: &Trail) -> Result<Self::Out, E> {
        let curve = need::<Self, _, _>(self.curve, "curve", trail)?;
        let from = need::<Self, _, _>(self.from, "from", trail)?;
        let to = need::<Self, _, _>(self.to, "to", trail)?;
        ParameterCurve::new(curve, from, to).map_err(|defect| trail.refuse_table("", defect.to_string()))
    }
}

/// A region of a trimmed surface.
#[derive(Default)]
pub(super) struct RegionTable(Region);

impl<'de> Table<'de> for RegionTable {
    type Out = Region;
    const WHAT: &'static str = "a region";
    const FIELDS: &'static [&'static str] = &["outer", "holes"];

    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error> {
        match name {
            "outer" => self.0.outer = map.next_value_seed(chain(trail))?,
            _ => {
                let item = chain(trail);
                self.0.holes = map.next_value_seed(List { trail, what: "loops", item })?;
            }
        }
        Ok(())
    }

    fn finish<E: Error>(self, _: &Trail) -> Result<Region, E> {
        Ok(self.0)
    }
}

/// `"trimmed"`.
#[derive(Default)]
pub(super) struct TrimmedTable {
    surface: Option<Surface>,
    regions: Vec<Region>,
    curves: Vec<Vec<ParameterCurve>>,
    points: Vec<[f64; 2]>,
}

impl<'de> Table<'de> for TrimmedTable {
    type Out = Trimmed;
    const WHAT: &'static str = "a trimmed surface";
    const FIELDS: &'static [&'static str] = &["surface", "regions", "curves", "points"];

    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error> {
        match name {
            "surface" => {
                self.surface =
                    Some(map.next_value_seed(TableSeed { trail, table: SurfaceTable::default() })?);
            }
            "regions" => {
                let item = RegionSeed(trail);
                self.regions = map.next_value_seed(List { trail, what: "regions { outer, holes }", item })?;
            }
            "curves" => {
                let item = chain(trail);
                self.curves = map.next_value_seed(List { trail, what: "chains of curves", item })?;
            }
            _ => {
                let item = Fixed::<2> { trail, what: "[u, v]" };
                self.points = map.next_value_seed(List { trail, what: "special points [u, v]", item })?;
            }
        }
        Ok(())
    }

    fn finish<E: Error>(self, trail: &Trail) -> Result<Trimmed, E> {
        let surface = need::<Self, _, _>(self.surface, "surface", trail)?;
        Trimmed::new(surface, self.regions, self.curves, self.points)
            .map_err(|defect| trail.refuse_table("", defect.to_string()))
    }
}

/// One side of a connection.
#[derive(Default)]
struct SideTable {
    object: Option<String>,
    piece: PieceTable,
}

impl<'de> Table<'de> for SideTable {
    type Out = Side;
    const WHAT: &'static str = "a side of a connection";
    const FIELDS: &'static [&'static str] = &["object", "curve", "from", "to"];

    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error> {
        if name == "object" {
            self.object = Some(map.next_value()?);
            return Ok(());
        }
        self.piece.field(name, map, trail)
    }

    fn finish<E: Error>(self, trail: &Trail) -> Result<Side, E> {
        let object = need::<Self, _, _>(self.object, "object", trail)?;
        Ok(Side { object, curve: self.piece.finish(trail)? })
    }
}

/// A connection.
#[derive(Default)]
pub(super) struct ConnectionTable {
    first: Option<Side>,
    second: Option<Side>,
}

impl<'de> Table<'de> for ConnectionTable {
    type Out = Connection;
    const WHAT: &'static str = "a connection";
    const FIELDS: &'static [&'static str] = &["first", "second"];

    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error> {
        let side = map.next_value_seed(TableSeed { trail, table: SideTable::default() })?;
        match name {
            "first" => self.first = Some(side),
            _ => self.second = Some(side),
        }
        Ok(())
    }

    fn finish<E: Error>(self, trail: &Trail) -> Result<Connection, E> {
        let first = need::<Self, _, _>(self.first, "first", trail)?;
        Ok(Connection { first, second: need::<Self, _, _>(self.second, "second", trail)? })
    }
}
