# line: AMD Vivado, out of context, synthesis to routes. Not run by hwgen.
# Run in an empty directory outside of the bundle: vivado -mode batch -source BUNDLE/syn/line.vivado.tcl [-tclargs PART]
set root [file normalize [file join [file dirname [info script]] ..]]
set part [expr {$argc > 0 ? [lindex $argv 0] : "xc7a35tcpg236-1"}]
foreach file {
  rtl/line.v
  rtl/line__hwg_admit.v
  rtl/line__hwg_count.v
  rtl/line__hwg_delay.v
  rtl/line__hwg_egress.v
  rtl/line__hwg_gather.v
  rtl/line__hwg_ingress.v
  rtl/line__hwg_mul.v
  rtl/line__hwg_queue.v
  rtl/line__hwg_replay.v
  rtl/line__hwg_requant.v
  rtl/line__hwg_slice.v
  rtl/line__mlp.v
  rtl/line__net_l0.v
  rtl/line__net_l0_bias.v
  rtl/line__net_l0_pe.v
  rtl/line__net_l0_w0.v
} {
  read_verilog $root/$file
}
read_xdc -unmanaged $root/constraints/line.sdc
synth_design -top line -part $part -mode out_of_context
opt_design
place_design
phys_opt_design
route_design
report_utilization -hierarchical -file utilization.txt
report_timing_summary -file timing.txt
write_checkpoint -force line.dcp
