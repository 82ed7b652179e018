# line: Intel Quartus Prime, all ports but the clock virtual, synthesis to timing. Not run by hwgen.
# Run in an empty directory outside of the bundle: quartus_sh -t BUNDLE/syn/line.quartus.tcl [DEVICE]
load_package flow
set device [expr {[llength $quartus(args)] > 0 ? [lindex $quartus(args) 0] : "5CSEMA5F31C6"}]
set root [file normalize [file join [file dirname [info script]] ..]]
project_new line -overwrite -part $device
set_global_assignment -name TOP_LEVEL_ENTITY line
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
  set_global_assignment -name VERILOG_FILE $root/$file
}
set_global_assignment -name SDC_FILE $root/constraints/line.sdc
set_instance_assignment -name VIRTUAL_PIN ON -to *
set_instance_assignment -name VIRTUAL_PIN OFF -to aclk
execute_flow -compile
project_close
