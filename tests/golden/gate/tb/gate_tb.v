// SPDX-License-Identifier: MIT OR Apache-2.0
// gate_tb: replays a file of pin values on the core, one line a clock
//
// Function: line k of +stimulus=FILE stands on the pins while rising edge k of
//           clk_i comes; pins change at falling edges only, so nothing races.
//           A line is one hexadecimal word, from the top bit:
//           {aresetn, s_axis_tvalid, s_axis_tlast, m_axis_tready, s_axis_tdata}.
//           Whoever wrote the file has computed every pin beforehand: the bench
//           is an open loop and decides nothing, so all simulators see the same.
// Verdict:  `hwgen: replayed N clocks` after the last line, and only then.
// Reset:    the pins are all low, aresetn with them, until the first line is read.
`default_nettype none
`timescale 1ns / 1ps

module gate_tb (
    input wire clk_i
);

  localparam integer SDataBits = 16;
  localparam integer MDataBits = 16;
  localparam integer MUserBits = 2;
  localparam integer PinBits = SDataBits + 4;

  // No stimulus is longer: a file that never ends (a pipe) ends here.
  localparam integer MaxClocks = 100_000_000;

  reg [PinBits-1:0] pins_q = {PinBits{1'b0}};
  reg [PinBits-1:0] line = {PinBits{1'b0}};
  // A number that the run is given and the dump contains, so that no other dump is taken for it.
  reg [63:0] nonce_q = 64'd0;
  reg [8*1024-1:0] path = {8 * 1024{1'b0}};
  integer file = 0;
  integer clocks_q = 0;

  wire s_axis_tready;
  wire [MDataBits-1:0] m_axis_tdata;
  wire m_axis_tvalid;
  wire m_axis_tlast;
  wire [MUserBits-1:0] m_axis_tuser;

  // The outputs are looked at in the dump, not here.
  wire unused_outputs = &{1'b0, s_axis_tready, m_axis_tdata, m_axis_tvalid, m_axis_tlast,
                          m_axis_tuser, nonce_q};

  // The first line has to be there before the first edge, hence read at time 0.
  initial begin
    if ($value$plusargs("nonce=%h", nonce_q) == 0) nonce_q = 64'd0;
    if ($value$plusargs("stimulus=%s", path) == 0) begin
      $display("hwgen: no +stimulus=FILE given");
      $finish;
    end else begin
      file = $fopen(path, "r");
      if (file == 0) begin
        $display("hwgen: the stimulus file cannot be opened");
        $finish;
      end else if ($fscanf(file, "%h", line) == 1) begin
        pins_q = line;
      end else begin
        $display("hwgen: the stimulus file has no first line");
        $finish;
      end
    end
  end

  // The clock's first value, from X to 0 at time 0, is a falling edge too, for Icarus: passed over.
  always @(negedge clk_i) if ($time != 0) begin
    clocks_q <= clocks_q + 1;
    if ($fscanf(file, "%h", line) == 1) begin
      pins_q <= line;
      if (clocks_q + 1 >= MaxClocks) begin
        $display("hwgen: stopped at the limit of %0d clocks", MaxClocks);
        $finish;
      end
    end else begin
      if ($feof(file) != 0) begin
        $display("hwgen: replayed %0d clocks", clocks_q + 1);
      end else begin
        $display("hwgen: line %0d of the stimulus file is no hexadecimal word", clocks_q + 2);
      end
      $finish;
    end
  end

  gate u_dut (
      .aclk(clk_i),
      .aresetn(pins_q[PinBits-1]),
      .s_axis_tdata(pins_q[SDataBits-1:0]),
      .s_axis_tvalid(pins_q[PinBits-2]),
      .s_axis_tready(s_axis_tready),
      .s_axis_tlast(pins_q[PinBits-3]),
      .m_axis_tdata(m_axis_tdata),
      .m_axis_tvalid(m_axis_tvalid),
      .m_axis_tready(pins_q[PinBits-4]),
      .m_axis_tlast(m_axis_tlast),
      .m_axis_tuser(m_axis_tuser)
  );

endmodule

`default_nettype wire
