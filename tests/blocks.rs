//! Cells of a family, simulated, against the portable ones and against other models: multipliers in
//! blocks, pairs of bits and accumulators in carry chains.
//!
//! A bench offers all operands of four bits, and corners and random ones of wider words, to two
//! multipliers at once and compares their products in every clock.

use std::fs;
use std::path::Path;
use std::process::Command;

use hwgen_sim::tool::{ICARUS, Toolbox, VVP, YOSYS};

const PORTABLE: &str = include_str!("../rtl/lib/hwg_mul.v");
const ECP5: [&str; 2] = [
    include_str!("../rtl/devices/ecp5/hwg_mul.v"),
    include_str!("../rtl/devices/ecp5/MULT18X18D.v"),
];
const ICE40: [&str; 2] = [
    include_str!("../rtl/devices/ice40/hwg_mul.v"),
    include_str!("../rtl/devices/ice40/SB_MAC16.v"),
];

const GOWIN: [&str; 2] = [
    include_str!("../rtl/devices/gowin/hwg_mul.v"),
    include_str!("../rtl/devices/gowin/MULT18X18.v"),
];

const NEXUS: [&str; 2] = [
    include_str!("../rtl/devices/nexus/hwg_mul.v"),
    include_str!("../rtl/devices/nexus/MULT18X18.v"),
];

/// The multiplier of adders stands alone.
const LOGIC: [&str; 2] = [include_str!("../rtl/devices/logic/hwg_mul.v"), ""];

const ECP5_CARRY: &str = include_str!("../rtl/devices/ecp5/CCU2C.v");
const PORTABLE_PAIR: &str = include_str!("../rtl/lib/hwg_pair.v");
const ECP5_PAIR: [&str; 2] = [include_str!("../rtl/devices/ecp5/hwg_pair.v"), ECP5_CARRY];

const PORTABLE_ACCUMULATOR: &str = include_str!("../rtl/lib/hwg_accumulator.v");
const ECP5_ACCUMULATOR: [&str; 2] = [
    include_str!("../rtl/devices/ecp5/hwg_accumulator.v"),
    ECP5_CARRY,
];

/// `{other}` and `hwg_mul`, of the same operands.
fn bench(a: u32, b: u32, events: u32, other: &str) -> String {
    format!(
        "module bench;
  localparam A = {a}, B = {b}, EVENTS = {events};
  reg clk = 1'b0;
  reg signed [A-1:0] a = 0;
  reg signed [B-1:0] b = 0;
  wire signed [A+B-1:0] p, q;
  hwg_mul #(.A_WIDTH(A), .B_WIDTH(B)) u_p (.clk_i(clk), .a_i(a), .b_i(b), .p_o(p));
  {other} #(.A_WIDTH(A), .B_WIDTH(B)) u_q (.clk_i(clk), .a_i(a), .b_i(b), .p_o(q));
  integer i, equal = 0, unequal = 0, seen = 0;
  reg [A+B-1:0] draw;
  initial begin
    for (i = 0; i < EVENTS; i = i + 1) begin
      draw = {{$random, $random}};
      // All of them where there are few; else corners: the least and greatest, zero and one.
      if (A + B <= 8) draw = i;
      a = draw[A-1:0];
      b = draw[A+B-1:A];
      if (A + B > 8 && i % 4 == 0) a = i[2] ? {{1'b1, {{(A-1){{1'b0}}}}}} : i[3] ? {{1'b0, {{(A-1){{1'b1}}}}}} : i[4];
      if (A + B > 8 && i % 3 == 0) b = i[4] ? {{1'b1, {{(B-1){{1'b0}}}}}} : i[5] ? {{1'b0, {{(B-1){{1'b1}}}}}} : -i[6];
      #1 clk = 1'b1;
      #1 clk = 1'b0;
      if (i > 2) if (p === q) equal = equal + 1; else unequal = unequal + 1;
      if (p !== 0) seen = seen + 1;
    end
    $display(\"equal %0d unequal %0d nonzero %0d\", equal, unequal, seen);
  end
endmodule
"
    )
}

