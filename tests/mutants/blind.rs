//! Faults that nothing shows but what was added for them: noise on pins that do not count, pins between
//! edges, crossed conditions, aimed resets, registers that the model lacks.

use std::path::{Path, PathBuf};

use hwgen_gen::Source;
use hwgen_sim::simulator::Simulator;
use hwgen_sim::stimulus::Effort;
use hwgen_spec::options::Options;
use hwgen_spec::weights;

use super::support::{Check, emit};
use super::table::Mutant;
use super::{ICARUS, RANDOM, SEED, bundle, hunt_with};

const MUTANTS: &[Mutant] = &[
    Mutant {
        name: "TLAST counts without TVALID",
        file: "rtl/hwg_ingress.v",
        find: "      if (take) begin\n",
        replace: "      if (take | (move_q & beat_last)) begin\n",
        signal: "mutant.u_ingress.index_q",
    },
    Mutant {
        name: "a word of ones counts without TVALID",
        file: "rtl/hwg_slice.v",
        find: "(two | (valid_i & ready_q)",
        replace: "(two | ((valid_i | &data_i) & ready_q)",
        signal: "mutant.u_ingress.u_slice.valid_q",
    },
    Mutant {
        name: "no error on a frame that is clipped too",
        file: "rtl/hwg_egress.v",
        find: "user_q <= {error_i, saturated_i}",
        replace: "user_q <= {error_i & ~saturated_i, saturated_i}",
        signal: "mutant.u_egress.user_q",
    },
    Mutant {
        name: "a place survives a reset",
        file: "rtl/hwg_gather.v",
        find: "    if (rst_i)     place_q <= FIRST;\n    else if (next)",
        replace: "    if (next)",
        signal: "mutant.u_mlp.u_shared_l0_gather.place_q",
    },
    Mutant {
        name: "an output leaves in a reset",
        file: "rtl/hwg_count.v",
        find: "some_next_o = some_d & ~rst_i;",
        replace: "some_next_o = some_d;",
        signal: "mutant.u_mlp.leave_q",
    },
    Mutant {
        name: "a long stall spoils the output",
        file: "rtl/hwg_egress.v",
        find: "  integer i;\n  always @(posedge clk_i) begin\n    if (load_q) user_q <= {error_i, saturated_i};\n",
        replace: "  integer i;\n  reg [6:0] n_q = 7'd0;\n  always @(posedge clk_i) begin\n    n_q <= (tready_i | ~tvalid_o) ? 7'd0 : n_q + {6'd0, ~n_q[6]};\n    if (load_q) user_q <= {error_i, saturated_i | n_q[6]};\n",
        signal: "mutant.u_egress.n_q",
    },
    Mutant {
        name: "gates that keep a value",
        file: "rtl/hwg_egress.v",
        find: "  integer i;\n  always @(posedge clk_i) begin\n    if (load_q) user_q <= {error_i, saturated_i};\n",
        replace: "  wire was;\n  assign was = was | (quiet_i & load_q & error_i & saturated_i);\n  integer i;\n  always @(posedge clk_i) begin\n    if (load_q) user_q <= {error_i, saturated_i & ~was};\n",
        signal: "mutant.u_egress.was",
    },
    Mutant {
        name: "a register in a clock of gates",
        file: "rtl/hwg_slice.v",
        find: "  always @(posedge clk_i) begin\n    valid_q <=",
        replace: "  wire clk_g = clk_i & (valid_i | ~rst_i);\n  always @(posedge clk_g) begin\n    valid_q <=",
        signal: "mutant.u_egress.u_slice.ready_q",
    },
    Mutant {
        name: "a pin that the core should not have",
        file: "rtl/mutant.v",
        find: "module mutant (\n",
        replace: "module mutant (\n  input  wire scan_i,\n",
        signal: "mutant.scan_i",
    },
    Mutant {
        name: "the clock among the data",
        file: "rtl/mutant.v",
        find: "wire quiet = ~(aresetn & rst_nq);",
        replace: "wire quiet = ~(aresetn & (rst_nq | aclk));",
        signal: "mutant.quiet",
    },
    Mutant {
        name: "a table that keeps a value",
        file: "rtl/mutant.v",
        find: "  wire in_take;\n",
        replace: "  wire in_take;\n  reg rom [0:3];\n  initial begin rom[0] = 1'b0; rom[1] = 1'b1; rom[2] = 1'b1; rom[3] = 1'b1; end\n  wire held;\n  assign held = rom[{s_axis_tvalid & (&s_axis_tdata), held & aresetn}];\n  wire unused_held = held;\n",
        signal: "mutant.held",
    },
    Mutant {
        name: "a register wider than the model's",
        file: "rtl/hwg_admit.v",
        find: "reg                 ends_q = 1'b0;",
        replace: "reg [1:0]           ends_q = 2'b0;",
        signal: "mutant.u_mlp.u_admit.ends_q",
    },
];

/// A table of 512 segments, of which random frames read some and a search finds the others.
fn fine_table(directory: &Path, name: &str) -> (PathBuf, Source) {
    let text = include_bytes!("../../designs/tiny/weights.json");
    let net = weights::read(text).expect("readable");
    let options = Options {
        segments: Some(512),
        ..Options::default()
    };
    let bundle = emit(&net, &options, &directory.join(name));
    let source = Source::read(&bundle).expect("a bundle as it was emitted");
    (bundle, source)
}

#[test]
fn a_segment_that_no_random_frame_reads_is_found() {
    let mutant = Mutant {
        name: "a segment of zeros",
        file: "rtl/tiny__tanh12.v",
        find: "9'd199: data_q <= 20'hea285;",
        replace: "9'd199: data_q <= 20'h00000;",
        signal: "tiny.u_mlp.u_brake_l0.g_act[0].u_segments.data_q",
    };
    hunt_with(&USUAL, &[mutant], fine_table);
}

/// Without the structure, which would see the clock among the data.
#[test]
fn an_output_that_falls_with_the_clock_is_found_between_edges() {
    let mutant = Mutant {
        name: "TREADY low while the clock is",
        file: "rtl/hwg_slice.v",
        find: "assign ready_o = ready_q;",
        replace: "assign ready_o = ready_q & clk_i;",
        signal: "mutant.s_axis_tready",
    };
    hunt_with(&ICARUS, &[mutant], bundle);
}

const USUAL: Check<'static> = Check {
    random: RANDOM,
    seed: SEED,
    simulators: &[Simulator::Icarus],
    effort: Effort::Usual,
};

#[test]
fn every_mutant_that_only_new_stimulus_shows_is_found() {
    hunt_with(&USUAL, MUTANTS, bundle);
}
