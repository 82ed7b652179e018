//! The first difference, told so that it can be found.

use std::fs;
use std::io::BufWriter;
use std::path::Path;

use hwgen_spec::format::{QFormat, to_bits};

use super::replay::Case;
use super::{FirstDifference, VerifyPlan, io_error, write};
use crate::compare::Difference;
use crate::error::SimError;
use crate::explain::explain;
use crate::gtkwave::{Radix, Signal, View, save_file};
use crate::model::Model;
use crate::record::Recording;
use crate::session::Session;
use crate::simulator::Simulator;
use crate::stimulus::Segment;
use crate::trace::{Dump, RtlValue};
use crate::vcd;

/// Clocks shown before and after the difference.
const WINDOW: usize = 6;

/// Where the model's pins part from the untimed values.
pub(super) fn of_sessions(segments: &[Segment], sessions: &[Session]) -> Option<FirstDifference> {
    let (segment, found) = segments
        .iter()
        .zip(sessions)
        .find_map(|(s, session)| Some((s, session.difference.as_ref()?)))?;
    Some(FirstDifference {
        simulator: "model".to_owned(),
        segment: segment.name.clone(),
        cycle: found.clock,
        signal: found.signal.to_owned(),
        lane: found.lane,
        network: None,
        layer: None,
        neuron: None,
        input: None,
        model: found.found,
        rtl: found.expected.to_string(),
        model_real: None,
        rtl_real: None,
        note: None,
        window: vec![found.note.clone()],
        files: Vec::new(),
    })
}

/// A register or block that is not what the model expects, whatever its value.
pub(super) fn of_shape(
    plan: &VerifyPlan<'_>,
    case: &Case<'_>,
    simulator: &str,
    signal: &str,
    note: &str,
) -> FirstDifference {
    FirstDifference {
        note: Some(note.to_owned()),
        ..FirstDifference::at(simulator, &case.segment.name, plan.design, signal)
    }
}

/// Where a simulator's registers part from the model's.
pub(super) fn of_registers(
    plan: &VerifyPlan<'_>,
    case: &Case<'_>,
    simulator: Simulator,
    dump: &Path,
    found: &Difference,
) -> Result<FirstDifference, SimError> {
    let design = plan.design;
    let recording = record(plan, case, found.clock + WINDOW + 1);
    let meaning = explain(design, &recording, &found.path, found.lane, found.clock);
    let register = &recording.registers()[found.register];
    let real = |code: i64| {
        let bits = register.lanes[found.lane];
        let format = QFormat::new(bits, meaning.fraction?).ok()?;
        Some(format.to_f64(code))
    };
    let code = |code: i64| {
        let bits = register.lanes[found.lane];
        if is_control(&found.path) {
            // Few bits, so the sign stays free.
            to_bits(code, bits).cast_signed()
        } else {
            signed(code, bits)
        }
    };
    let rtl_code = match &found.rtl {
        RtlValue::Known(code) => Some(*code),
        RtlValue::Unknown(_) => None,
    };

    let clocks = case.clocks;
    let rows = Dump::open(dump)?.values(register, clocks)?;
    let between = found.between.then(|| {
        format!(
            "> later, before edge {}: {} {}",
            found.clock + 1,
            simulator.name(),
            show(&found.rtl, code)
        )
    });
    let first = found.clock.saturating_sub(WINDOW);
    let last = (found.clock + WINDOW).min(clocks - 1);
    let window = (first..=last)
        .map(|clock| {
            let mark = if clock == found.clock { '>' } else { ' ' };
            let model = code(recording.values(clock, found.register)[found.lane]);
            let rtl = show(&rows[clock][found.lane], code);
            format!(
                "{mark} cycle {clock}: model {model}, {} {rtl}",
                simulator.name()
            )
        })
        .chain(between)
        .collect();

    let model_vcd = plan.work_dir.join(format!("{}.model.vcd", case.stem()));
    let file = fs::File::create(&model_vcd).map_err(|e| io_error(&model_vcd, e))?;
    vcd::write(&recording, design.name(), BufWriter::new(file))
        .map_err(|e| io_error(&model_vcd, e))?;
    let bits: u64 = register.bits();
    let save = plan
        .work_dir
        .join(format!("{}.{}.gtkw", case.stem(), simulator.name()));
    let view = View {
        dump,
        scope: &dump_scope(design.name(), simulator),
        signals: &[Signal {
            path: found.path.clone(),
            bits,
            radix: Radix::Hexadecimal,
        }],
        clock: found.clock,
        clocks_before: 2 * WINDOW,
    };
    write(&save, &save_file(&view))?;

    Ok(FirstDifference {
        simulator: simulator.name().to_owned(),
        segment: case.segment.name.clone(),
        cycle: found.clock,
        signal: format!("{}.{}", design.name(), found.path),
        lane: found.lane,
        network: meaning.network,
        layer: meaning.layer,
        neuron: meaning.neuron,
        input: meaning.input,
        model: code(found.model),
        rtl: show(&found.rtl, code),
        model_real: real(signed(found.model, register.lanes[found.lane])),
        rtl_real: rtl_code.and_then(real),
        note: None,
        window,
        files: vec![dump.to_owned(), model_vcd, save],
    })
}