/// Clocks in which both were equal, in which they were not, and in which there was something.
fn compare(sources: &[String], directory: &Path) -> [u64; 3] {
    let toolbox = Toolbox::new(Path::new(env!("CARGO_MANIFEST_DIR")));
    let files: Vec<_> = sources
        .iter()
        .enumerate()
        .map(|(i, text)| {
            let path = directory.join(format!("{i}.v"));
            fs::write(&path, text).expect("written");
            path
        })
        .collect();
    let compiled = directory.join("bench.vvp");
    let status = Command::new(toolbox.find(&ICARUS).expect("installed").path)
        .args(["-g2012", "-s", "bench", "-o"])
        .arg(&compiled)
        .args(&files)
        .status();
    assert!(status.expect("it runs").success());
    let output = Command::new(toolbox.find(&VVP).expect("installed").path)
        .arg(&compiled)
        .output()
        .expect("it runs");
    let text = String::from_utf8(output.stdout).expect("text");
    let numbers: Vec<u64> = text
        .split_whitespace()
        .filter_map(|w| w.parse().ok())
        .collect();
    numbers.try_into().unwrap_or_else(|_| panic!("{text}"))
}

fn renamed(text: &str, from: &str, to: &str) -> String {
    text.replace(&format!("module {from} "), &format!("module {to} "))
}

fn against_portable(own: &[&str], (a, b): (u32, u32)) -> [u64; 3] {
    let directory = tempfile::tempdir().expect("a directory");
    let mut sources: Vec<String> = own.iter().map(|text| (*text).to_owned()).collect();
    sources.push(renamed(PORTABLE, "hwg_mul", "portable"));
    sources.push(bench(a, b, 20_000, "portable"));
    compare(&sources, directory.path())
}

#[test]
fn a_block_multiplies_like_the_portable_multiplier() {
    for (own, widths) in [
        (ECP5, [(4, 4), (18, 18), (14, 18), (3, 16), (24, 18)]),
        (ICE40, [(4, 4), (16, 16), (16, 14), (3, 12), (18, 16)]),
        (NEXUS, [(4, 4), (18, 18), (14, 18), (3, 16), (24, 18)]),
        (GOWIN, [(4, 4), (18, 18), (14, 18), (24, 18), (36, 22)]),
        (LOGIC, [(4, 4), (5, 3), (16, 14), (3, 17), (24, 2)]),
    ] {
        for (a, b) in widths {
            let [equal, unequal, nonzero] = against_portable(&own, (a, b));
            assert_eq!((equal, unequal), (19_997, 0), "{a} x {b}");
            assert!(nonzero > 1000, "{a} x {b}");
        }
    }
}

#[test]
fn an_unsigned_block_or_a_clock_less_is_seen() {
    let unsigned = ICE40[0].replace(
        ".B_SIGNED                (1'b1)",
        ".B_SIGNED                (1'b0)",
    );
    let early = ECP5[0]
        .replace("r_q <= p_q;", "r_q <= p_i;")
        .replace("assign p_o = r_q;", "assign p_o = p_q;");
    assert!(unsigned != ICE40[0] && early != ECP5[0]);
    let early = early.replace("always @(posedge clk_i) r_q <= p_i;", "");
    let half = NEXUS[0].replace(".SIGNEDB(1'b1)", ".SIGNEDB(1'b0)");
    assert!(half != NEXUS[0]);
    let positive = GOWIN[0].replace(".ASIGN(1'b1)", ".ASIGN(1'b0)");
    assert!(positive != GOWIN[0]);
    let plain = LOGIC[0].replace("low - high", "low + high");
    assert!(plain != LOGIC[0]);
    let wrong = [
        [&unsigned, ICE40[1]],
        [&early, ECP5[1]],
        [&half, NEXUS[1]],
        [&positive, GOWIN[1]],
        [&plain, ""],
    ];
    for own in wrong {
        let [_, unequal, _] = against_portable(&own, (16, 16));
        assert!(unequal > 1000);
    }
}

/// What a script of Yosys writes to `theirs.v`.
fn written_by_yosys(script: &str, directory: &Path) -> String {
    let toolbox = Toolbox::new(Path::new(env!("CARGO_MANIFEST_DIR")));
    let output = Command::new(toolbox.find(&YOSYS).expect("installed").path)
        .args(["-q", "-p", script])
        .current_dir(directory)
        .output()
        .expect("it runs");
    assert!(output.status.success(), "{output:?}");
    fs::read_to_string(directory.join("theirs.v")).expect("written")
}

