# pair: Intel Quartus Prime, all ports but the clock virtual, synthesis to timing. Not run by hwgen.
# Run in an empty directory outside of the bundle: quartus_sh -t BUNDLE/syn/pair.quartus.tcl [DEVICE]
load_package flow
set device [expr {[llength $quartus(args)] > 0 ? [lindex $quartus(args) 0] : "5CSEMA5F31C6"}]
set root [file normalize [file join [file dirname [info script]] ..]]
project_new pair -overwrite -part $device
set_global_assignment -name TOP_LEVEL_ENTITY pair
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
  set_global_assignment -name VERILOG_FILE $root/$file
}
set_global_assignment -name SDC_FILE $root/constraints/pair.sdc
set_instance_assignment -name VIRTUAL_PIN ON -to *
set_instance_assignment -name VIRTUAL_PIN OFF -to aclk
execute_flow -compile
project_close
