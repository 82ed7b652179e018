// SPDX-License-Identifier: MIT OR Apache-2.0
// @{ module }@_shell: @{ module }@ between two pins, to be placed and routed alone.
//
// Function:  every input of the core is a bit of a shift register that is fed from one pin; every
//            output is added (modulo 2) into a bit of another one that ends at a pin. So nothing
//            of the core is constant or unused, and no path of it ends at a pin.
// Latency:   does not matter; the shell is not part of the design.
// @{ provenance }@
`default_nettype none

module @{ module }@_shell (
  input  wire clk_i,
  input  wire bit_i,
  output wire bit_o
);
  reg  @{ drive_range }@ drive_q;
  reg  @{ fold_range }@ fold_q;
  wire @{ fold_range }@ seen;

  always @(posedge clk_i) begin
    drive_q <= {drive_q[@{ drive_bits - 2 }@:0], bit_i};
    fold_q  <= {1'b0, fold_q[@{ fold_bits - 1 }@:1]} ^ seen;
  end

  assign bit_o = fold_q[0];

  @{ module }@ u_core (
    .aclk         (clk_i),
    .aresetn      (drive_q[0]),
    .s_axis_tdata (drive_q[@{ s_data_bits + 3 }@:4]),
    .s_axis_tvalid(drive_q[1]),
    .s_axis_tready(seen[0]),
    .s_axis_tlast (drive_q[2]),
    .m_axis_tdata (seen[@{ fold_bits - 1 }@:@{ m_user_bits + 3 }@]),
    .m_axis_tvalid(seen[1]),
    .m_axis_tready(drive_q[3]),
    .m_axis_tlast (seen[2]),
    .m_axis_tuser (seen[@{ m_user_bits + 2 }@:3])
  );
endmodule

`default_nettype wire