/// All words and both bits of `hwg_pair` against the portable one of name `portable`.
fn pairs_against_portable(own: &[&str], width: u32) -> [u64; 3] {
    let directory = tempfile::tempdir().expect("a directory");
    let mut sources: Vec<String> = own.iter().map(|text| (*text).to_owned()).collect();
    sources.push(renamed(PORTABLE_PAIR, "hwg_pair", "portable"));
    sources.push(format!(
        "module bench;
  localparam W = {width};
  reg [W+1:0] draw;
  wire [W+1:0] p, q;
  hwg_pair #(.WIDTH(W)) u_p (.a_i(draw[W-1:0]), .b_i(draw[W+1:W]), .p_o(p));
  portable #(.WIDTH(W)) u_q (.a_i(draw[W-1:0]), .b_i(draw[W+1:W]), .p_o(q));
  integer i, equal = 0, unequal = 0, right = 0;
  initial begin
    for (i = 0; i < 1 << (W + 2); i = i + 1) begin
      draw = i;
      #1;
      if (p === q) equal = equal + 1; else unequal = unequal + 1;
      if (q === draw[W-1:0] * draw[W+1:W]) right = right + 1;
    end
    $display(\"equal %0d unequal %0d right %0d\", equal, unequal, right);
  end
endmodule
"
    ));
    compare(&sources, directory.path())
}

#[test]
fn a_carry_chain_multiplies_by_two_bits() {
    for width in [1, 4, 9, 10] {
        let all = 1 << (width + 2);
        assert_eq!(
            pairs_against_portable(&ECP5_PAIR, width),
            [all, 0, all],
            "{width}"
        );
    }
    let wrong = ECP5_PAIR[0].replace(".INIT1    (16'h7888)", ".INIT1    (16'h7880)");
    assert!(wrong != ECP5_PAIR[0]);
    let [_, unequal, _] = pairs_against_portable(&[&wrong, ECP5_PAIR[1]], 9);
    assert!(unequal > 100);
}

/// Random words in `hwg_accumulator` and in the portable one of name `portable`, of words, sums and turns.
fn accumulators_against_portable(own: &[&str], (width, sum, sums): (u32, u32, u32)) -> [u64; 3] {
    let directory = tempfile::tempdir().expect("a directory");
    let mut sources: Vec<String> = own.iter().map(|text| (*text).to_owned()).collect();
    sources.push(renamed(PORTABLE_ACCUMULATOR, "hwg_accumulator", "portable"));
    sources.push(format!(
        "module bench;
  localparam W = {width}, S = {sum}, N = {sums};
  reg clk = 1'b0, enable = 1'b0, first = 1'b0;
  reg [63:0] word;
  wire [S-1:0] p, q;
  hwg_accumulator #(.WIDTH(W), .SUM_WIDTH(S), .SUMS(N)) u_p (.clk_i(clk), .enable_i(enable),
    .first_i(first), .word_i(word[W-1:0]), .sum_o(p));
  portable #(.WIDTH(W), .SUM_WIDTH(S), .SUMS(N)) u_q (.clk_i(clk), .enable_i(enable),
    .first_i(first), .word_i(word[W-1:0]), .sum_o(q));
  integer i, equal = 0, unequal = 0, changes = 0;
  reg [S-1:0] past;
  initial begin
    for (i = 0; i < 4096; i = i + 1) begin
      word = {{$random, $random}};
      enable = $random;
      first = &word[43:40];
      past = q;
      #1 clk = 1'b1;
      #1 clk = 1'b0;
      if (p === q) equal = equal + 1; else unequal = unequal + 1;
      if (q !== past) changes = changes + 1;
    end
    $display(\"equal %0d unequal %0d changes %0d\", equal, unequal, changes);
  end
endmodule
"
    ));
    compare(&sources, directory.path())
}

#[test]
fn a_carry_chain_accumulates() {
    for widths in [(2, 2, 1), (2, 3, 2), (9, 12, 3), (32, 33, 1), (36, 40, 1)] {
        let [equal, unequal, changes] = accumulators_against_portable(&ECP5_ACCUMULATOR, widths);
        assert_eq!((equal, unequal), (4096, 0), "{widths:?}");
        assert!(changes > 1000, "{widths:?}");
    }
    // The old sum is not cleared, or carries are lost.
    for init in ["16'h66AA", "16'hA6A0"] {
        let wrong = ECP5_ACCUMULATOR[0].replace("16'hA6AA", init);
        assert!(wrong != ECP5_ACCUMULATOR[0]);
        let [_, unequal, _] = accumulators_against_portable(&[&wrong, ECP5_CARRY], (9, 12, 1));
        assert!(unequal > 1000, "{init}");
    }
}

