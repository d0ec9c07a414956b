//! Small files, made of their data.

use loftsman_kernel::plugin::{Format, FormatError, Memory, ReadOptions, ReadReport};
use loftsman_kernel::scene::Scene;
use loftsman_step::Step;

/// A context in millimetres and degrees, a product and its representation, whose items are `#100` and what follows.
pub(crate) fn file(items: &str, data: &str) -> String {
    format!(
        "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('t','',(''),(''),'','','');\n\
         FILE_SCHEMA(('AP242'));\nENDSEC;\nDATA;\n\
         #1=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));\n\
         #2=(CONVERSION_BASED_UNIT('DEGREE',#3)NAMED_UNIT(*)PLANE_ANGLE_UNIT());\n\
         #3=PLANE_ANGLE_MEASURE_WITH_UNIT(PLANE_ANGLE_MEASURE(0.017453292519943295),#4);\n\
         #4=(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.));\n\
         #5=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNIT_ASSIGNED_CONTEXT((#1,#2))REPRESENTATION_CONTEXT('',''));\n\
         #6=SHAPE_REPRESENTATION('thing',({items}),#5);\n\
         {data}\nENDSEC;\nEND-ISO-10303-21;\n"
    )
}

/// The axes at the origin: a point, both directions, and the placement `#10`.
pub(crate) const AXES: &str = "#10=AXIS2_PLACEMENT_3D('',#11,#12,#13);\n#11=CARTESIAN_POINT('',(0.,0.,0.));\n\
                        #12=DIRECTION('',(0.,0.,1.));\n#13=DIRECTION('',(1.,0.,0.));\n";

/// What is read of a text.
pub(crate) fn read(text: &str) -> Result<(Scene, ReadReport), FormatError> {
    Step.read(&Memory::new("t.step", text), &ReadOptions::default())
}
