# pair: AMD Vivado, out of context, synthesis to routes. Not run by hwgen.
# Run in an empty directory outside of the bundle: vivado -mode batch -source BUNDLE/syn/pair.vivado.tcl [-tclargs PART]
set root [file normalize [file join [file dirname [info script]] ..]]
set part [expr {$argc > 0 ? [lindex $argv 0] : "xc7a35tcpg236-1"}]
foreach file {
  rtl/pair.v
  rtl/pair__hwg_accumulator.v
  rtl/pair__hwg_admit.v
  rtl/pair__hwg_beats.v
  rtl/pair__hwg_count.v
  rtl/pair__hwg_delay.v
  rtl/pair__hwg_drain.v
  rtl/pair__hwg_egress.v
  rtl/pair__hwg_gather.v
  rtl/pair__hwg_group.v
  rtl/pair__hwg_hold.v
  rtl/pair__hwg_ingress.v
  rtl/pair__hwg_mul.v
  rtl/pair__hwg_pwl.v
  rtl/pair__hwg_queue.v
  rtl/pair__hwg_replay.v
  rtl/pair__hwg_requant.v
  rtl/pair__hwg_slice.v
  rtl/pair__hwg_tree_level.v
  rtl/pair__mlp.v
  rtl/pair__shared_l0.v
  rtl/pair__shared_l0_bias.v
  rtl/pair__shared_l0_pe.v
  rtl/pair__shared_l0_w0.v
  rtl/pair__size_l0.v
  rtl/pair__size_l0_bias.v
  rtl/pair__size_l0_pe.v
  rtl/pair__size_l0_w0.v
  rtl/pair__size_l1.v
  rtl/pair__size_l1_bias.v
  rtl/pair__size_l1_pe.v
  rtl/pair__size_l1_w0.v
  rtl/pair__tanh13.v
  rtl/pair__turn_l0.v
  rtl/pair__turn_l0_bias.v
  rtl/pair__turn_l0_pe.v
  rtl/pair__turn_l0_w0.v
  rtl/pair__turn_l0_w1.v
  rtl/pair__turn_l0_w2.v
  rtl/pair__turn_l1.v
  rtl/pair__turn_l1_bias.v
  rtl/pair__turn_l1_pe.v
  rtl/pair__turn_l1_w0.v
  rtl/pair__turn_out.v
  rtl/pair__turn_out_bias.v
  rtl/pair__turn_out_pe.v
  rtl/pair__turn_out_w0.v
} {
  read_verilog $root/$file
}
read_xdc -unmanaged $root/constraints/pair.sdc
synth_design -top pair -part $part -mode out_of_context
opt_design
place_design
phys_opt_design
route_design
report_utilization -hierarchical -file utilization.txt
report_timing_summary -file timing.txt
write_checkpoint -force pair.dcp
