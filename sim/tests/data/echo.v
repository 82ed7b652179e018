// SPDX-License-Identifier: MIT OR Apache-2.0
// echo: a core with the ports and the naming of an emitted one, small enough to model in a test
//
// Function: sums its input words in several lanes, lane i weighing them by i + 1;
//           the last word of a frame puts the sum of lane 0 on the output,
//           plus the parity of all lanes.
`default_nettype none

module echo (
    input  wire        aclk,
    input  wire        aresetn,
    input  wire [15:0] s_axis_tdata,
    input  wire        s_axis_tvalid,
    output wire        s_axis_tready,
    input  wire        s_axis_tlast,
    output wire [23:0] m_axis_tdata,
    output wire        m_axis_tvalid,
    input  wire        m_axis_tready,
    output wire        m_axis_tlast,
    output wire [ 0:0] m_axis_tuser
);

  localparam integer Lanes = 20;

  reg  [2:0] count_q;
  reg        valid_q;
  reg [23:0] data_q;

  // Wider than the 256 bits up to which Verilator traces unless told otherwise.
  wire [Lanes*24-1:0] sums;

  wire take = s_axis_tvalid && s_axis_tready;

  assign s_axis_tready = !valid_q || m_axis_tready;
  assign m_axis_tdata  = data_q;
  assign m_axis_tvalid = valid_q;
  assign m_axis_tlast  = valid_q;
  assign m_axis_tuser  = count_q[0];

  always @(posedge aclk) begin
    if (!aresetn) begin
      count_q <= 3'd0;
      valid_q <= 1'b0;
      data_q  <= 24'd0;
    end else begin
      if (take) begin
        count_q <= count_q + 3'd1;
        data_q  <= sums[23:0] + {23'd0, ^sums};
      end
      if (take && s_axis_tlast) valid_q <= 1'b1;
      else if (m_axis_tready) valid_q <= 1'b0;
    end
  end

  echo_sums #(
      .LANES(Lanes)
  ) u_sums (
      .clk_i (aclk),
      .rst_ni(aresetn),
      .take_i(take),
      .word_i(s_axis_tdata),
      .sums_o(sums)
  );

endmodule

`default_nettype wire