/// The model of the carry chain is ours; Yosys has one of its own.
#[test]
fn our_model_of_the_carry_chain_is_equal_to_that_of_yosys() {
    for (init, own) in [
        ("16'h7888", ECP5_PAIR[0]),
        ("16'hA6AA", ECP5_ACCUMULATOR[0]),
    ] {
        let directory = tempfile::tempdir().expect("a directory");
        let script = format!(
            "read_verilog +/ecp5/cells_sim.v; chparam -set INIT0 {init} \
            -set INIT1 {init} -set INJECT1_0 \"NO\" -set INJECT1_1 \"NO\" CCU2C; hierarchy -top CCU2C; \
            rename CCU2C YOSYS_CCU2C; proc; flatten; opt_clean; write_verilog -noattr theirs.v"
        );
        let theirs = written_by_yosys(&script, directory.path());
        assert!(theirs.contains("module YOSYS_CCU2C(") && !theirs.contains("parameter"));
        let (before, rest) = own.split_once("CCU2C #(").expect("an instance");
        let (parameters, after) = rest.split_once(") u_cell").expect("its parameters");
        assert!(parameters.contains(init));
        let body = format!("{before}YOSYS_CCU2C u_cell{after}");
        let found = match init {
            "16'h7888" => (
                pairs_against_portable(&[&body, &theirs], 9),
                [2048, 0, 2048],
            ),
            _ => {
                let own = accumulators_against_portable(&[own, ECP5_CARRY], (9, 12, 1));
                (
                    accumulators_against_portable(&[&body, &theirs], (9, 12, 1)),
                    own,
                )
            }
        };
        assert_eq!(found.0, found.1, "{init}");
    }
}

/// The model of the block is ours; Yosys has one of its own, which takes its parameters here.
#[test]
fn our_model_of_the_ice40_block_is_equal_to_that_of_yosys() {
    let (before, rest) = ICE40[0].split_once("SB_MAC16 #(").expect("an instance");
    let (parameters, after) = rest.split_once(") u_block").expect("its parameters");
    // `.A_REG (1'b1),` becomes `-chparam A_REG 1'b1`.
    let settings: Vec<String> = parameters
        .split(',')
        .map(|setting| {
            let (name, value) = setting.trim().split_once('(').expect("a setting");
            let value = value.trim_end().trim_end_matches(')');
            format!("-chparam {} {value}", name.trim().trim_start_matches('.'))
        })
        .collect();
    let body = renamed(
        &format!("{before}YOSYS_MAC16 u_block{after}"),
        "hwg_mul",
        "theirs",
    );

    let directory = tempfile::tempdir().expect("a directory");
    let script = format!(
        "read_verilog -defer +/ice40/cells_sim.v; hierarchy {} -top SB_MAC16; \
         rename -top YOSYS_MAC16; proc; write_verilog -noattr theirs.v",
        settings.join(" ")
    );
    let theirs = written_by_yosys(&script, directory.path());
    assert!(theirs.contains("module YOSYS_MAC16(") && !theirs.contains("parameter"));
    let mut sources: Vec<String> = ICE40.iter().map(|text| (*text).to_owned()).collect();
    sources.extend([body, theirs, bench(16, 16, 2000, "theirs")]);
    let [equal, unequal, nonzero] = compare(&sources, directory.path());
    assert_eq!((equal, unequal), (1997, 0));
    assert!(nonzero > 500);
}

/// Likewise that of a Nexus, whose model of Yosys's is built of others.
#[test]
fn our_model_of_the_nexus_block_is_equal_to_that_of_yosys() {
    let directory = tempfile::tempdir().expect("a directory");
    let script = "read_verilog +/nexus/cells_sim.v; hierarchy -top MULT18X18; rename MULT18X18 \
        YOSYS_MULT; proc; flatten; opt_clean; write_verilog -noattr theirs.v";
    let theirs = written_by_yosys(script, directory.path());
    assert!(theirs.contains("module YOSYS_MULT(") && !theirs.contains("parameter"));
    let (before, rest) = NEXUS[0].split_once("MULT18X18 #(").expect("an instance");
    let (_, after) = rest.split_once(") u_block").expect("its parameters");
    let body = renamed(
        &format!("{before}YOSYS_MULT u_block{after}"),
        "hwg_mul",
        "theirs",
    );
    let mut sources: Vec<String> = NEXUS.iter().map(|text| (*text).to_owned()).collect();
    sources.extend([body, theirs, bench(18, 18, 2000, "theirs")]);
    let [equal, unequal, nonzero] = compare(&sources, directory.path());
    assert_eq!((equal, unequal), (1997, 0));
    assert!(nonzero > 500);
}
