//! Whether the Verilog has state that the model lacks.

use super::{FirstDifference, StructureReport, VerifyPlan};
use crate::error::{SimError, ToolError};
use crate::model::Model;
use crate::structure::{self, StructurePlan};

/// Compares registers and memories with the model's, where Yosys is installed.
pub(super) fn check(
    plan: &VerifyPlan<'_>,
) -> Result<(StructureReport, Option<FirstDifference>), SimError> {
    let sources: Vec<_> = plan.sources.iter().map(|s| plan.bundle.join(s)).collect();
    let design = plan.design;
    let inputs = [
        ("aclk", 1),
        ("aresetn", 1),
        ("s_axis_tdata", design.source().data_bits()),
        ("s_axis_tvalid", 1),
        ("s_axis_tlast", 1),
        ("m_axis_tready", 1),
    ];
    let request = StructurePlan {
        top: design.name(),
        sources: &sources,
        models: &plan.harness.models,
        inputs: &inputs,
        work_dir: &plan.work_dir,
        timeout: plan.timeout,
    };
    let model = Model::new(plan.design);
    let registers = [model.registers(), model.interior()].concat();
    let found = match structure::compare(plan.toolbox, &request, &registers) {
        Ok(found) => found,
        Err(ToolError::Missing { .. } | ToolError::TooOld { .. }) => {
            return Ok((StructureReport::default(), None));
        }
        Err(error) => return Err(error.into()),
    };
    let difference = found.extra.map(|extra| FirstDifference {
        note: Some(format!(
            "expected the structure of the model, found {}",
            extra.what
        )),
        ..FirstDifference::at("structure", "structure", plan.design, &extra.path)
    });
    let report = StructureReport {
        checked: true,
        tool: Some(format!("yosys {}", found.version)),
        registers: found.registers,
        memories: found.memories,
    };
    Ok((report, difference))
}
