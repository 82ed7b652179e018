// SPDX-License-Identifier: MIT OR Apache-2.0
// pair__hwg_hold: offers each beat to an array for some clocks, once for each group of neurons.
//
// Function:  takes a beat at valid_i and offers it FOLDS clocks long; address_o counts the clocks of
//            a frame and is the address of the weights.
// Latency:   a beat is offered from 1 clock after valid_i.
// Overflow:  the beats of the layer in front are FOLDS clocks apart or more.
// Reset:     the next beat is the first of a frame.
// Model:     hwgen: sim/src/model/feed.rs, Hold
`default_nettype none

module pair__hwg_hold #(
  parameter integer BEATS         = 2,  // beats of a frame, 1 or more
  parameter integer FOLDS         = 2,  // clocks of a beat, 2 or more
  parameter integer WIDTH         = 8,  // bits of a beat
  parameter integer ADDRESS_WIDTH = 2   // clog2(BEATS * FOLDS)
) (
  input  wire                     clk_i,
  input  wire                     rst_i,
  input  wire                     valid_i,
  input  wire                     flag_i,
  input  wire [WIDTH-1:0]         words_i,
  output wire                     valid_o,
  output wire                     first_o,  // first beat of a frame
  output wire                     last_o,   // last beat of a frame
  output wire                     flag_o,
  output wire [WIDTH-1:0]         words_o,
  output wire [ADDRESS_WIDTH-1:0] address_o
);
  localparam integer SECOND_BEAT = FOLDS;
  localparam integer LAST_BEAT   = (BEATS - 1) * FOLDS;
  localparam integer LAST        = BEATS * FOLDS - 1;

  reg [WIDTH-1:0]         word_q    = {WIDTH{1'b0}};
  reg [FOLDS-1:0]         left_q    = {FOLDS{1'b0}};  // a one for each clock that is left, from below
  reg [ADDRESS_WIDTH-1:0] address_q = {ADDRESS_WIDTH{1'b0}};
  reg                     flag_q    = 1'b0;

  wire valid = left_q[0];

  always @(posedge clk_i) begin
    if (rst_i) begin
      left_q    <= {FOLDS{1'b0}};
      address_q <= {ADDRESS_WIDTH{1'b0}};
    end else begin
      left_q <= valid_i ? {FOLDS{1'b1}} : left_q >> 1;
      if (valid)
        address_q <= address_q == LAST[ADDRESS_WIDTH-1:0] ? {ADDRESS_WIDTH{1'b0}} : address_q + 1'b1;
    end
  end

  always @(posedge clk_i) begin
    if (valid_i) begin
      word_q <= words_i;
      flag_q <= flag_i;
    end
  end

  // One bit more than the address: a single beat ends beyond it.
  wire [ADDRESS_WIDTH:0] address = {1'b0, address_q};

  assign valid_o   = valid;
  assign first_o   = address < SECOND_BEAT[ADDRESS_WIDTH:0];
  // verilator lint_off UNSIGNED
  // Every clock is of the last beat where a frame has no other.
  assign last_o    = address >= LAST_BEAT[ADDRESS_WIDTH:0];
  // verilator lint_on UNSIGNED
  assign flag_o    = flag_q;
  assign words_o   = word_q;
  assign address_o = address_q;
endmodule

`default_nettype wire
