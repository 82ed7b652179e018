# gate: AMD Vivado, out of context, synthesis to routes. Not run by hwgen.
# Run in an empty directory outside of the bundle: vivado -mode batch -source BUNDLE/syn/gate.vivado.tcl [-tclargs PART]
set root [file normalize [file join [file dirname [info script]] ..]]
set part [expr {$argc > 0 ? [lindex $argv 0] : "xc7a35tcpg236-1"}]
foreach file {
  rtl/gate.v
  rtl/gate_mlp.v
  rtl/gate_net_l0.v
  rtl/gate_net_l0_bias.v
  rtl/gate_net_l0_pe.v
  rtl/gate_net_l0_w0.v
  rtl/gate_net_l1.v
  rtl/gate_net_l1_bias.v
  rtl/gate_net_l1_pe.v
  rtl/gate_net_l1_w0.v
  rtl/gate_net_l1_w1.v
  rtl/gate_tanh11.v
  rtl/hwg_accumulator.v
  rtl/hwg_admit.v
  rtl/hwg_beats.v
  rtl/hwg_count.v
  rtl/hwg_delay.v
  rtl/hwg_drain.v
  rtl/hwg_egress.v
  rtl/hwg_gather.v
  rtl/hwg_group.v
  rtl/hwg_ingress.v
  rtl/hwg_mul.v
  rtl/hwg_pwl.v
  rtl/hwg_queue.v
  rtl/hwg_replay.v
  rtl/hwg_requant.v
  rtl/hwg_slice.v
  rtl/hwg_tree_level.v
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
