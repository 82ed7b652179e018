// SPDX-License-Identifier: MIT OR Apache-2.0
// pair__hwg_beats: counts the beats of a frame that an array consumes as they come.
//
// Function:  address_o is the number of the beat that is, or will next be, offered.
// Latency:   none: the beat and its address belong to the same clock.
// Reset:     the next beat is the first of a frame.
// Model:     hwgen: sim/src/model/feed.rs, Beats
`default_nettype none

module pair__hwg_beats #(
  parameter integer BEATS         = 2,  // beats of a frame, 1 or more
  parameter integer ADDRESS_WIDTH = 1   // max(1, clog2(BEATS))
) (
  input  wire                     clk_i,
  input  wire                     rst_i,
  input  wire                     valid_i,
  output wire                     first_o,
  output wire                     last_o,
  output wire [ADDRESS_WIDTH-1:0] address_o
);
  localparam integer LAST = BEATS - 1;

  reg [ADDRESS_WIDTH-1:0] address_q = {ADDRESS_WIDTH{1'b0}};

  wire last = address_q == LAST[ADDRESS_WIDTH-1:0];

  always @(posedge clk_i) begin
    if (rst_i)        address_q <= {ADDRESS_WIDTH{1'b0}};
    else if (valid_i) address_q <= last ? {ADDRESS_WIDTH{1'b0}} : address_q + 1'b1;
  end

  assign first_o   = address_q == {ADDRESS_WIDTH{1'b0}};
  assign last_o    = last;
  assign address_o = address_q;
endmodule

`default_nettype wire
