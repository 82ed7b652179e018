# gate: Intel Quartus Prime, all ports but the clock virtual, synthesis to timing. Not run by hwgen.
# Run in an empty directory outside of the bundle: quartus_sh -t BUNDLE/syn/gate.quartus.tcl [DEVICE]
load_package flow
set device [expr {[llength $quartus(args)] > 0 ? [lindex $quartus(args) 0] : "5CSEMA5F31C6"}]
set root [file normalize [file join [file dirname [info script]] ..]]
project_new gate -overwrite -part $device
set_global_assignment -name TOP_LEVEL_ENTITY gate
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
  set_global_assignment -name VERILOG_FILE $root/$file
}
set_global_assignment -name SDC_FILE $root/constraints/gate.sdc
set_instance_assignment -name VIRTUAL_PIN ON -to *
set_instance_assignment -name VIRTUAL_PIN OFF -to aclk
execute_flow -compile
project_close