/// Values of all registers in the first clocks of a case.
fn record(plan: &VerifyPlan<'_>, case: &Case<'_>, clocks: usize) -> Recording {
    let mut model = Model::new(plan.design);
    let mut recording = Recording::new(model.registers());
    let mut row = Vec::new();
    for pins in case.pins(plan).iter().take(clocks) {
        model.step(pins);
        row.clear();
        model.values(&mut row);
        recording.push(&row);
    }
    recording
}

fn signed(code: i64, bits: u32) -> i64 {
    hwgen_spec::format::from_bits(to_bits(code, bits), bits)
}

/// Whether a register or port holds a count, flags or a part of an unsigned product: a number without
/// a sign.
fn is_control(path: &str) -> bool {
    const CONTROL: [&str; 58] = [
        "above_q",
        "above_q2",
        "address_q",
        "address_q2",
        "beat_q",
        "beat_q2",
        "below_q2",
        "busy_q",
        "clip_q3",
        "clipped_q",
        "complete_q",
        "count_q",
        "done_q",
        "done_q2",
        "enable_q",
        "enable_q3",
        "ends_q",
        "error_q",
        "extra_q",
        "first_q",
        "flag_q",
        "flag_q2",
        "gap_q",
        "index_q",
        "last_q",
        "last_q2",
        "last_q3",
        "leave_q",
        "left_q",
        "load_q",
        "more_q",
        "move_q",
        "negative_q",
        "next_q",
        "pipe_q",
        "place_q",
        "put_q",
        "read_q",
        "ready_q",
        "release_q",
        "room_q",
        "short_q3",
        "some_q",
        "start_q",
        "step_q",
        "used_q",
        "used_q2",
        "user_q",
        "valid_q",
        "valid_q2",
        "valid_q3",
        "write_q",
        "rst_nq",
        "rst_q2",
        "s_axis_tready",
        "m_axis_tvalid",
        "m_axis_tuser",
        "m_axis_tlast",
    ];
    CONTROL.contains(&path.rsplit('.').next().unwrap_or(path))
        || path.contains("u_mul.g_pair[")
        || path.contains("u_mul.g_quad[")
}

fn show(value: &RtlValue, code: impl Fn(i64) -> i64) -> String {
    match value {
        RtlValue::Known(value) => code(*value).to_string(),
        RtlValue::Unknown(bits) => bits.clone(),
    }
}

fn dump_scope(design: &str, simulator: Simulator) -> String {
    match simulator {
        Simulator::Icarus => format!("{design}_tb_icarus.u_tb.u_dut"),
        Simulator::Verilator => format!("TOP.{design}_tb.u_dut"),
    }
}
