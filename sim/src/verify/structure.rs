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
    let models = plan.harness.models.iter();
    let blocks: Vec<String> = models
        .map(|model| model.name.trim_end_matches(".v").to_owned())
        .collect();
    let request = StructurePlan {
        top: plan.design.name(),
        sources: &sources,
        blocks: &blocks,
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
            "expected no register or memory beyond the model's, found {}",
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
