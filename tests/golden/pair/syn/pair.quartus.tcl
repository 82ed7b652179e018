# pair: Intel Quartus Prime, all ports but the clock virtual, synthesis to timing. Not run by hwgen.
# Run in an empty directory outside of the bundle: quartus_sh -t BUNDLE/syn/pair.quartus.tcl [DEVICE]
load_package flow
set device [expr {[llength $quartus(args)] > 0 ? [lindex $quartus(args) 0] : "5CSEMA5F31C6"}]
set root [file normalize [file join [file dirname [info script]] ..]]
project_new pair -overwrite -part $device
set_global_assignment -name TOP_LEVEL_ENTITY pair
foreach file {
  rtl/hwg_accumulator.v
  rtl/hwg_admit.v
  rtl/hwg_beats.v
  rtl/hwg_count.v
  rtl/hwg_delay.v
  rtl/hwg_drain.v
  rtl/hwg_egress.v
  rtl/hwg_gather.v
  rtl/hwg_group.v
  rtl/hwg_hold.v
  rtl/hwg_ingress.v
  rtl/hwg_mul.v
  rtl/hwg_pwl.v
  rtl/hwg_queue.v
  rtl/hwg_replay.v
  rtl/hwg_requant.v
  rtl/hwg_slice.v
  rtl/hwg_tree_level.v
  rtl/pair.v
  rtl/pair_mlp.v
  rtl/pair_shared_l0.v
  rtl/pair_shared_l0_bias.v
  rtl/pair_shared_l0_pe.v
  rtl/pair_shared_l0_w0.v
  rtl/pair_size_l0.v
  rtl/pair_size_l0_bias.v
  rtl/pair_size_l0_pe.v
  rtl/pair_size_l0_w0.v
  rtl/pair_size_l1.v
  rtl/pair_size_l1_bias.v
  rtl/pair_size_l1_pe.v
  rtl/pair_size_l1_w0.v
  rtl/pair_tanh13.v
  rtl/pair_turn_l0.v
  rtl/pair_turn_l0_bias.v
  rtl/pair_turn_l0_pe.v
  rtl/pair_turn_l0_w0.v
  rtl/pair_turn_l0_w1.v
  rtl/pair_turn_l0_w2.v
  rtl/pair_turn_l1.v
  rtl/pair_turn_l1_bias.v
  rtl/pair_turn_l1_pe.v
  rtl/pair_turn_l1_w0.v
  rtl/pair_turn_out.v
  rtl/pair_turn_out_bias.v
  rtl/pair_turn_out_pe.v
  rtl/pair_turn_out_w0.v
} {
  set_global_assignment -name VERILOG_FILE $root/$file
}
set_global_assignment -name SDC_FILE $root/constraints/pair.sdc
set_instance_assignment -name VIRTUAL_PIN ON -to *
set_instance_assignment -name VIRTUAL_PIN OFF -to aclk
execute_flow -compile
project_close
