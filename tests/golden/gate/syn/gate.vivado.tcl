# gate: AMD Vivado, out of context, synthesis to routes. Not run by hwgen.
# Run in an empty directory outside of the bundle: vivado -mode batch -source BUNDLE/syn/gate.vivado.tcl [-tclargs PART]
set root [file normalize [file join [file dirname [info script]] ..]]
set part [expr {$argc > 0 ? [lindex $argv 0] : "xc7a35tcpg236-1"}]
foreach file {
  rtl/gate.v
  rtl/gate__hwg_accumulator.v
  rtl/gate__hwg_admit.v
  rtl/gate__hwg_beats.v
  rtl/gate__hwg_count.v
  rtl/gate__hwg_delay.v
  rtl/gate__hwg_drain.v
  rtl/gate__hwg_egress.v
  rtl/gate__hwg_gather.v
  rtl/gate__hwg_group.v
  rtl/gate__hwg_ingress.v
  rtl/gate__hwg_mul.v
  rtl/gate__hwg_pwl.v
  rtl/gate__hwg_queue.v
  rtl/gate__hwg_replay.v
  rtl/gate__hwg_requant.v
  rtl/gate__hwg_slice.v
  rtl/gate__hwg_tree_level.v
  rtl/gate__mlp.v
  rtl/gate__net_l0.v
  rtl/gate__net_l0_bias.v
  rtl/gate__net_l0_pe.v
  rtl/gate__net_l0_w0.v
  rtl/gate__net_l1.v
  rtl/gate__net_l1_bias.v
  rtl/gate__net_l1_pe.v
  rtl/gate__net_l1_w0.v
  rtl/gate__net_l1_w1.v
  rtl/gate__tanh11.v
} {
  read_verilog $root/$file
}
read_xdc -unmanaged $root/constraints/gate.sdc
synth_design -top gate -part $part -mode out_of_context
opt_design
place_design
phys_opt_design
route_design
report_utilization -hierarchical -file utilization.txt
report_timing_summary -file timing.txt
write_checkpoint -force gate.dcp
