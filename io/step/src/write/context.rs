//! What stands at the head of a file: what it is of, and its units.

use std::collections::HashMap;

use loftsman_kernel::scene::Unit;

use super::print::{Printer, real, references};
use crate::part21::encode;

/// The schema of the files: AP242, second edition.
const SCHEMA: &str = "AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF { 1 0 10303 442 1 1 4 }";

/// The header of a file, up to its data.
pub(crate) fn header(name: &str) -> String {
    let (name, system) = (encode(name), crate::SYSTEM);
    // A date would be another one each time.
    format!(
        "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\n\
         FILE_NAME({name},'1970-01-01T00:00:00',(''),(''),'{system} {}','{system}','');\n\
         FILE_SCHEMA(('{SCHEMA}'));\nENDSEC;\nDATA;\n",
        env!("CARGO_PKG_VERSION")
    )
}

/// The end of a file.
pub(crate) const END: &str = "ENDSEC;\nEND-ISO-10303-21;\n";

/// What all products name.
pub(crate) struct Common {
    pub(crate) product: u64,
    pub(crate) definition: u64,
    units: Vec<u64>,
    length: Option<u64>,
    /// The contexts that were written, by their uncertainty.
    contexts: HashMap<u64, u64>,
}

impl Common {
    pub(crate) fn new(p: &mut Printer, unit: Unit) -> Self {
        let application = p.put("APPLICATION_CONTEXT('managed model based 3d engineering')");
        p.put(&format!(
            "APPLICATION_PROTOCOL_DEFINITION('international standard','ap242_managed_model_based_3d_engineering',2020,#{application})"
        ));
        let product = p.put(&format!("PRODUCT_CONTEXT('',#{application},'mechanical')"));
        let definition =
            p.put(&format!("PRODUCT_DEFINITION_CONTEXT('part definition',#{application},'design')"));
        let length = length(p, unit);
        let angle = p.put("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))");
        let solid = p.put("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())");
        let units = length.into_iter().chain([angle, solid]).collect();
        Self { product, definition, units, length, contexts: HashMap::new() }
    }

    /// A context in which lengths are as exact as this; 0 where that is not said.
    pub(crate) fn context(&mut self, p: &mut Printer, uncertainty: f64) -> u64 {
        let uncertainty = if self.length.is_some() { uncertainty } else { 0.0 };
        if let Some(&known) = self.contexts.get(&uncertainty.to_bits()) {
            return known;
        }
        let exact = match self.length.filter(|_| uncertainty > 0.0) {
            Some(length) => {
                let measure = p.put(&format!(
                    "UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE({}),#{length},'distance_accuracy_value','')",
                    real(uncertainty)
                ));
                format!("GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#{measure}))")
            }
            None => String::new(),
        };
        let units = references(&self.units);
        let context = p.put(&format!(
            "(GEOMETRIC_REPRESENTATION_CONTEXT(3){exact}GLOBAL_UNIT_ASSIGNED_CONTEXT({units})REPRESENTATION_CONTEXT('',''))"
        ));
        self.contexts.insert(uncertainty.to_bits(), context);
        context
    }
}

/// The unit of length; none where it is unknown.
fn length(p: &mut Printer, unit: Unit) -> Option<u64> {
    let prefix = match unit {
        Unit::Nanometre => ".NANO.",
        Unit::Micrometre => ".MICRO.",
        Unit::Millimetre => ".MILLI.",
        Unit::Centimetre => ".CENTI.",
        Unit::Decimetre => ".DECI.",
        Unit::Metre => "$",
        Unit::Kilometre => ".KILO.",
        other => {
            let metres = other.metres()?;
            let metre = p.put("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT($,.METRE.))");
            let measure =
                p.put(&format!("LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE({}),#{metre})", real(metres)));
            let dimensions = p.put("DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.)");
            let name = match other {
                Unit::Inch => "INCH".to_owned(),
                Unit::Foot => "FOOT".to_owned(),
                other => other.name().into_owned(),
            };
            return Some(p.put(&format!(
                "(CONVERSION_BASED_UNIT({},#{measure})LENGTH_UNIT()NAMED_UNIT(#{dimensions}))",
                encode(&name)
            )));
        }
    };
    Some(p.put(&format!("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT({prefix},.METRE.))")))
}
