//! Faults that nothing shows but what was added for them: noise on pins that do not count, pins between
//! edges, crossed conditions, aimed resets, registers that the model lacks.

use hwgen_sim::simulator::Simulator;
use hwgen_sim::stimulus::Effort;

use super::support::Check;
use super::table::Mutant;
use super::{RANDOM, SEED, bundle, hunt_with};

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
        name: "TREADY low while the clock is",
        file: "rtl/hwg_slice.v",
        find: "assign ready_o = ready_q;",
        replace: "assign ready_o = ready_q & clk_i;",
        signal: "mutant.s_axis_tready",
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
        name: "a register wider than the model's",
        file: "rtl/hwg_admit.v",
        find: "reg                 ends_q = 1'b0;",
        replace: "reg [1:0]           ends_q = 2'b0;",
        signal: "mutant.u_mlp.u_admit.ends_q",
    },
];

#[test]
fn every_mutant_that_only_new_stimulus_shows_is_found() {
    let usual = Check {
        random: RANDOM,
        seed: SEED,
        simulators: &[Simulator::Icarus],
        effort: Effort::Usual,
    };
    hunt_with(&usual, MUTANTS, bundle);
}
